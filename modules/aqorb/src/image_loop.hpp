// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#ifndef OPENCV_AQORB_IMAGE_LOOP_HPP
#define OPENCV_AQORB_IMAGE_LOOP_HPP

#include <opencv2/core.hpp>

#include <atomic>
#include <exception>
#include <mutex>

namespace cv
{
namespace aqorb
{

/** Goes over the images of a collection. Several threads may do so at once, each of which takes the next image. They take
 images in their order and end what they have begun, so the first image that fails is always the same. */
class ImageLoop
{
public:
    explicit ImageLoop(size_t count) : next(0), end(count) {}

    //! Processes images until none is left, or one has failed. Each thread calls it. It throws nothing.
    template <typename Process> void work(const Process& process)
    {
        for (size_t i = next++; i < end; i = next++)
        {
            try
            {
                process(i);
            }
            catch (...)
            {
                const std::lock_guard<std::mutex> lock(mutex);
                if (i < end)
                {
                    end = i;
                    error = std::current_exception();
                }
            }
        }
    }

    //! Throws the error of the first image that has failed, when all threads have ended. OpenCV's errors get its index.
    void check() const
    {
        try
        {
            if (error)
                std::rethrow_exception(error);
        }
        catch (const Exception& thrown)
        {
            throw Exception(thrown.code, format("images[%d]: %s", int(end), thrown.err.c_str()), thrown.func,
                            thrown.file, thrown.line);
        }
    }

private:
    std::atomic<size_t> next, end;
    std::mutex mutex;
    std::exception_ptr error;
};

}  // namespace aqorb
}  // namespace cv

#endif
