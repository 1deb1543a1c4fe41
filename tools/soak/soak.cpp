// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// The long run: frames of changing sizes through one object from several threads, calls that fail, and memory
// that runs out. Each output must be what it was at first, and memory must not grow. See doc/reliability.md.

#include "../common/options.hpp"
#include "../common/quiet.hpp"
#include "../../test/allocations.hpp"
#include "../../test/test_precomp.hpp"

#include <malloc.h>
#include <unistd.h>

#include <atomic>
#include <cstdio>
#include <fstream>
#include <thread>

using namespace opencv_test;

namespace
{

const char* const KEYS = "{help h usage ? |      | print this text }"
                         "{frames         |100000| frames through one object }"
                         "{threads        |4     | threads that give it frames }"
                         "{failures       |20000 | calls in which memory runs out }"
                         "{any-memory     |      | do not check the memory in use }";

//! An image, for some with a mask, and the features that a new detector finds in it.
struct Frame
{
    Mat image, mask;
    Features expected;
};

std::vector<Frame> makeFrames(int count)
{
    std::vector<Frame> frames(count);
    for (int i = 0; i < count; i++)
    {
        RNG rng(i + 1);
        const Size size(rng.uniform(20, 200), rng.uniform(20, 160));
        frames[i].image = i % 4 ? makeScene(size, i + 1) : makeNoise(size, i + 1);
        if (i % 3 == 0)
            frames[i].mask = makeScene(size, i + 2) > 100;
        if (i % 7 == 0)
            cvtColor(frames[i].image, frames[i].image, COLOR_GRAY2BGR);
        frames[i].expected =
            detectAndCompute(*AdaptiveQuadtreeORB::create(200), frames[i].image, frames[i].mask);
    }
    return frames;
}

//! Whether the detector still gives the features that a new one gave.
bool isAsAtFirst(Feature2D& detector, const Frame& frame)
{
    Features found = detectAndCompute(detector, frame.image, frame.mask);
    if (!sameFeatures(found, frame.expected))
        return false;
    detector.compute(frame.image, found.keypoints, found.descriptors);
    return bool(sameFeatures(found, frame.expected));
}

//! Makes a call that must fail. Returns false if it does not.
bool fails(Feature2D& detector, const Frame& frame, int kind)
{
    KeyPoints keypoints;
    Mat descriptors;
    try
    {
        if (kind == 0)  // fails before anything is computed
        {
            detector.detect(Mat(10, 10, CV_32FC1, Scalar(0)), keypoints);
        }
        else if (kind == 1)  // fails after the image was checked
        {
            detector.detect(frame.image, keypoints, Mat(7, 7, CV_8UC1, Scalar(1)));
        }
        else  // fails while memory of the detector is in use
        {
            keypoints.assign(1, KeyPoint(Point2f(9, 9), 31.f, 0.f, 0.f, 1 << 20));
            detector.compute(frame.image, keypoints, descriptors);
        }
    }
    catch (const cv::Exception&)
    {
        return true;
    }
    return false;
}

struct Memory
{
    double heap, resident;  // in MB; of the heap the part in use
};

Memory memoryInUse()
{
    long pages = 0, residentPages = 0;
    std::ifstream("/proc/self/statm") >> pages >> residentPages;
    const double MB = 1 << 20;
#if defined __GLIBC__ && __GLIBC_PREREQ(2, 33)
    const struct mallinfo2 info = mallinfo2();
    const Memory memory = {(double(info.uordblks) + double(info.hblkhd)) / MB,
                           double(residentPages) * double(sysconf(_SC_PAGESIZE)) / MB};
#else
    const Memory memory = {0, double(residentPages) * double(sysconf(_SC_PAGESIZE)) / MB};
#endif
    return memory;
}

//! Passes frames in random order through one object from several threads, with calls that fail among them.
bool runFrames(const std::vector<Frame>& frames, int count, int threads, bool checkMemory)
{
    const int ROUNDS = 20, WARM_UP = 4;
    const Ptr<AdaptiveQuadtreeORB> detector = AdaptiveQuadtreeORB::create(200);
    std::atomic<int> wrong(0), failed(0);
    std::vector<Memory> memory;
    std::printf("frames  heap MB  resident MB  wrong outputs\n");
    for (int round = 0; round < ROUNDS; round++)
    {
        std::vector<std::thread> workers;
        for (int t = 0; t < threads; t++)
        {
            workers.push_back(std::thread(
                [&, t]
                {
                    RNG rng(1 + round * threads + t);
                    for (int i = 0; i < count / ROUNDS / threads; i++)
                    {
                        const Frame& frame = frames[size_t(rng.uniform(0, int(frames.size())))];
                        wrong += !isAsAtFirst(*detector, frame);
                        if (i % 10 == 0)
                        {
                            wrong += !fails(*detector, frame, rng.uniform(0, 3));
                            failed++;
                        }
                    }
                }));
        }
        for (std::thread& worker : workers)
            worker.join();
        memory.push_back(memoryInUse());
        std::printf("%6d  %7.2f  %11.2f  %13d\n", (round + 1) * (count / ROUNDS), memory.back().heap,
                    memory.back().resident, int(wrong));
        std::fflush(stdout);
    }
    // When more threads than ever before are in a call at once, the detector needs one more work space. That may
    // still happen after the warm-up, so the limits below leave room for it.
    Memory before = {0, 0}, after = {0, 0};
    for (int i = 0; i < ROUNDS; i++)
    {
        Memory& part = i < WARM_UP ? before : after;
        part.heap = std::max(part.heap, memory[i].heap);
        part.resident = std::max(part.resident, memory[i].resident);
    }
    std::printf("%d frames on %d threads, %d calls that failed as they must, %d wrong outputs\n", count,
                threads, int(failed), int(wrong));
    std::printf(
        "most memory in the first %d rounds: heap %.2f MB, resident %.2f MB; later: %.2f MB, %.2f MB\n",
        WARM_UP, before.heap, before.resident, after.heap, after.resident);
    const bool grows = after.heap > before.heap + 2 || after.resident > before.resident + 8;
    if (grows)
        std::printf("memory %s\n", checkMemory ? "GROWS" : "is not checked");
    return wrong == 0 && !(checkMemory && grows);
}

//! Lets an allocation fail, chosen at random among those of a call, in new objects and in one in use.
bool runOutOfMemory(const std::vector<Frame>& frames, int count, int threads)
{
    setNumThreads(threads);
    RNG rng(7);
    int thrown = 0, wrong = 0;
    long allocations[] = {1, 1};  // in one call of a new object and of the one in use, as far as is known
    Ptr<AdaptiveQuadtreeORB> used = AdaptiveQuadtreeORB::create(200);
    for (int i = 0; i < count; i++)
    {
        const Frame& frame = frames[size_t(rng.uniform(0, int(frames.size())))];
        const bool isNew = i % 2 == 0;
        const Ptr<AdaptiveQuadtreeORB> detector = isNew ? AdaptiveQuadtreeORB::create(200) : used;
        {
            Features found;
            const AllocationCounter failing(rng.uniform(1, int(allocations[!isNew]) + 1));
            try
            {
                detector->detectAndCompute(frame.image, frame.mask, found.keypoints, found.descriptors);
            }
            catch (const std::bad_alloc&)
            {
                thrown++;
            }
            catch (const cv::Exception& e)
            {
                thrown++;
                wrong += e.code != Error::StsNoMem;
            }
        }
        wrong += !isAsAtFirst(*detector, frame);
        // A call that succeeds shows how many allocations there are to choose from: those of this thread.
        if (i < 64)
        {
            const Ptr<AdaptiveQuadtreeORB> probe = isNew ? AdaptiveQuadtreeORB::create(200) : used;
            Features found;
            const AllocationCounter counter;
            probe->detectAndCompute(frame.image, frame.mask, found.keypoints, found.descriptors);
            allocations[!isNew] = std::max(allocations[!isNew], counter.thatMayFail());
        }
    }
    std::printf(
        "%d calls in which an allocation was to fail (of up to %ld in a new object, %ld in one in use), "
        "OpenCV on %d thread(s): %d raised an exception, %d wrong outputs\n",
        count, allocations[0], allocations[1], threads, thrown, wrong);
    // How many of the calls allocate as often as chosen depends on the sizes of the frames and on the threads.
    return wrong == 0 && thrown > count / 10;
}

}  // namespace

// Whether OpenCV was built without a library for threads. Its own leave a mutex locked when memory runs out.
static bool threadsAreOpenCVsOwn()
{
    const std::string built = getBuildInformation();
    const size_t begin = built.find("Parallel framework:");
    return begin != std::string::npos &&
           built.substr(begin, built.find('\n', begin) - begin).find("pthreads") != std::string::npos;
}

int main(int argc, char** argv)
{
    const std::string unknown = tools::unknownOption(argc, argv, KEYS);
    if (!unknown.empty())
    {
        std::fprintf(stderr, "aqorb_soak: %s: unknown option; see --help\n", unknown.c_str());
        return 1;
    }
    const CommandLineParser arguments(argc, argv, KEYS);
    if (arguments.has("help"))
    {
        arguments.printMessage();
        return 0;
    }
    tools::silenceOpenCV();
    const std::vector<Frame> frames = makeFrames(60);
    const int failures = arguments.get<int>("failures");
    bool good = runFrames(frames, arguments.get<int>("frames"), arguments.get<int>("threads"),
                          !arguments.has("any-memory"));
    good = runOutOfMemory(frames, failures / 2, 1) && good;
    if (!threadsAreOpenCVsOwn())
        good = runOutOfMemory(frames, failures / 2, 2) && good;
    std::printf("%s\n", good ? "good" : "BAD");
    return good ? 0 : 1;
}
