// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "test_precomp.hpp"

namespace opencv_test
{
namespace
{

TEST(Aqorb_Determinism, what_lies_around_a_region_does_not_matter)
{
    // Image and mask are parts of larger matrices. What is around them changes, they do not. Without a border,
    // and with the narrow one, the detector reads pixels beyond the sides of the image.
    const Size size(200, 150);
    const Rect region(Point(29, 23), size);
    Mat image, mask = makeScene(size, 8) > 120;  // holes with many edges
    cvtColor(makeScene(size, 7), image, COLOR_GRAY2BGR);
    for (int border : {0, 3, 16})
        for (int firstLevel = 0; firstLevel <= 1; firstLevel++)
        {
            const Ptr<AdaptiveQuadtreeORB> detector =
                AdaptiveQuadtreeORB::create(200, 1.2f, 8, border, firstLevel);
            const Features expected = detectAndCompute(*detector, image, mask);
            const Features unmasked = detectAndCompute(*detector, image);
            // With firstLevel > 0 compute may drop a keypoint near the border, as that of cv::ORB does.
            Features expectedOfCompute = {expected.keypoints, Mat()};
            detector->compute(image, expectedOfCompute.keypoints, expectedOfCompute.descriptors);
            EXPECT_GE(expectedOfCompute.keypoints.size(), 190u);
            ASSERT_EQ(200u, expected.keypoints.size());
            for (int around = 0; around <= 255; around += 51)
            {
                SCOPED_TRACE(format("border %d, first level %d, around %d", border, firstLevel, around));
                Mat wholeImage(260, 310, CV_8UC3, Scalar::all(around));
                Mat wholeMask(260, 310, CV_8UC1, Scalar(around));
                image.copyTo(wholeImage(region));
                mask.copyTo(wholeMask(region));
                EXPECT_FALSE(wholeImage(region).isContinuous());
                EXPECT_TRUE(sameFeatures(expected,
                                         detectAndCompute(*detector, wholeImage(region), wholeMask(region))));
                EXPECT_TRUE(sameFeatures(unmasked, detectAndCompute(*detector, wholeImage(region))));
                Features computed = {expected.keypoints, Mat()};
                detector->compute(wholeImage(region), computed.keypoints, computed.descriptors);
                EXPECT_TRUE(sameFeatures(expectedOfCompute, computed));
            }
        }
}

TEST(Aqorb_Determinism, umat_equals_mat)
{
    const Mat image = makeScene(Size(300, 200));
    const Mat mask = image < 180;
    const Ptr<AdaptiveQuadtreeORB> detector = AdaptiveQuadtreeORB::create(300);
    const Features expected = detectAndCompute(*detector, image, mask);
    KeyPoints keypoints;
    UMat descriptors;
    detector->detectAndCompute(image.getUMat(ACCESS_READ), mask.getUMat(ACCESS_READ), keypoints, descriptors);
    const Features found = {keypoints, descriptors.getMat(ACCESS_READ).clone()};
    EXPECT_TRUE(sameFeatures(expected, found));

    // The same with the UMat's own memory, in colour, and as a region of a larger one.
    UMat whole;
    Mat color;
    cv::copyMakeBorder(image, color, 5, 6, 7, 8, BORDER_REFLECT);
    cvtColor(color, color, COLOR_GRAY2BGR);
    color.copyTo(whole);
    const UMat part = whole(Rect(Point(7, 5), image.size()));
    detector->detectAndCompute(part, mask, keypoints, descriptors);
    const Features ofPart = {keypoints, descriptors.getMat(ACCESS_READ).clone()};
    EXPECT_TRUE(sameFeatures(expected, ofPart));
    detector->compute(part, keypoints, descriptors);
    const Features computed = {keypoints, descriptors.getMat(ACCESS_READ).clone()};
    EXPECT_TRUE(sameFeatures(expected, computed));
    detector->detectAndCompute(UMat(), noArray(), keypoints, descriptors);
    EXPECT_TRUE(keypoints.empty());
    EXPECT_TRUE(descriptors.empty());
}

}  // namespace
}  // namespace opencv_test
