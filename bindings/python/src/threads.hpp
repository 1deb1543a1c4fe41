// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// Processing without the global interpreter lock (GIL), in OpenCV's threads, and what a fork of the process does to
// them.

#ifndef AQORB_PYTHON_THREADS_HPP
#define AQORB_PYTHON_THREADS_HPP

#include <pybind11/pybind11.h>

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

}  // namespace aqorb_python

#endif
