// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// The threads that the library works with, processing without the global interpreter lock (GIL), and what a fork of the
// process does to both.

#ifndef AQORB_PYTHON_THREADS_HPP
#define AQORB_PYTHON_THREADS_HPP

#include <pybind11/pybind11.h>

#include <cstddef>
#include <exception>
#include <functional>
#include <mutex>

namespace aqorb_python
{

//! Lets the process fork while it has threads. To be called once, at import. Returns whether the threads are the
//! package's own, or else those of the OpenCV that it shares with cv2.
bool prepareThreads();

//! The number of threads that a call may use.
int getNumThreads();
//! Sets it for calls that begin later; a negative number is the default, and 0 and 1 mean no other threads. Waits for the
//! calls that are under way, while other Python threads run.
void setNumThreads(int threads);

//! A lock for what is done in no time and without Python. The process does not fork while it is held.
std::mutex& sharing();

// Other Python threads run between the two. Meanwhile this one must not touch a Python object, not even copy or release
// one.
PyThreadState* releaseGil();
void acquireGil(PyThreadState* thread);

//! A call of the library, without the GIL. The process does not fork meanwhile, so that no lock of the library is held by
//! a thread that the child process does not have.
class CallScope
{
public:
    CallScope();
    ~CallScope();

private:
    CallScope(const CallScope&) = delete;
    CallScope& operator=(const CallScope&) = delete;
};

//! Calls process() between releaseGil and acquireGil.
template <typename Process> void whileOthersRun(const Process& process)
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

//! The same for a process that is a call of the library.
template <typename Process> void withoutGil(const Process& process)
{
    whileOthersRun(
        [&]
        {
            const CallScope scope;
            process();
        });
}

//! Calls process(index) for each image of a collection without the GIL: side by side, each on one thread, or for a single
//! image on all of them. Each of them is a call of the library, so that a fork waits for no more than those that are being
//! processed. Throws what the first image throws, as ImageLoop does.
void forEachImage(size_t count, const std::function<void(size_t)>& process);

}  // namespace aqorb_python

#endif
