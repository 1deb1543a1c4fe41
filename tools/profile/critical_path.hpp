// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#ifndef AQORB_PROFILE_CRITICAL_PATH_HPP
#define AQORB_PROFILE_CRITICAL_PATH_HPP

#include <cstddef>
#include <vector>

//! A task that one thread has done. Tasks stand in the order in which they were done.
struct DoneTask
{
    double duration;             //!< any unit
    std::vector<size_t> inputs;  //!< the tasks that must be done before; all of them stand before
};

//! The time of all tasks.
double workOf(const std::vector<DoneTask>& tasks);

//! The longest time of tasks that must be done one after the other.
double longestPath(const std::vector<DoneTask>& tasks);

//! The least time that threads can take: the longest path or the threads' share of the work, whichever is longer.
//! @param threads 0: as many as there are tasks
double leastTime(const std::vector<DoneTask>& tasks, int threads);

//! The time that threads take if each of them takes, whenever it is free, the first task whose inputs are done.
double queueTime(const std::vector<DoneTask>& tasks, int threads);

#endif
