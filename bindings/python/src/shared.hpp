// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// What several threads of Python may use at the same time, with a lock of Python's (GIL) or without one.

#ifndef AQORB_PYTHON_SHARED_HPP
#define AQORB_PYTHON_SHARED_HPP

#include "threads.hpp"

#include <opencv2/core.hpp>

#include <pybind11/pybind11.h>

#include <atomic>
#include <cstring>
#include <mutex>

namespace aqorb_python
{

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

//! A class of cv2, or nothing if nobody has imported cv2: then there are no such objects.
inline pybind11::object knownClass(const char* name)
{
    PyObject* const cv2 = PyImport_GetModule(pybind11::str("cv2").ptr());
    PyErr_Clear();
    return cv2 ? pybind11::getattr(pybind11::reinterpret_steal<pybind11::object>(cv2), name,
                                   pybind11::handle())
               : pybind11::object();
}

}  // namespace aqorb_python

#endif
