// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// Loops over threads, and over the images of a collection.

#ifndef OPENCV_AQORB_IMAGE_LOOP_HPP
#define OPENCV_AQORB_IMAGE_LOOP_HPP

#include <opencv2/core.hpp>
#include <opencv2/core/utility.hpp>

#include <algorithm>
#include <atomic>
#include <exception>
#include <mutex>

namespace cv
{
namespace aqorb
{

//! How many threads a call that this thread begins may use.
int threadsAllowed();

/** Goes over the images of a collection, or over other pieces of work, with several threads. Each thread takes the next
 image in order and completes it, so every image before one that fails is processed, too, and the error that counts is
 always that of the first image that fails. */
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

    //! Throws the error of the first image that has failed, as it is. To be called when all threads have ended.
    void rethrow() const
    {
        if (error)
            std::rethrow_exception(error);
    }

    //! The same, but an error of OpenCV's gets the index of the image.
    void check() const
    {
        try
        {
            rethrow();
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

/** Calls work(i, thread) for every i below count, on at most so many threads. Each of them takes the next
 i until none is left, and has a number of its own. When all have ended, the error of the lowest i is thrown. */
template <typename Work> void forEach(size_t count, int most, const Work& work)
{
    const int threads = int(std::min(size_t(most), count));
    ImageLoop loop(count);
    std::atomic<int> next(0);
    const auto run = [&](const Range&)
    {
        const int thread = next++;
        loop.work([&](size_t i) { work(i, thread); });
    };
    if (threads <= 1)
        run(Range());
    else
        parallel_for_(Range(0, threads), run, threads);
    loop.rethrow();
}

}  // namespace aqorb
}  // namespace cv

#endif
