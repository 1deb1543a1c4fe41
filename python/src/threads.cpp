// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "threads.hpp"

#include <pybind11/pybind11.h>

#include <opencv2/core/parallel/parallel_backend.hpp>
#include <opencv2/core/utility.hpp>

#ifndef _WIN32
#include <pthread.h>
#endif

#include <atomic>
#include <chrono>
#include <memory>
#include <thread>

namespace aqorb_python
{

namespace
{

// A forked child has none of OpenCV's worker threads. A parallel loop would wait for them forever, so it runs on one
// thread.
class OneThread : public cv::parallel::ParallelForAPI
{
public:
    void parallel_for(int tasks, FN_parallel_for_body_cb_t body, void* data) override
    {
        body(0, tasks, data);
    }
    int getThreadNum() const override { return 0; }
    int getNumThreads() const override { return 1; }
    int setNumThreads(int) override { return 1; }
    const char* getName() const override { return "aqorb"; }
};

// These objects are never destroyed: threads may call until the process ends.
const std::shared_ptr<OneThread>& oneThread = *new std::shared_ptr<OneThread>(new OneThread);
std::mutex& sharingMutex = *new std::mutex;
std::mutex& beginningMutex = *new std::mutex;  // blocks the begin of calls

std::atomic<int> calls(0);  // number of running calls
std::atomic<bool> isChild(false);

#ifndef _WIN32  // Windows has no fork

void beforeFork()
{
    beginningMutex.lock();
    sharingMutex.lock();
}

void afterForkInParent()
{
    sharingMutex.unlock();
    beginningMutex.unlock();
}

void afterForkInChild()
{
    sharingMutex.unlock();
    beginningMutex.unlock();
    calls = 0;
    isChild = true;
    cv::parallel::setParallelForBackend(oneThread, false);
}

#endif

// Waits for daemon threads in calls before the exit destroys the library's objects.
void waitForCalls()
{
    while (calls > 0)
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
}

}  // namespace

void prepareThreads()
{
    // Once, even if Python imports the module again after an error.
    static const bool isPrepared = Py_AtExit(&waitForCalls) == 0
#ifndef _WIN32
                                   && pthread_atfork(&beforeFork, &afterForkInParent, &afterForkInChild) == 0
#endif
        ;
    if (!isPrepared)
        throw pybind11::import_error("aqorb cannot register its functions for the exit and for forks");
}

std::mutex& sharing()
{
    return sharingMutex;
}

// cv::setNumThreads replaces OpenCV's threads, and a loop that runs on these would crash. A child does nothing: its
// locks that those threads held at the fork stay locked forever.
void setNumThreads(int count)
{
    const int MAX_THREADS = 8192;  // Linux has no more processors, and TBB crashes from 65,536 threads on
    if (count > MAX_THREADS)
        CV_Error_(cv::Error::StsOutOfRange, ("nthreads must be at most %d, got %d", MAX_THREADS, count));
    if (isChild)
        return;
    const std::lock_guard<std::mutex> lock(beginningMutex);
    waitForCalls();
    cv::setNumThreads(count);
}

PyThreadState* releaseGil()
{
    {
        const std::lock_guard<std::mutex> lock(beginningMutex);
        calls++;
    }
    return PyEval_SaveThread();
}

// At the interpreter's exit Python ends a daemon thread here by unwinding its stack, which would release Python objects
// without the lock. The thread sleeps until the process ends instead, as in Python 3.14.
void acquireGil(PyThreadState* thread)
{
    calls--;
    try
    {
        PyEval_RestoreThread(thread);
    }
    catch (...)
    {
        for (;;)
            std::this_thread::sleep_for(std::chrono::hours(1));
    }
}

}  // namespace aqorb_python
