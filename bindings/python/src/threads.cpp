// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "threads.hpp"

#include <pybind11/pybind11.h>

#include <opencv2/core/utility.hpp>

#include <pthread.h>

#ifdef AQORB_BUNDLE_OPENCV
#include <opencv2/core/parallel/parallel_backend.hpp>

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <system_error>
#include <thread>
#include <vector>
#endif

namespace aqorb_python
{

namespace
{

// Calls hold it as readers; a fork and a change of the number of threads as writers.
pthread_rwlock_t calls = PTHREAD_RWLOCK_INITIALIZER;

#ifdef AQORB_BUNDLE_OPENCV

thread_local int threadNumber = 0;  // 0 is a thread that calls

// Threads that wait for work. OpenCV runs one loop at a time.
class Workers
{
public:
    typedef cv::parallel::ParallelForAPI::FN_parallel_for_body_cb_t Body;

    explicit Workers(int count_)
        : count(count_),
          generation(0),
          ends(false),
          body(nullptr),
          data(nullptr),
          tasks(0),
          next(0),
          active(0)
    {
    }

    ~Workers()
    {
        {
            std::lock_guard<std::mutex> lock(mutex);
            ends = true;
            generation++;
        }
        wake.notify_all();
        for (std::thread& thread : started)
            thread.join();
    }

    void run(int tasks_, Body body_, void* data_)
    {
        {
            std::lock_guard<std::mutex> lock(mutex);
            start(std::min(count, tasks_ - 1));
            body = body_;
            data = data_;
            tasks = tasks_;
            next = 0;
            generation++;
        }
        wake.notify_all();
        runTasks(body_, data_, tasks_);
        std::unique_lock<std::mutex> lock(mutex);
        body = nullptr;  // who has not begun comes too late
        for (int i = 0; i < PATIENCE && active > 0; i++)
        {
            lock.unlock();
            std::this_thread::yield();
            lock.lock();
        }
        done.wait(lock, [this] { return active == 0; });
    }

private:
    // How often a thread looks for work before it sleeps, as waking takes longer than the next loop is away.
    static const int PATIENCE = 200;

    // Starts threads until there are so many, or as many as the system lets the process have.
    void start(int wanted)
    {
        try
        {
            while (int(started.size()) < wanted)
            {
                const int number = int(started.size()) + 1;
                const unsigned seen = generation.load();
                started.emplace_back([this, number, seen] { work(number, seen); });
            }
        }
        catch (const std::system_error&)
        {
        }
    }

    void work(int number, unsigned seen)
    {
        threadNumber = number;
        for (;;)
        {
            for (int i = 0; i < PATIENCE && generation.load() == seen; i++)
                std::this_thread::yield();
            std::unique_lock<std::mutex> lock(mutex);
            wake.wait(lock, [&] { return generation.load() != seen; });
            seen = generation.load();
            if (ends)
                return;
            if (!body)
                continue;
            active++;
            const Body body_ = body;
            void* const data_ = data;
            const int tasks_ = tasks;
            lock.unlock();
            runTasks(body_, data_, tasks_);
            lock.lock();
            if (--active == 0)
                done.notify_one();
        }
    }

    // OpenCV's body throws nothing: it keeps an exception for the thread that calls.
    void runTasks(Body body_, void* data_, int tasks_)
    {
        for (int task = next++; task < tasks_; task = next++)
            body_(task, task + 1, data_);
    }

    const int count;
    std::mutex mutex;
    std::condition_variable wake, done;
    std::vector<std::thread> started;
    std::atomic<unsigned> generation;
    bool ends;
    Body body;
    void* data;
    int tasks;
    std::atomic<int> next;
    int active;
};

// The threads of the OpenCV that is linked in. Those that wait when the process exits are left to it.
class Threads : public cv::parallel::ParallelForAPI
{
public:
    void parallel_for(int tasks, FN_parallel_for_body_cb_t body, void* data) override
    {
        if (!workers)
            workers = new Workers(number - 1);
        workers->run(tasks, body, data);
    }
    int getThreadNum() const override { return threadNumber; }
    int getNumThreads() const override { return number; }
    int setNumThreads(int threads) override
    {
        const int before = number;
        number = std::max(threads, 1);
        if (number != before)
        {
            delete workers;
            workers = nullptr;
        }
        return before;
    }
    const char* getName() const override { return "aqorb"; }

    //! In a child process there are none. The next call starts others.
    void forget() { workers = nullptr; }

private:
    Workers* workers = nullptr;
    int number = 1;
};

Threads* threads = nullptr;

bool useThreads()
{
    threads = new Threads;  // never deleted: other threads may call until the process ends
    cv::parallel::setParallelForBackend(std::shared_ptr<Threads>(threads, [](Threads*) {}), false);
    cv::setNumThreads(-1);
    return true;
}

void forgetThreads()
{
    threads->forget();
}

#else

// Those of the OpenCV that the package shares with cv2.
bool useThreads()
{
    return false;
}

void forgetThreads()
{
}

#endif

void waitForCalls()
{
    pthread_rwlock_wrlock(&calls);
}

void afterForkInParent()
{
    pthread_rwlock_unlock(&calls);
}

void afterForkInChild()
{
    const pthread_rwlock_t unlocked = PTHREAD_RWLOCK_INITIALIZER;
    calls = unlocked;
    forgetThreads();
}

}  // namespace

bool prepareThreads()
{
    const bool own = useThreads();
    pthread_atfork(&waitForCalls, &afterForkInParent, &afterForkInChild);
    // A daemon thread may be in a call when the interpreter ends. The objects that the library uses are destroyed next.
    Py_AtExit(&waitForCalls);
    return own;
}

int getNumThreads()
{
    return cv::getNumThreads();
}

void setNumThreads(int number)
{
    pthread_rwlock_wrlock(&calls);
    cv::setNumThreads(number);
    pthread_rwlock_unlock(&calls);
}

Call::Call()
{
    pthread_rwlock_rdlock(&calls);
}

Call::~Call()
{
    pthread_rwlock_unlock(&calls);
}

}  // namespace aqorb_python
