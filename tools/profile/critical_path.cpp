// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "critical_path.hpp"

#include <algorithm>

double workOf(const std::vector<DoneTask>& tasks)
{
    double sum = 0;
    for (const DoneTask& task : tasks)
        sum += task.duration;
    return sum;
}

double longestPath(const std::vector<DoneTask>& tasks)
{
    std::vector<double> ends;  // of the longest path to each task
    double longest = 0;
    for (const DoneTask& task : tasks)
    {
        double start = 0;
        for (const size_t input : task.inputs)
            start = std::max(start, ends[input]);
        ends.push_back(start + task.duration);
        longest = std::max(longest, ends.back());
    }
    return longest;
}

double leastTime(const std::vector<DoneTask>& tasks, int threads)
{
    const double longest = longestPath(tasks);
    return threads > 0 ? std::max(longest, workOf(tasks) / threads) : longest;
}

double queueTime(const std::vector<DoneTask>& tasks, int threads)
{
    std::vector<double> ends(tasks.size(), -1);  // below 0: has not begun
    std::vector<double> freeFrom(threads, 0.);   // by thread
    for (size_t done = 0; done < tasks.size(); done++)
    {
        // Of the tasks that have not begun the one that can begin first, and of those the first one.
        double& free = *std::min_element(freeFrom.begin(), freeFrom.end());
        size_t next = 0;
        double begin = -1;
        for (size_t i = 0; i < tasks.size(); i++)
        {
            if (ends[i] >= 0)
                continue;
            double ready = free;
            bool canBegin = true;
            for (const size_t input : tasks[i].inputs)
            {
                canBegin = canBegin && ends[input] >= 0;
                ready = std::max(ready, ends[input]);
            }
            if (canBegin && (begin < 0 || ready < begin))
            {
                begin = ready;
                next = i;
            }
        }
        free = ends[next] = begin + tasks[next].duration;
    }
    return tasks.empty() ? 0 : *std::max_element(ends.begin(), ends.end());
}
