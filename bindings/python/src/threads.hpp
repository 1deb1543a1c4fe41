// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// The threads that the library works with, and what a fork of the process does to them.

#ifndef AQORB_PYTHON_THREADS_HPP
#define AQORB_PYTHON_THREADS_HPP

namespace aqorb_python
{

//! Lets the process fork while it has threads. To be called once, at import. Returns whether the threads are the
//! package's own, or else those of the OpenCV that it shares with cv2.
bool prepareThreads();

//! The number of threads that a call may use.
int getNumThreads();
//! Sets it for calls that begin later; a negative number is the default, and 0 and 1 mean no other threads.
void setNumThreads(int threads);

//! A call of the library, from its beginning to its end. The process does not fork meanwhile, so that no lock of the
//! library is held by a thread that the child process does not have.
class Call
{
public:
    Call();
    ~Call();

private:
    Call(const Call&);
    Call& operator=(const Call&);
};

}  // namespace aqorb_python

#endif
