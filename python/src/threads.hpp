// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// Processing without the global interpreter lock (GIL), in OpenCV's threads, what a fork of the process does to them, and
// what several threads of Python share.

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

//! To be called once, at import. A child process that is forked later works on one thread, as those of OpenCV stay
//! behind.
void prepareThreads();

//! A lock for what is done in no time and without Python. The process does not fork while it is held.
std::mutex& sharing();

//! cv::setNumThreads, when the calls that are under way have ended. In a child process it does nothing.
void setNumThreads(int count);

// Other Python threads run between the two. Meanwhile this one must not touch a Python object, not even copy or release
// one. The interpreter does not end before a call that it has let go.
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

//! A copy of an object of the library.
template <typename T> cv::Ptr<T> copyOf(const T& object);

/** An object of the library, which must not be changed while another thread calls it. Calls share it, and a change
 meanwhile goes to a copy, so that no later change reaches a call. */
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
    //! Calls change(object), with a copy if a call is under way.
    template <typename Change> void change(const Change& change)
    {
        share();  // or an exception
        const std::lock_guard<std::mutex> lock(sharing());
        if (object.use_count() > 1)
            object = copyOf(*object);
        else
            std::atomic_thread_fence(std::memory_order_acquire);  // after what the last call did
        change(*object);
    }

    // Python's __new__ makes an object without calling __init__. pybind11 gives its methods the memory as it is.
    static void* operator new(size_t size) { return std::memset(::operator new(size), 0, size); }

private:
    Shared& operator=(const Shared&) = delete;

    cv::Ptr<T> object;
};

}  // namespace aqorb_python

#endif
