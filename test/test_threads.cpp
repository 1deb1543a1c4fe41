// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "test_precomp.hpp"

#include "backends.hpp"
#include "reference.hpp"

#include <opencv2/core/utility.hpp>

// Whatever cv::parallel_for_ does with the workers of a frame, the bytes are the same.

namespace opencv_test
{
namespace
{

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
                        {image, Mat(), 400, AdaptiveQuadtreeORB::QUADTREE_SELECTION}};
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

TEST(Aqorb_Threads, threads_1_to_16_of_any_backend_give_the_same_bytes)
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

//! Has more threads each time that it is asked for their number, as if the program called cv::setNumThreads meanwhile.
class MoreThreads : public NewThreads
{
public:
    MoreThreads() : asked(0) {}
    int getNumThreads() const CV_OVERRIDE { return std::min(int(++asked), 16); }

private:
    mutable std::atomic<int> asked;
};

TEST(Aqorb_Threads, threads_may_grow_in_number_during_a_call)
{
    const Call call = calls()[0];
    const Features expected = expectedOf(call);
    const BackendScope scope(std::make_shared<MoreThreads>());
    EXPECT_TRUE(gives(*detectorOf(call), call, expected));
}

// All corners are in the upper part of the image, so that some bands have too few and others none.
TEST(Aqorb_Threads, threads_give_the_same_bytes_when_representatives_run_out)
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

TEST(Aqorb_Threads, threads_of_the_caller_give_the_same_bytes)
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

}  // namespace
}  // namespace opencv_test
