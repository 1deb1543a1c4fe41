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
#include <mutex>

namespace aqorb_python
{

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
        return object;
    }
    //! Calls change(object), with the copy that copy(object) returns if others share the object.
    template <typename Copy, typename Change> void change(const Copy& copy, const Change& change)
    {
        const std::lock_guard<std::mutex> lock(sharing());
        if (object.use_count() > 1)
            object = copy(*object);
        else
            std::atomic_thread_fence(std::memory_order_acquire);  // after what the last call did
        change(*object);
    }

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
