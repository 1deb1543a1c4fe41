// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "reference.hpp"

#include "allocations.hpp"
#include "tasks.hpp"

#include <opencv2/core/parallel/parallel_backend.hpp>
#include <opencv2/core/utility.hpp>
#include <opencv2/core/utils/trace.hpp>

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <exception>
#include <functional>
#include <memory>
#include <mutex>
#include <new>
#include <stdexcept>
#include <thread>

// Whatever cv::parallel_for_ does with the workers of a frame, all tasks are done, and the bytes are the same.

namespace opencv_test
{
namespace
{

using aqorb::Task;
using aqorb::TaskQueue;
using aqorb::TaskRunner;

//! Sets the number of OpenCV's threads until it goes out of scope.
class Threads
{
public:
    explicit Threads(int count) : before(getNumThreads()) { setNumThreads(count); }
    ~Threads() { setNumThreads(before); }

private:
    const int before;
};

//! A way to run the stripes of cv::parallel_for_.
class Backend : public parallel::ParallelForAPI
{
public:
    Backend() : threads(2) {}
    int getThreadNum() const CV_OVERRIDE { return 0; }
    int getNumThreads() const CV_OVERRIDE { return threads; }
    int setNumThreads(int count) CV_OVERRIDE { return threads.exchange(std::max(count, 1)); }
    const char* getName() const CV_OVERRIDE { return "test"; }

private:
    std::atomic<int> threads;
};

//! Runs one stripe after the other.
class InTurns : public Backend
{
public:
    explicit InTurns(bool isReversed_ = false) : isReversed(isReversed_) {}
    void parallel_for(int stripes, FN_parallel_for_body_cb_t body, void* data) CV_OVERRIDE
    {
        for (int i = 0; i < stripes; i++)
        {
            const int stripe = isReversed ? stripes - 1 - i : i;
            body(stripe, stripe + 1, data);
        }
    }

private:
    const bool isReversed;
};

//! Runs all stripes as one.
class AtOnce : public Backend
{
public:
    void parallel_for(int stripes, FN_parallel_for_body_cb_t body, void* data) CV_OVERRIDE
    {
        body(0, stripes, data);
    }
};

//! Runs the stripes on new threads, of which each begins later than the one before.
class NewThreads : public Backend
{
public:
    explicit NewThreads(int delay_ = 0) : delay(delay_) {}
    void parallel_for(int stripes, FN_parallel_for_body_cb_t body, void* data) CV_OVERRIDE
    {
        std::mutex mutex;
        std::condition_variable changed;
        size_t ready = 0;
        bool hasBegun = false;
        std::exception_ptr error;
        std::atomic<int> next(0);
        const auto work = [&](int thread)
        {
            {
                // OpenCV allocates memory when a thread uses these for the first time, and ends the program if there
                // is none.
                CV_TRACE_REGION("thread");
                theRNG();
            }
            AllocationCounter::letThreadFail();
            {
                std::unique_lock<std::mutex> lock(mutex);
                ready++;
                changed.notify_all();
                changed.wait(lock, [&] { return hasBegun; });
            }
            std::this_thread::sleep_for(std::chrono::microseconds(thread * delay));
            try
            {
                for (int stripe = next++; stripe < stripes; stripe = next++)
                    body(stripe, stripe + 1, data);
            }
            catch (...)  // OpenCV itself allocates memory, too
            {
                const std::lock_guard<std::mutex> lock(mutex);
                error = std::current_exception();
            }
        };
        std::vector<std::thread> others;
        for (int i = 0; i < std::min(getNumThreads(), stripes); i++)
            others.push_back(std::thread(work, i));
        {
            std::unique_lock<std::mutex> lock(mutex);
            changed.wait(lock, [&] { return ready == others.size(); });
        }
        allStarted();
        {
            const std::lock_guard<std::mutex> lock(mutex);
            hasBegun = true;
        }
        changed.notify_all();
        for (std::thread& other : others)
            other.join();
        allEnded();
        if (error)
            std::rethrow_exception(error);
    }

private:
    virtual void allStarted() {}
    virtual void allEnded() {}
    const int delay;
};

//! Replaces the backend of cv::parallel_for_ until it goes out of scope.
class BackendScope
{
public:
    explicit BackendScope(const std::shared_ptr<Backend>& backend)
    {
        parallel::setParallelForBackend(backend, false);
    }
    ~BackendScope()
    {
        std::shared_ptr<Backend> before;
#if defined(__SANITIZE_THREAD__)
        before = std::make_shared<NewThreads>();  // see tools/tsan
#endif
        parallel::setParallelForBackend(before, false);
    }

private:
    BackendScope(const BackendScope&);
    BackendScope& operator=(const BackendScope&);
};

std::vector<std::shared_ptr<Backend>> backends()
{
    std::vector<std::shared_ptr<Backend>> all;
    all.push_back(std::make_shared<InTurns>());
    all.push_back(std::make_shared<InTurns>(true));
    all.push_back(std::make_shared<AtOnce>());
    all.push_back(std::make_shared<NewThreads>());
    all.push_back(std::make_shared<NewThreads>(300));
    return all;
}

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
        const Task task = {7, 8, index};
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
    const Task task = {3, 4, 5};
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
            const Task task = {3, 4, i};
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

// ---- the detector -----------------------------------------------------------------------------

//! What a detector is asked for.
struct Call
{
    Mat image, mask;
    int nfeatures;
    AdaptiveQuadtreeORB::SelectionType type;
};

std::vector<Call> calls()
{
    const Mat image = makeScene(Size(300, 420), 2), mask = makeNoise(Size(300, 420), 3) > 5;
    Mat colored;
    cvtColor(makeScene(Size(160, 120), 4), colored, COLOR_GRAY2BGR);
    const Call all[] = {{image, Mat(), 500, AdaptiveQuadtreeORB::RANKED_SELECTION},
                        {image, mask, 300, AdaptiveQuadtreeORB::RANKED_SELECTION},
                        {colored, Mat(), 5000, AdaptiveQuadtreeORB::RANKED_SELECTION},  // more than there are
                        {image, Mat(), 400, AdaptiveQuadtreeORB::BALANCED_SELECTION}};
    return std::vector<Call>(all, all + 4);
}

Ptr<AdaptiveQuadtreeORB> detectorOf(const Call& call)
{
    const Ptr<AdaptiveQuadtreeORB> detector = AdaptiveQuadtreeORB::create(call.nfeatures);
    detector->setSelectionType(call.type);
    return detector;
}

//! The features of a call by one thread.
Features expectedOf(const Call& call)
{
    Threads one(1);
    return detectAndCompute(*detectorOf(call), call.image, call.mask);
}

//! Whether a detector gives these features, and the same descriptors for given keypoints.
bool gives(AdaptiveQuadtreeORB& detector, const Call& call, const Features& expected)
{
    const Features found = detectAndCompute(detector, call.image, call.mask);
    Features computed = {expected.keypoints, Mat()};
    detector.compute(call.image, computed.keypoints, computed.descriptors);
    return sameFeatures(expected, found) && sameFeatures(expected, computed);
}

TEST(Aqorb_Tasks, threads_1_to_16_of_any_backend_give_the_same_bytes)
{
    for (const Call& call : calls())
    {
        const Features expected = expectedOf(call);
        ASSERT_GE(expected.keypoints.size(), 300u);
        const Ptr<AdaptiveQuadtreeORB> detector = detectorOf(call);
        for (int kind = -1; kind < int(backends().size()); kind++)
        {
            std::unique_ptr<BackendScope> scope(kind < 0 ? 0 : new BackendScope(backends()[kind]));
            for (int count = 0; count <= 16; count += kind < 0 || count < 3 ? 1 : 4)
            {
                Threads threads(count);
                EXPECT_TRUE(gives(*detector, call, expected))
                    << format("backend %d, %d threads", kind, count);
            }
        }
    }
}

// Above there are so many corners that those that the rules pass over do not seem to be needed, below there are none.
TEST(Aqorb_Tasks, threads_find_again_what_did_not_seem_to_be_needed)
{
    Mat image = makeScene(Size(160, 400), 7);
    image.rowRange(60, 400).setTo(90);
    reference::Settings settings;
    for (int nfeatures : {80, 160, 240, 320, 480, 640, 960})
    {
        settings.nfeatures = nfeatures;
        const Features expected = reference::detectAndCompute(image, Mat(), settings);
        for (int count = 1; count <= 4; count++)
        {
            Threads threads(count);
            EXPECT_TRUE(sameFeatures(expected, detectAndCompute(*settings.create(), image)))
                << format("%d features, %d threads", nfeatures, count);
        }
    }
}

TEST(Aqorb_Tasks, threads_of_the_caller_give_the_same_bytes)
{
    const int CALLERS = 12;
    const Call call = calls()[0];
    const Features expected = expectedOf(call);
    const Ptr<AdaptiveQuadtreeORB> detector = detectorOf(call);
    for (int kind = -1; kind < int(backends().size()); kind++)
    {
        SCOPED_TRACE(format("backend %d", kind));
        std::unique_ptr<BackendScope> scope(kind < 0 ? 0 : new BackendScope(backends()[kind]));
        Threads threads(4);
        std::vector<int> failed(CALLERS, 1);
        const auto callSome = [&](const Range& range)
        {
            for (int i = range.start; i < range.end; i++)
                failed[i] = !gives(*detector, call, expected);
        };
        parallel_for_(Range(0, CALLERS), callSome, CALLERS);
        EXPECT_EQ(std::vector<int>(CALLERS, 0), failed);

        // Frames of several threads at once, of which one has OpenCV's threads.
        failed.assign(CALLERS, 1);
        std::vector<std::thread> callers;
        for (int i = 0; i < 4; i++)
            callers.push_back(std::thread(callSome, Range(i * 3, i * 3 + 3)));
        for (std::thread& caller : callers)
            caller.join();
        EXPECT_EQ(std::vector<int>(CALLERS, 0), failed);
    }
}

//! Lets an allocation of memory fail after all threads have started.
class FailingThreads : public NewThreads
{
public:
    explicit FailingThreads(int failing_) : failing(failing_) {}

private:
    void allStarted() CV_OVERRIDE { counter.reset(new AllocationCounter(failing)); }
    void allEnded() CV_OVERRIDE { counter.reset(); }

    const int failing;
    std::unique_ptr<AllocationCounter> counter;
};

//! Of few pixels, but with all kinds of tasks.
Call smallCall()
{
    const Size size(100, 140);
    const Call call = {makeScene(size, 5), makeNoise(size, 3) > 5, 300,
                       AdaptiveQuadtreeORB::RANKED_SELECTION};
    return call;
}

//! Whether a call of a detector without memory fails for lack of it. The detector can be used again in any case.
bool failsForMemory(const Call& call, const Features& expected,
                    const std::function<Features(AdaptiveQuadtreeORB&)>& failing)
{
    const Ptr<AdaptiveQuadtreeORB> detector = detectorOf(call);
    bool hasFailed = false;
    try
    {
        EXPECT_TRUE(sameFeatures(expected, failing(*detector)));
    }
    catch (const std::bad_alloc&)
    {
        hasFailed = true;
    }
    catch (const cv::Exception& error)
    {
        hasFailed = true;
        EXPECT_EQ(error.code, int(Error::StsNoMem));
    }
    EXPECT_TRUE(gives(*detector, call, expected)) << "after a call that failed";
    return hasFailed;
}

TEST(Aqorb_Tasks, threads_end_when_memory_runs_out)
{
    const Call call = smallCall();
    const Features expected = expectedOf(call);
    Threads threads(3);
    int failing = 1, failures = 0;
    const auto detect = [&](AdaptiveQuadtreeORB& detector)
    {
        const BackendScope scope(std::make_shared<FailingThreads>(failing));
        setNumThreads(3);
        return detectAndCompute(detector, call.image, call.mask);
    };
    for (; failsForMemory(call, expected, detect) && !HasFailure(); failures++)
        failing += 1 + failing / 16;
    EXPECT_GT(failures, 20);
}

// The first tasks are in the queue before the first worker begins.
TEST(Aqorb_Tasks, of_a_frame_that_lacked_memory_are_not_left_for_the_next)
{
    const Call call = smallCall();
    const Features expected = expectedOf(call);
    for (int count = 1; count <= 3; count += 2)
    {
        SCOPED_TRACE(count);
        Threads threads(count);
        int failing = 1, failures = 0;
        const auto detect = [&](AdaptiveQuadtreeORB& detector)
        {
            const BackendScope scope(std::make_shared<InTurns>());
            setNumThreads(count);
            const AllocationCounter allocations(failing);
            return detectAndCompute(detector, call.image, call.mask);
        };
        for (; failsForMemory(call, expected, detect) && !HasFailure(); failures++)
            failing += 1 + failing / 32;
        EXPECT_GT(failures, 50);
    }
}

}  // namespace
}  // namespace opencv_test
