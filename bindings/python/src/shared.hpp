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

/** A value that is made when it is first needed, and never released: the interpreter may be gone by then. Of several
 threads that make one at the same time, all get the first one. */
template <typename T> class Made
{
public:
    //! The value, or 0.
    const T* get() const { return value.load(std::memory_order_acquire); }
    const T& set(const T& made)
    {
        const T* const mine = new T(made);
        const T* first = nullptr;
        if (value.compare_exchange_strong(first, mine, std::memory_order_acq_rel))
            return *mine;
        delete mine;
        return *first;
    }

private:
    std::atomic<const T*> value{nullptr};
};

//! A module that has been imported, or nothing.
inline pybind11::object importedModule(const char* name)
{
    PyObject* const found = PyImport_GetModule(pybind11::str(name).ptr());
    PyErr_Clear();
    return pybind11::reinterpret_steal<pybind11::object>(found);
}

}  // namespace aqorb_python

#endif
