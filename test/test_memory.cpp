// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "test_precomp.hpp"

#include "allocations.hpp"

namespace opencv_test
{
namespace
{

//! With several threads the memory in use would depend on how many levels they happen to work on at once.
class OneThread
{
public:
    OneThread() : before(getNumThreads()) { setNumThreads(1); }
    ~OneThread() { setNumThreads(before); }

private:
    const int before;
};

// The other tests expect no allocation, and would hold as well if none was counted.
TEST(Aqorb_Memory, allocations_are_counted_and_fail_on_request)
{
    const AllocationCounter allocations(3);
    const Mat matrix(10, 10, CV_8UC1);
    EXPECT_EQ(1, allocations.ofMatrices());
    EXPECT_EQ(0, allocations.ofNew());
    ::operator delete(::operator new(10));
    EXPECT_EQ(1, allocations.ofNew());
    EXPECT_THROW(Mat(10, 10, CV_8UC1), cv::Exception);
    EXPECT_NO_THROW(Mat(10, 10, CV_8UC1));
}

TEST(Aqorb_Memory, a_stream_of_frames_allocates_nothing_anew)
{
    const OneThread oneThread;
    const Ptr<AdaptiveQuadtreeORB> detector = AdaptiveQuadtreeORB::create(300);
    std::vector<Mat> frames;
    for (int seed = 1; seed <= 4; seed++)
        frames.push_back(makeScene(Size(320, 240), seed));
    Features features;
    const auto detectAll = [&]
    {
        for (const Mat& frame : frames)
        {
            detector->detectAndCompute(frame, noArray(), features.keypoints, features.descriptors);
            ASSERT_EQ(300, features.descriptors.rows);  // or the output itself would be allocated again
        }
    };
    for (int round = 0; round < 20; round++)  // until the buffers have grown to their final sizes
        detectAll();

    const AllocationCounter allocations;
    for (int round = 0; round < 3; round++)
        detectAll();
    if (checkHardwareSupport(CPU_AVX2))  // without AVX2 cv::resize makes the pyramid, and it allocates
    {
        EXPECT_EQ(0, allocations.ofNew());
    }
    EXPECT_EQ(0, allocations.ofMatrices());
}

TEST(Aqorb_Memory, packed_octaves_fail_before_any_level_is_allocated)
{
    const Mat image = makeScene(Size(200, 150));
    const Ptr<AdaptiveQuadtreeORB> detector = AdaptiveQuadtreeORB::create();
    const int octaves[] = {-1, 255, 1 << 8 | 1, 0x01000200 + 255, INT_MAX, INT_MIN};
    for (int octave : octaves)
    {
        KeyPoints keypoints(3, KeyPoint(Point2f(100, 70), 31.f));
        keypoints[1].octave = octave;
        Mat descriptors;
        const AllocationCounter allocations;
        EXPECT_THROW(detector->compute(image, keypoints, descriptors), cv::Exception) << octave;
        EXPECT_EQ(0, allocations.ofMatrices()) << octave;
    }
}

TEST(Aqorb_Memory, the_image_and_the_mask_are_not_kept)
{
    const Ptr<AdaptiveQuadtreeORB> detector = AdaptiveQuadtreeORB::create(100, 1.2f, 4, 8, 1);
    const Mat image = makeScene(Size(160, 120)), mask(image.size(), CV_8UC1, Scalar(1));
    Features features = detectAndCompute(*detector, image, mask);
    EXPECT_EQ(1, image.u->refcount);
    EXPECT_EQ(1, mask.u->refcount);
    detector->compute(image, features.keypoints, features.descriptors);
    EXPECT_EQ(1, image.u->refcount);
    const Mat noPixel(image.size(), CV_16UC1, Scalar(0));
    EXPECT_THROW(detector->detect(noPixel, features.keypoints), cv::Exception);
    EXPECT_THROW(detector->detect(image, features.keypoints, noPixel), cv::Exception);
    EXPECT_EQ(1, image.u->refcount);
    EXPECT_EQ(1, noPixel.u->refcount);
}

}  // namespace
}  // namespace opencv_test
