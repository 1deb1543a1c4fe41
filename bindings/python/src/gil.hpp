// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// Processing without the global interpreter lock (GIL).

#ifndef AQORB_PYTHON_GIL_HPP
#define AQORB_PYTHON_GIL_HPP

#include "threads.hpp"

#include <pybind11/pybind11.h>

#include <chrono>
#include <exception>
#include <thread>

namespace aqorb_python
{

//! Takes the lock again. At the interpreter's exit Python ends a daemon thread here by unwinding its stack. That would
//! release Python objects without the lock, so such a thread sleeps until the process ends, as Python 3.14 has it.
inline void acquireGil(PyThreadState* thread)
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

//! Calls process() while other Python threads run. It must not touch a Python object, not even copy or release one.
template <typename Process> void withoutGil(const Process& process)
{
    std::exception_ptr exception;
    PyThreadState* const thread = PyEval_SaveThread();
    try
    {
        const Call call;
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

}  // namespace aqorb_python

#endif
