// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "threads.hpp"

#include "image_loop.hpp"

#include <pybind11/pybind11.h>

#include <opencv2/aqorb.hpp>

#include <opencv2/core/utility.hpp>

#ifndef _WIN32
#include <pthread.h>
#endif

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <new>
#include <thread>
#include <vector>

#ifdef AQORB_BUNDLE_OPENCV
#include <opencv2/core/parallel/parallel_backend.hpp>

#include <atomic>
#include <memory>
#include <system_error>
#endif

namespace aqorb_python
{

namespace py = pybind11;

namespace
{

// The calls of the library that are under way. A fork and a change of the number of threads wait until there are none, and
// calls that begin later wait for them.
class Calls
{
public:
    void begin()
    {
        std::unique_lock<std::mutex> lock(mutex);
        changed.wait(lock, [this] { return stopping == 0; });
        running++;
    }

    void end()
    {
        std::lock_guard<std::mutex> lock(mutex);
        if (--running == 0 && stopping > 0)
            changed.notify_all();
    }

    void stop()
    {
        std::unique_lock<std::mutex> lock(mutex);
        stopping++;
        changed.wait(lock, [this] { return running == 0 && !stopped; });
        stopped = true;
    }

    void resume()
    {
        std::lock_guard<std::mutex> lock(mutex);
        stopping--;
        stopped = false;
        changed.notify_all();
    }

private:
    std::mutex mutex;
    std::condition_variable changed;
    int running = 0;
    int stopping = 0;  // how many want that there are no calls; one at a time has it
    bool stopped = false;
};

Calls& calls = *new Calls;  // never deleted: threads may wait in it when the process ends

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
    calls.stop();
}

void resumeCalls()
{
    calls.resume();
}

// Other Python threads run until the calls have ended.
void stopCalls()
{
    whileOthersRun(&waitForCalls);
}

std::mutex sharingMutex;

#ifndef _WIN32  // where processes do not fork

void beforeFork()
{
    sharingMutex.lock();
}

void afterForkInParent()
{
    sharingMutex.unlock();
}

void afterForkInChild()
{
    sharingMutex.unlock();
    new (&calls) Calls;  // the parent's may be locked by a thread that is not here
    forgetThreads();
}

#endif

}  // namespace

bool prepareThreads()
{
    const bool own = useThreads();
#ifndef _WIN32
    // By Python, because in a handler of the C library the GIL is held. The child's is needed for forks of others, too.
    py::module_::import("os").attr("register_at_fork")(py::arg("before") = py::cpp_function(&stopCalls),
                                                       py::arg("after_in_parent") =
                                                           py::cpp_function(&resumeCalls));
    pthread_atfork(&beforeFork, &afterForkInParent, &afterForkInChild);
#endif
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
    stopCalls();
    cv::setNumThreads(number);
    resumeCalls();
}

std::mutex& sharing()
{
    return sharingMutex;
}

PyThreadState* releaseGil()
{
    return PyEval_SaveThread();
}

// At the interpreter's exit Python ends a daemon thread here by unwinding its stack. That would release Python objects
// without the lock, so such a thread sleeps until the process ends, as Python 3.14 has it.
void acquireGil(PyThreadState* thread)
{
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

CallScope::CallScope()
{
    calls.begin();
}

CallScope::~CallScope()
{
    calls.end();
}

// The threads are not those of cv::parallel_for_: a process that forks between two images, or that changes the number of
// threads, must not be in the middle of a loop of OpenCV.
static void runThreads(size_t count, const std::function<void()>& work)
{
    std::vector<std::thread> others;
    try
    {
        others.reserve(count - 1);
        while (others.size() < count - 1)
            others.emplace_back(work);
    }
    catch (const std::exception&)
    {
        // As many as the system lets the process have.
    }
    work();
    for (std::thread& other : others)
        other.join();
}

void forEachImage(size_t count, const std::function<void(size_t)>& process)
{
    cv::aqorb::ImageLoop loop(count);
    const auto call = [&](size_t i)
    {
        const CallScope scope;
        process(i);
    };
    whileOthersRun(
        [&]
        {
            const size_t threads = std::min(size_t(std::max(getNumThreads(), 1)), count);
            if (threads <= 1)
                return loop.work(call);
            runThreads(threads,
                       [&]
                       {
                           const cv::aqorb::SingleThreadScope scope;
                           loop.work(call);
                       });
        });
    loop.check();
}

}  // namespace aqorb_python
