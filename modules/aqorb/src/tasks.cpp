// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "precomp.hpp"

#include "tasks.hpp"

#include <opencv2/aqorb.hpp>

#include <thread>

namespace cv
{
namespace aqorb
{

static thread_local bool isAlone = false;

SingleThreadScope::SingleThreadScope() : before(isAlone)
{
    isAlone = true;
}

SingleThreadScope::~SingleThreadScope()
{
    isAlone = before;
}

int TaskQueue::threadsAllowed()
{
    return isAlone ? 1 : std::max(getNumThreads(), 1);
}

int TaskQueue::threadsInUse()
{
    const int MOST = 16;  // more would wait for each other most of the time
    return std::min(threadsAllowed(), MOST);
}

void TaskQueue::put(int priority, const Task& task)
{
    const std::lock_guard<std::mutex> lock(mutex);
    ready.push_back({priority, number++, task});
    std::push_heap(ready.begin(), ready.end());
    if (waiting > 0)
        changed.notify_one();
}

void TaskQueue::run(int threads, TaskRunner& runner_)
{
    runner = &runner_;
    running = waiting = workers = 0;
    error = std::exception_ptr();
    if (threads == 1)
    {
        work();
    }
    else
    {
        // The function captures one pointer only, because std::function would allocate memory for more.
        parallel_for_(
            Range(0, threads), [this](const Range&) { work(); }, threads);
    }
    clear();
    if (error)
        std::rethrow_exception(error);
}

void TaskQueue::clear()
{
    ready.clear();
    number = 0;
}

void TaskQueue::work()
{
    std::unique_lock<std::mutex> lock(mutex);
    // Where a thread is given several stripes, the first one leaves nothing to do.
    const int worker = workers++;
    for (;;)
    {
        if (ready.empty() && running > 0)
            waitForTask(lock);
        if (ready.empty())
            return;  // nothing is being done, so nothing more becomes ready
        runNext(lock, worker);
    }
}

void TaskQueue::runNext(std::unique_lock<std::mutex>& lock, int worker)
{
    std::pop_heap(ready.begin(), ready.end());
    const Task task = ready.back().task;
    ready.pop_back();
    running++;
    lock.unlock();
    std::exception_ptr thrown;
    try
    {
        runner->run(task, worker);
    }
    catch (...)
    {
        thrown = std::current_exception();
    }
    lock.lock();
    running--;
    if (thrown && !error)
        error = thrown;
    if (error)
        ready.clear();
    if (ready.empty() && running == 0 && waiting > 0)
        changed.notify_all();
}

void TaskQueue::waitForTask(std::unique_lock<std::mutex>& lock)
{
    // Waking up takes as long as many a task, so the worker looks a few times before it goes to sleep. In between it
    // leaves the CPU to whatever else wants to run.
    const int LOOKS = 50;
    for (int i = 0; i < LOOKS && ready.empty() && running > 0; i++)
    {
        lock.unlock();
        std::this_thread::yield();
        lock.lock();
    }
    waiting++;
    while (ready.empty() && running > 0)
        changed.wait(lock);
    waiting--;
}

}  // namespace aqorb
}  // namespace cv
