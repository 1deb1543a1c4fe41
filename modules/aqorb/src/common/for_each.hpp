// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// Threads that share the work of a stage or the images of a collection.

#ifndef OPENCV_AQORB_FOR_EACH_HPP
#define OPENCV_AQORB_FOR_EACH_HPP

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

//! Number of threads that a call from this thread may use.
int threadsAllowed();
//! Number of threads that share a stage. More threads would mostly wait for each other.
inline int stageThreads()
{
    return std::min(threadsAllowed(), 16);
}

/** Calls work(i, thread) for each i below count, on at most maxThreads threads. `thread` numbers the threads; each
 takes the next i until none is left. After an exception no thread begins another i. All calls with a lower i complete,
 so the exception of the lowest failing i is thrown, whatever the number of threads. */
template <typename Work> void forEach(size_t count, int maxThreads, const Work& work)
{
    std::atomic<size_t> next(0), end(count);
    std::atomic<int> nextThread(0);
    std::mutex mutex;
    std::exception_ptr error;
    const auto run = [&](const Range&)
    {
        const int thread = nextThread++;
        for (size_t i = next++; i < end; i = next++)
        {
            try
            {
                work(i, thread);
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
    };
    const int threads = int(std::min(size_t(maxThreads), count));
    if (threads <= 1)
        run(Range());
    else
        parallel_for_(Range(0, threads), run, threads);
    if (error)
        std::rethrow_exception(error);
}

}  // namespace aqorb
}  // namespace cv

#endif
