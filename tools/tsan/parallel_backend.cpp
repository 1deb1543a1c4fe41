// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// Part of the tests where they are built for the thread sanitizer: runs cv::parallel_for_ on std::thread.
// OpenCV's own pools hand work over by means that the sanitizer cannot see in a library that is not
// instrumented, and so takes for races.

#include <opencv2/core/parallel/parallel_backend.hpp>
#include <opencv2/core/utility.hpp>

#include <atomic>
#include <thread>
#include <vector>

namespace
{

thread_local int threadNumber = 0;

class StdThreads CV_FINAL : public cv::parallel::ParallelForAPI
{
public:
    void parallel_for(int tasks, FN_parallel_for_body_cb_t body, void* data) CV_OVERRIDE
    {
        std::atomic<int> next(0);
        const auto work = [&](int number)
        {
            threadNumber = number;
            for (int task = next++; task < tasks; task = next++)
                body(task, task + 1, data);
        };

        std::vector<std::thread> others;
        for (int i = 1; i < std::min(threads.load(), tasks); i++)
            others.emplace_back(work, i);
        work(0);
        for (std::thread& other : others)
            other.join();
    }

    int getThreadNum() const CV_OVERRIDE { return threadNumber; }
    int getNumThreads() const CV_OVERRIDE { return threads; }
    int setNumThreads(int number) CV_OVERRIDE
    {
        return threads.exchange(number > 0 ? number : cv::getNumberOfCPUs());
    }
    const char* getName() const CV_OVERRIDE { return "std::thread"; }

private:
    std::atomic<int> threads{cv::getNumberOfCPUs()};
};

struct Installer
{
    Installer() { cv::parallel::setParallelForBackend(std::make_shared<StdThreads>(), false); }
} installer;

}  // namespace
