// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "test_precomp.hpp"

#include "backends.hpp"
#include "tasks.hpp"

#include <opencv2/core/utility.hpp>

#include <functional>
#include <stdexcept>

// Whatever cv::parallel_for_ does with the workers of a queue, all tasks are done.

namespace opencv_test
{
namespace
{

using aqorb::Task;
using aqorb::TaskQueue;
using aqorb::TaskRunner;

struct Failure : public std::runtime_error
{
    Failure() : std::runtime_error("on purpose") {}
};

//! Tasks of which each waits for some of those before it, and takes any time.
class Graph : public TaskRunner
{
public:
    Graph(int size, int seed, int longest_)
        : nodes(size), missing(size), runs(size), busy(MOST_THREADS), longest(longest_), failing(-1)
    {
        RNG rng(seed);
        for (int i = 0; i < size; i++)
        {
            Node& node = nodes[i];
            node.priority = rng.uniform(0, 5);
            node.pause = rng.uniform(0, 3) ? 0 : rng.uniform(0, longest + 1);
            // Now and then all wait for one task.
            for (int j = 1; j <= std::min(i, 8); j++)
            {
                if (j == 1 ? i % 16 < 2 : rng.uniform(0, 6) == 0)
                    node.inputs.push_back(i - j);
            }
            for (int input : node.inputs)
                nodes[input].followers.push_back(i);
        }
    }
    //! Lets a task fail; -1: none does.
    void setFailing(int index) { failing = index; }
    //! Does all tasks with a queue, and says what went wrong.
    ::testing::AssertionResult complete(TaskQueue& tasks, int threads_)
    {
        start(tasks, threads_);
        tasks.run(threads, *this);
        return state();
    }
    //! The same, but a task fails.
    ::testing::AssertionResult fail(TaskQueue& tasks, int threads_)
    {
        start(tasks, threads_);
        try
        {
            tasks.run(threads, *this);
        }
        catch (const Failure&)
        {
            return state();
        }
        return ::testing::AssertionFailure() << "no exception";
    }
    void run(const Task& task, int worker) CV_OVERRIDE
    {
        const int index = task.part;
        const Node& node = nodes[index];
        if (worker < 0 || worker >= threads || busy[worker].exchange(1) != 0)
            wrong++;
        for (int input : node.inputs)
            wrong += runs[input] != 1;
        if (node.pause > 0)
            std::this_thread::sleep_for(std::chrono::microseconds(node.pause));
        runs[index]++;
        if (worker >= 0 && worker < threads)
            busy[worker] = 0;
        begunLate += hasFailed;
        if (index == failing)
        {
            hasFailed = 1;
            throw Failure();
        }
        for (int follower : node.followers)
        {
            if (--missing[follower] == 0)
                put(follower);
        }
    }

private:
    enum
    {
        MOST_THREADS = 64
    };
    struct Node
    {
        std::vector<int> inputs, followers;
        int priority, pause;
    };
    void put(int index)
    {
        const Task task = {7, 8, index, Range()};
        queue->put(nodes[index].priority, task);
    }
    void start(TaskQueue& tasks, int threads_)
    {
        queue = &tasks;
        threads = threads_;
        wrong = begunLate = hasFailed = 0;
        for (int i = 0; i < MOST_THREADS; i++)
            busy[i] = 0;
        for (size_t i = 0; i < nodes.size(); i++)
        {
            missing[i] = int(nodes[i].inputs.size());
            runs[i] = 0;
        }
        for (size_t i = 0; i < nodes.size(); i++)
        {
            if (nodes[i].inputs.empty())
                put(int(i));
        }
    }
    ::testing::AssertionResult state() const
    {
        for (int i = 0; i < MOST_THREADS; i++)
        {
            if (busy[i])
                return ::testing::AssertionFailure() << "worker " << i << " is still at work";
        }
        if (wrong > 0)
            return ::testing::AssertionFailure() << wrong << " tasks ran before their inputs, or two at once";
        if (threads == 1 && begunLate > 0)
            return ::testing::AssertionFailure() << begunLate << " tasks were begun after one failed";
        std::vector<bool> isAfterFailing(nodes.size());
        for (int i = 0; i < int(nodes.size()); i++)
        {
            for (int input : nodes[i].inputs)
                isAfterFailing[i] = isAfterFailing[i] || isAfterFailing[input] || input == failing;
            const int most = isAfterFailing[i] ? 0 : 1, least = failing < 0 || i == failing ? 1 : 0;
            if (runs[i] < least || runs[i] > most)
                return ::testing::AssertionFailure() << "task " << i << " was done " << runs[i] << " times";
        }
        return ::testing::AssertionSuccess();
    }

    std::vector<Node> nodes;
    std::vector<std::atomic<int>> missing, runs, busy;
    const int longest;
    int failing, threads;
    std::atomic<int> wrong, begunLate, hasFailed;
    TaskQueue* queue;
};

TEST(Aqorb_Tasks, threads_do_each_task_once_and_after_its_inputs)
{
    TaskQueue queue;
    for (int round = 0; round < 40; round++)
    {
        const int count = 1 + round % 16;
        Threads threads(count);
        SCOPED_TRACE(format("round %d, %d threads", round, count));
        Graph graph(200, round, round % 4 * 100);
        ASSERT_TRUE(graph.complete(queue, count));
        ASSERT_TRUE(graph.complete(queue, count));
    }
}

TEST(Aqorb_Tasks, threads_of_any_backend_do_all_tasks)
{
    for (const std::shared_ptr<Backend>& backend : backends())
    {
        const BackendScope scope(backend);
        TaskQueue queue;
        for (int count = 1; count <= 16; count++)
        {
            Threads threads(count);
            SCOPED_TRACE(format("%d threads", count));
            Graph graph(100, count, 200);
            ASSERT_TRUE(graph.complete(queue, count));
        }
    }
}

TEST(Aqorb_Tasks, fewer_threads_than_asked_for_do_all_tasks)
{
    TaskQueue queue;
    for (int count = 0; count <= 2; count++)
    {
        Threads threads(count);
        SCOPED_TRACE(count);
        for (int asked = 1; asked <= 16; asked++)
        {
            Graph graph(100, asked, 50);
            ASSERT_TRUE(graph.complete(queue, asked));
        }
    }
}

TEST(Aqorb_Tasks, threads_of_the_caller_do_all_tasks)
{
    const int CALLERS = 6;
    Threads threads(4);
    std::vector<int> failed(CALLERS, 1);
    parallel_for_(
        Range(0, CALLERS),
        [&](const Range& range)
        {
            for (int i = range.start; i < range.end; i++)
            {
                TaskQueue queue;
                Graph graph(100, i, 100);
                failed[i] = !graph.complete(queue, 4);
            }
        },
        CALLERS);
    EXPECT_EQ(std::vector<int>(CALLERS, 0), failed);
}

TEST(Aqorb_Tasks, that_were_not_begun_can_be_cleared)
{
    TaskQueue queue;
    const Task task = {3, 4, 5, Range(6, 7)};
    queue.put(0, task);
    queue.clear();
    Graph graph(50, 1, 0);
    EXPECT_TRUE(graph.complete(queue, 1));
}

// Writes down in which order tasks are done.
class Recorder : public TaskRunner
{
public:
    void run(const Task& task, int worker) CV_OVERRIDE
    {
        EXPECT_EQ(worker, 0);
        EXPECT_EQ(task.kind, 3);
        EXPECT_EQ(task.level, 4);
        parts.push_back(task.part);
    }
    std::vector<int> parts;
};

TEST(Aqorb_Tasks, come_in_the_order_of_their_priorities)
{
    const int priorities[] = {5, 1, 5, -2, 1, 0, 5, 1};
    TaskQueue queue;
    for (int repeat = 0; repeat < 2; repeat++)
    {
        for (int i = 0; i < 8; i++)
        {
            const Task task = {3, 4, i, Range()};
            queue.put(priorities[i], task);
        }
        Recorder recorder;
        queue.run(1, recorder);
        EXPECT_EQ(recorder.parts, std::vector<int>({3, 5, 1, 4, 7, 0, 2, 6}));
        queue.run(1, recorder);
        EXPECT_EQ(recorder.parts.size(), 8u) << "nothing is left";
    }
}

TEST(Aqorb_Tasks, threads_in_use_are_at_least_one)
{
    for (int count = 0; count <= 16; count++)
    {
        Threads threads(count);
        EXPECT_EQ(TaskQueue::threadsInUse(), std::min(std::max(getNumThreads(), 1), 16));
    }
}

TEST(Aqorb_Tasks, threads_end_when_a_task_fails)
{
    for (int kind = -1; kind < int(backends().size()); kind++)
    {
        std::unique_ptr<BackendScope> scope(kind < 0 ? 0 : new BackendScope(backends()[kind]));
        TaskQueue queue;
        for (int round = 0; round < 20; round++)
        {
            const int count = 1 + round % 8;
            Threads threads(count);
            SCOPED_TRACE(format("backend %d, round %d, %d threads", kind, round, count));
            Graph graph(100, round, 200);
            graph.setFailing(round * 5);
            ASSERT_TRUE(graph.fail(queue, count));
            graph.setFailing(-1);
            ASSERT_TRUE(graph.complete(queue, count)) << "the queue can be used again";
        }
    }
}

}  // namespace
}  // namespace opencv_test
