// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "test_precomp.hpp"

#include <opencv2/core/utility.hpp>
#include <opencv2/core/utils/logger.hpp>

#include <atomic>
#include <fstream>
#include <iostream>
#include <thread>

// The long run: frames of changing sizes through one object from several threads, and calls that fail. Each output must
// be what a new object gave, and memory must not grow. AQORB_SOAK_FRAMES makes it longer.

namespace opencv_test
{
namespace
{

//! Keeps OpenCV from printing the messages of exceptions until it goes out of scope, where thousands are expected.
class Quiet
{
public:
    Quiet() : before(utils::logging::setLogLevel(utils::logging::LOG_LEVEL_SILENT))
    {
        redirectError([](int, const char*, const char*, const char*, int, void*) { return 0; });
    }
    ~Quiet()
    {
        redirectError(0);
        utils::logging::setLogLevel(before);
    }

private:
    const utils::logging::LogLevel before;
};

int frameCount()
{
    const char* const frames = std::getenv("AQORB_SOAK_FRAMES");
    return frames ? std::max(std::atoi(frames), 200) : 2000;
}

//! An image, for some with a mask, and the features that a new detector finds in it.
struct Frame
{
    explicit Frame(int i)
    {
        RNG rng(i + 1);
        const Size size(rng.uniform(20, 200), rng.uniform(20, 160));
        image = i % 4 ? makeScene(size, i + 1) : makeNoise(size, i + 1);
        if (i % 3 == 0)
            mask = makeScene(size, i + 2) > 100;
        if (i % 7 == 0)
            cvtColor(image, image, COLOR_GRAY2BGR);
        expected = detectAndCompute(*AdaptiveQuadtreeORB::create(200), image, mask);
    }

    bool isGivenBy(Feature2D& detector) const
    {
        Features found = detectAndCompute(detector, image, mask);
        if (!sameFeatures(found, expected))
            return false;
        detector.compute(image, found.keypoints, found.descriptors);
        return bool(sameFeatures(found, expected));
    }

    Mat image, mask;
    Features expected;
};

std::vector<Frame> makeFrames()
{
    std::vector<Frame> frames;
    for (int i = 0; i < 60; i++)
        frames.push_back(Frame(i));
    return frames;
}

//! Makes a call that must fail. Returns false if it does not.
bool fails(Feature2D& detector, const Frame& frame, int kind)
{
    KeyPoints keypoints;
    Mat descriptors;
    try
    {
        if (kind == 0)  // before anything is computed
            detector.detect(Mat(10, 10, CV_32FC1, Scalar(0)), keypoints);
        else if (kind == 1)  // after the image was checked
            detector.detect(frame.image, keypoints, Mat(7, 7, CV_8UC1, Scalar(1)));
        else  // while memory of the detector is in use
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
    double used, resident;  //!< MB; resident: of Linux, else 0
};

Memory memoryNow()
{
    long pages = 0, resident = 0;
    std::ifstream("/proc/self/statm") >> pages >> resident;
    return {double(heapInUse()) / (1 << 20), double(resident) * 4096 / (1 << 20)};
}

TEST(Aqorb_Soak, threads_share_an_object_that_does_not_grow)
{
    const int ROUNDS = 20, WARM_UP = 4, THREADS = 4, PER_THREAD = frameCount() / ROUNDS / THREADS;
    const Quiet quiet;
    const std::vector<Frame> frames = makeFrames();
    const Ptr<AdaptiveQuadtreeORB> detector = AdaptiveQuadtreeORB::create(200);
    std::atomic<int> wrong(0), failed(0);
    // The most in use between rounds. A round may need one more work space than ever.
    Memory before = {0, 0}, after = {0, 0};
    for (int round = 0; round < ROUNDS; round++)
    {
        std::vector<std::thread> workers;
        for (int t = 0; t < THREADS; t++)
        {
            workers.push_back(std::thread(
                [&, t]
                {
                    RNG rng(1 + round * THREADS + t);
                    for (int i = 0; i < PER_THREAD; i++)
                    {
                        const Frame& frame = frames[size_t(rng.uniform(0, int(frames.size())))];
                        wrong += !frame.isGivenBy(*detector);
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
        const Memory now = memoryNow();
        Memory& most = round < WARM_UP ? before : after;
        most = {std::max(most.used, now.used), std::max(most.resident, now.resident)};
    }
    std::cout << format("%d frames on %d threads, %d calls that failed as they must, %d wrong outputs\n"
                        "most memory in the first %d rounds of %d: %.2f MB used, %.2f MB resident; later: "
                        "%.2f MB, %.2f MB\n",
                        PER_THREAD * ROUNDS * THREADS, THREADS, int(failed), int(wrong), WARM_UP, ROUNDS,
                        before.used, before.resident, after.used, after.resident);
    EXPECT_EQ(0, wrong);
    EXPECT_LE(after.used, before.used + 2);
    if (frameCount() >
        2000)  // short runs are those of sanitizers and emulators, which keep memory of their own
    {
        EXPECT_LE(after.resident, before.resident + 8);
    }
}

}  // namespace
}  // namespace opencv_test
