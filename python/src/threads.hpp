// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// Calls without the global interpreter lock (GIL): OpenCV's threads, forks of the process, and objects shared by
// several Python threads.

#ifndef AQORB_PYTHON_THREADS_HPP
#define AQORB_PYTHON_THREADS_HPP

#include <opencv2/core.hpp>

#include <pybind11/pybind11.h>

#include <atomic>
#include <cstring>
#include <exception>
#include <mutex>

namespace aqorb_python
{

//! Prepares for forks and for the interpreter's exit. Called once, at import. A forked child works on one thread,
//! because it has none of OpenCV's threads.
void prepareThreads();

//! Lock for very short work without Python. The process does not fork while a thread holds it.
std::mutex& sharing();

//! Calls cv::setNumThreads after all running calls have ended. In a child process it does nothing.
void setNumThreads(int count);

// Other Python threads run between these two functions. Meanwhile this thread must not touch a Python object, not even
// copy or release one. The interpreter waits for the call before it exits.
PyThreadState* releaseGil();
void acquireGil(PyThreadState* thread);

//! Calls process() between releaseGil and acquireGil.
template <typename Process> void withoutGil(const Process& process)
{
    std::exception_ptr exception;
    PyThreadState* const thread = releaseGil();
    try
    {
        process();
    }
    catch (...)
    {
        exception = std::current_exception();
    }
    acquireGil(thread);
    if (exception)
        std::rethrow_exception(exception);
}

//! Copy of an object of the library.
template <typename T> cv::Ptr<T> copyOf(const T& object);

/** Object of the library that several threads call and change. Calls share it. A change during a call goes to a copy,
 so it reaches later calls only. */
template <typename T> class Shared
{
public:
    explicit Shared(const cv::Ptr<T>& object_) : object(object_) {}
    Shared(const Shared& other) : object(other.share()) {}

    cv::Ptr<T> share() const
    {
        const std::lock_guard<std::mutex> lock(sharing());
        if (!object)
            throw pybind11::type_error("__init__() was not called");
        return object;
    }
    //! Calls change(object), on a copy if a call is running.
    template <typename Change> void change(const Change& change)
    {
        share();  // throws without an object
        const std::lock_guard<std::mutex> lock(sharing());
        if (object.use_count() > 1)
            object = copyOf(*object);
        else
            std::atomic_thread_fence(std::memory_order_acquire);  // sees the writes of the last call
        change(*object);
    }

    // Zeroed memory, because Python's __new__ makes an object without __init__, and pybind11 passes it to methods.
    static void* operator new(size_t size) { return std::memset(::operator new(size), 0, size); }

private:
    Shared& operator=(const Shared&) = delete;

    cv::Ptr<T> object;
};

}  // namespace aqorb_python

#endif
