// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "test_precomp.hpp"

// Counterparts of OpenCV's own tests of ORB, and of what users reported about ORB and its relatives. The
// tests are named after the issue.

namespace opencv_test
{
namespace
{

//! What holds for all keypoints of all images.
void expectValid(const Features& features, Size imageSize)
{
    EXPECT_EQ(int(features.keypoints.size()), features.descriptors.rows);
    const Rect2f inside(0, 0, float(imageSize.width), float(imageSize.height));
    for (const KeyPoint& keypoint : features.keypoints)
    {
        EXPECT_TRUE(inside.contains(keypoint.pt)) << keypoint.pt.x << ", " << keypoint.pt.y;
        EXPECT_GT(keypoint.size, 0);
        EXPECT_GE(keypoint.angle, 0);
        EXPECT_LT(keypoint.angle, 360);
        EXPECT_GE(keypoint.octave, 0);
        EXPECT_EQ(-1, keypoint.class_id);
    }
}

// ---- modules/features2d/test/test_orb.cpp ----------------------------------------------------

TEST(Aqorb_Issues, opencv_5031_large_patch_near_border)
{
    const Mat image = Mat::zeros(Size(1920, 1080), CV_8UC3);
    const Ptr<ORB> orb = AdaptiveQuadtreeORB::create(8000, 1.2f, 18, 4, 0, 2, ORB::HARRIS_SCORE, 47, 20);
    KeyPoints keypoints(1, KeyPoint(443, 5, 47, 53.4580612f, 0.0000470733867f, 0, -1));
    Mat descriptors;
    ASSERT_NO_THROW(orb->compute(image, keypoints, descriptors));
    EXPECT_EQ(1u, keypoints.size());
    // On the image's very corner, and on levels much smaller than the patch.
    keypoints.clear();
    for (int octave = 0; octave < 30; octave++)
        keypoints.push_back(KeyPoint(5.f, 5.f, 47.f, 45.f, 0.f, octave));
    ASSERT_NO_THROW(orb->compute(image, keypoints, descriptors));
    EXPECT_EQ(30u, keypoints.size());
    EXPECT_EQ(30, descriptors.rows);
}

TEST(Aqorb_Issues, opencv_16197_first_level)
{
    const Ptr<ORB> orb = AdaptiveQuadtreeORB::create(500, 1.8f, 5, 8, 3, 2, ORB::HARRIS_SCORE, 8);
    EXPECT_TRUE(sameFeatures(Features(), detectAndCompute(*orb, Mat::zeros(72, 72, CV_8UC1))));
    const Features features = detectAndCompute(*orb, makeScene(Size(72, 72)));
    EXPECT_FALSE(features.keypoints.empty());
    expectValid(features, Size(72, 72));
}

TEST(Aqorb_Issues, keypoint_beside_an_enlarged_level)
{
    // Half a pixel of the image is 64 pixels of level 0. A disc around such a pixel lies outside of all memory.
    const int firstLevel = 7;
    const Ptr<ORB> orb = AdaptiveQuadtreeORB::create(500, 2.f, firstLevel + 1, 0, firstLevel);
    std::vector<KeyPoint> keypoints;
    for (int octave = 0; octave <= firstLevel; octave++)
        keypoints.push_back(KeyPoint(-0.5f, -0.5f, 31.f, 45.f, 0.f, octave));
    Mat descriptors;
    orb->compute(makeScene(Size(32, 32)), keypoints, descriptors);
    ASSERT_EQ(2u, keypoints.size());
    EXPECT_EQ(firstLevel - 1, keypoints[0].octave);
    EXPECT_EQ(2, descriptors.rows);
}

TEST(Aqorb_Issues, opencv_python_537_large_image)
{
    // OpenCV's test takes 25000 x 25000; what overflowed were offsets in a row and in the buffer. Here the
    // rows are as long, the image is not.
    const int width = 25000, height = 1000, border = 23;
    Mat image(Size(width, height), CV_8UC1, Scalar::all(0));
    for (int i = 0; i < 23; i++)
    {
        line(image, Point(border + i * 100, border + i * 10),
             Point(width - border - i * 100, height - border - i * 10), Scalar(255), 1, LINE_AA);
    }
    Features features;
    ASSERT_NO_THROW(features = detectAndCompute(*AdaptiveQuadtreeORB::create(31), image));
    EXPECT_EQ(31u, features.keypoints.size());
    expectValid(features, image.size());
}

// ---- what users reported ---------------------------------------------------------------------

TEST(Aqorb_Issues, opencv_4517_dark_image)
{
    // "Threshold depends on the dynamic range": 4 keypoints in a dark image.
    Mat dark;
    makeScene(Size(640, 480)).convertTo(dark, CV_8U, 0.12);
    KeyPoints ours, orb;
    AdaptiveQuadtreeORB::create(500)->detect(dark, ours);
    ORB::create(500)->detect(dark, orb);
    EXPECT_GE(ours.size(), 250u);
    EXPECT_GT(ours.size(), 2 * orb.size());
}

TEST(Aqorb_Issues, opencv_17353_11359_sizes)
{
    int large = 0;
    for (const Size& size :
         {Size(1, 1), Size(2, 1), Size(1, 300), Size(3, 3), Size(7, 7), Size(64, 1), Size(20, 20),
          Size(31, 31), Size(33, 33), Size(34, 35), Size(37, 91), Size(63, 65), Size(61, 7), Size(300, 800),
          Size(4000, 40), Size(34, 500), Size(40, 4000)})
        for (int border : {0, 3, 16, 31})
            for (int nlevels : {1, 8, 30})
                for (int patchSize : {2, 31, 61})
                {
                    SCOPED_TRACE(format("%d x %d, %d, %d", size.width, size.height, border, nlevels));
                    const Ptr<Feature2D> detector = AdaptiveQuadtreeORB::create(
                        200, 1.2f, nlevels, border, 0, 2, ORB::HARRIS_SCORE, patchSize);
                    const Features features = detectAndCompute(*detector, makeNoise(size));
                    expectValid(features, size);
                    EXPECT_LE(features.keypoints.size(), 200u);
                    // The pixels of level 0 within the border and the circle of FAST are enough for all.
                    const Size inner = size - Size(1, 1) * (2 * std::max(border, 3) + 2);
                    if (inner.width <= 0 || inner.height <= 0 || inner.area() <= 200 * 60)
                        continue;
                    EXPECT_EQ(200u, features.keypoints.size());
                    large++;
                }
    EXPECT_GT(large, 0);
}

}  // namespace
}  // namespace opencv_test
