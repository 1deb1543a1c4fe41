// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#ifndef OPENCV_AQORB_TEST_BACKENDS_HPP
#define OPENCV_AQORB_TEST_BACKENDS_HPP

#include "test_precomp.hpp"

#include <opencv2/core/parallel/parallel_backend.hpp>

#include <atomic>
#include <chrono>
#include <future>
#include <memory>
#include <thread>

// Backends of cv::parallel_for_ that do with its stripes whatever a backend may do.

namespace opencv_test
{

//! A way to run the stripes of cv::parallel_for_.
class Backend : public parallel::ParallelForAPI
{
public:
    int getThreadNum() const CV_OVERRIDE { return 0; }
    int getNumThreads() const CV_OVERRIDE { return threads; }
    int setNumThreads(int count) CV_OVERRIDE { return threads.exchange(std::max(count, 1)); }
    const char* getName() const CV_OVERRIDE { return "test"; }

private:
    std::atomic<int> threads{2};
};

//! Runs one stripe after the other.
class InTurns : public Backend
{
public:
    explicit InTurns(bool isReversed_ = false) : isReversed(isReversed_) {}
    void parallel_for(int stripes, FN_parallel_for_body_cb_t body, void* data) CV_OVERRIDE
    {
        for (int i = 0; i < stripes; i++)
        {
            const int stripe = isReversed ? stripes - 1 - i : i;
            body(stripe, stripe + 1, data);
        }
    }

private:
    const bool isReversed;
};

//! Counts how often cv::parallel_for_ asks for threads, and the largest number of them.
class Counting : public InTurns
{
public:
    void parallel_for(int stripes, FN_parallel_for_body_cb_t body, void* data) CV_OVERRIDE
    {
        calls++;
        maxStripes = std::max(maxStripes, stripes);
        InTurns::parallel_for(stripes, body, data);
    }
    int calls = 0, maxStripes = 0;
};

//! Runs all stripes as one.
class AtOnce : public Backend
{
public:
    void parallel_for(int stripes, FN_parallel_for_body_cb_t body, void* data) CV_OVERRIDE
    {
        body(0, stripes, data);
    }
};

//! Runs the stripes on new threads, of which each begins later than the one before.
class NewThreads : public Backend
{
public:
    explicit NewThreads(int delay_ = 0) : delay(delay_) {}
    void parallel_for(int stripes, FN_parallel_for_body_cb_t body, void* data) CV_OVERRIDE
    {
        std::promise<void> start;
        const std::shared_future<void> started = start.get_future().share();
        std::atomic<int> next(0);
        const auto work = [&, started](int thread)
        {
            started.wait();
            std::this_thread::sleep_for(std::chrono::microseconds(thread * delay));
            for (int stripe = next++; stripe < stripes; stripe = next++)
                body(stripe, stripe + 1, data);
        };
        std::vector<std::future<void>> others;
        for (int i = 0; i < std::min(getNumThreads(), stripes); i++)
            others.push_back(std::async(std::launch::async, work, i));
        start.set_value();
        for (std::future<void>& other : others)
            other.get();  // raises what its thread raised: OpenCV itself allocates memory, too
    }

private:
    const int delay;
};

//! Has another number of threads each time that it is asked, as if the program called cv::setNumThreads meanwhile.
class OtherThreads : public NewThreads
{
public:
    int getNumThreads() const CV_OVERRIDE { return queries++ % 16 + 1; }

private:
    mutable std::atomic<int> queries{0};
};

//! Replaces the backend of cv::parallel_for_ until it goes out of scope.
class BackendScope
{
public:
    explicit BackendScope(const std::shared_ptr<Backend>& backend) { set(backend); }
    ~BackendScope() { set(std::shared_ptr<Backend>()); }
    BackendScope(const BackendScope&) = delete;

private:
    static void set(std::shared_ptr<Backend> backend)
    {
#if defined(__SANITIZE_THREAD__)
        if (!backend)
            backend = std::make_shared<NewThreads>();  // which it sees
#endif
        parallel::setParallelForBackend(backend, false);
    }
};

//! A null pointer for OpenCV's own backend, and the others.
inline std::vector<std::shared_ptr<Backend>> backends()
{
    return {std::shared_ptr<Backend>(),      std::make_shared<InTurns>(),
            std::make_shared<InTurns>(true), std::make_shared<AtOnce>(),
            std::make_shared<NewThreads>(),  std::make_shared<NewThreads>(300),
            std::make_shared<OtherThreads>()};
}

}  // namespace opencv_test

#endif
