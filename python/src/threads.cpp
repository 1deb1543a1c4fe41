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

// Loops of OpenCV in a child process: those that would run them are not in it, and it would wait for them for ever.
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

// None is ever destroyed: threads may call until the process ends.
const std::shared_ptr<OneThread>& oneThread = *new std::shared_ptr<OneThread>(new OneThread);
std::mutex& sharingMutex = *new std::mutex;
std::mutex& beginningMutex = *new std::mutex;  // while it is held no call begins

std::atomic<int> calls(0);  // that are under way
std::atomic<bool> isChild(false);

#ifndef _WIN32  // where processes do not fork

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

// A daemon thread may be in a call when the interpreter ends. The objects that the library uses are destroyed next.
void waitForCalls()
{
    while (calls > 0)
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
}

}  // namespace

void prepareThreads()
{
#ifndef _WIN32
    pthread_atfork(&beforeFork, &afterForkInParent, &afterForkInChild);
#endif
    Py_AtExit(&waitForCalls);
}

std::mutex& sharing()
{
    return sharingMutex;
}

// OpenCV ends its threads and makes new ones, and a loop that runs on them would crash. A child has none of them, and
// what they held when it was forked is held for ever.
void setNumThreads(int count)
{
    const int MOST = 8192;  // Linux has no more processors, and TBB crashes from 65,536 threads on
    if (count > MOST)
        CV_Error_(cv::Error::StsOutOfRange, ("nthreads must be at most %d, got %d", MOST, count));
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

// At the interpreter's exit Python ends a daemon thread here by unwinding its stack. That would release Python objects
// without the lock, so such a thread sleeps until the process ends, as Python 3.14 has it.
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
