// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "test_precomp.hpp"

#include <opencv2/core/utility.hpp>

#include <atomic>
#include <thread>

// The long run: frames of changing sizes through one object from several threads, and calls that fail. Each output must
// be what a new object gave, and memory must not grow. AQORB_SOAK_FRAMES makes it longer.

namespace opencv_test
{
namespace
{

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

TEST(Aqorb_Soak, threads_share_an_object_that_does_not_grow)
{
    const int ROUNDS = 20, WARM_UP = 4, THREADS = 4, PER_THREAD = frameCount() / ROUNDS / THREADS;
    const std::vector<Frame> frames = makeFrames();
    const Ptr<AdaptiveQuadtreeORB> detector = AdaptiveQuadtreeORB::create(200);
    std::atomic<int> wrong(0);
    // The most in use between rounds. A round may need one more work space than ever.
    long long before = 0, after = 0;  // bytes
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
                            wrong += !fails(*detector, frame, rng.uniform(0, 3));
                    }
                }));
        }
        for (std::thread& worker : workers)
            worker.join();
        long long& most = round < WARM_UP ? before : after;
        most = std::max(most, heapInUse());
    }
    EXPECT_EQ(0, wrong);
    if (isHeapKnown())  // a sanitizer keeps memory of its own
    {
        EXPECT_LE(after, before + 2000000);
    }
}

}  // namespace
}  // namespace opencv_test
