// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#ifndef OPENCV_AQORB_TASKS_HPP
#define OPENCV_AQORB_TASKS_HPP

#include <opencv2/core.hpp>

#include <condition_variable>
#include <exception>
#include <mutex>
#include <vector>

namespace cv
{
namespace aqorb
{

//! A piece of work. What it is about is up to its TaskRunner.
struct Task
{
    int kind, level, part;
    Range range;  //!< of what is in the part
};

//! Does tasks, several at once.
class TaskRunner
{
public:
    virtual ~TaskRunner() {}
    /** Does a task, and puts those that it makes ready into the queue.
     @param worker 0 to threads - 1; a worker does one task after the other */
    virtual void run(const Task& task, int worker) = 0;
};

/** Tasks whose inputs are ready. One call of cv::parallel_for_ starts the workers, each of which takes the next task
 until none is left. A worker waits only while another one is at work, so the tasks are done however many workers
 cv::parallel_for_ lets run at once, even one after the other. An object can be used again, and then needs no new
 memory. */
class TaskQueue
{
public:
    //! How many threads a call that this thread begins may use.
    static int threadsAllowed();
    //! How many of them cv::parallel_for_ is to use for a frame.
    static int threadsInUse();
    //! Adds a task whose inputs are ready. The one with the smallest number as priority is taken first.
    void put(int priority, const Task& task);
    //! Does all tasks: those in the queue, and those that they put there. An exception of a task ends the others as soon
    //! as possible, and is rethrown.
    void run(int threads, TaskRunner& runner);
    //! Forgets the tasks of a frame that ended before they were done.
    void clear();

private:
    struct Entry
    {
        bool operator<(const Entry& other) const
        {
            return priority != other.priority ? priority > other.priority : number > other.number;
        }
        int priority;
        unsigned number;  // the first one put in comes first
        Task task;
    };
    void work();
    void runNext(std::unique_lock<std::mutex>& lock, int worker);
    void waitForTask(std::unique_lock<std::mutex>& lock);

    TaskRunner* runner = 0;  // of the current run
    std::mutex mutex;        // guards what follows
    std::condition_variable changed;
    std::vector<Entry> ready;  // a heap
    unsigned number = 0;       // of the next task
    int running = 0;           // tasks that are being done
    int waiting = 0;           // workers that wait for a task
    int workers = 0;           // that have begun
    std::exception_ptr error;  // the first one
};

}  // namespace aqorb
}  // namespace cv

#endif
