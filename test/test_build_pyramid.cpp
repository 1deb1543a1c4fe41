// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "reference.hpp"

// AdaptiveQuadtreeORB::buildPyramid gives the levels that detection uses.

namespace opencv_test
{
namespace
{

TEST(Aqorb_BuildPyramid, is_what_detection_uses)
{
    const Mat image = makeScene(Size(211, 157));
    const float factors[] = {1.1f, 1.2f, 2.f};
    for (float factor : factors)
        for (int firstLevel = 0; firstLevel <= 2; firstLevel++)
        {
            const Ptr<AdaptiveQuadtreeORB> detector =
                AdaptiveQuadtreeORB::create(500, factor, 4, 16, firstLevel);
            std::vector<Mat> levels;
            detector->buildPyramid(image, levels);
            const std::vector<Mat> expected = reference::pyramid(image, 4, firstLevel, factor);
            ASSERT_EQ(4u, levels.size());
            for (int i = 0; i < 4; i++)
                EXPECT_TRUE(sameMat(expected[i], levels[i])) << factor << " " << firstLevel << " " << i;
        }
}

// A level given as an image has the features that it has as a level.
TEST(Aqorb_BuildPyramid, holds_the_levels_of_orb)
{
    const Mat image = makeScene(Size(400, 300));
    std::vector<Mat> levels;
    AdaptiveQuadtreeORB::create()->buildPyramid(image, levels);
    for (int octave = 0; octave < 4; octave++)
    {
        const float scale = reference::levelScale(octave, 0, 1.2f);
        Mat onLevel, onImage;
        KeyPoints keypoints(1, KeyPoint(80.f, 70.f, 31, 30, 1, 0));
        ORB::create()->compute(levels[octave], keypoints, onLevel);
        keypoints[0].pt *= scale;
        keypoints[0].octave = octave;
        ORB::create()->compute(image, keypoints, onImage);
        EXPECT_TRUE(sameMat(onImage, onLevel)) << "octave " << octave;
    }
}

TEST(Aqorb_BuildPyramid, takes_what_detection_takes)
{
    const Ptr<AdaptiveQuadtreeORB> detector = AdaptiveQuadtreeORB::create();
    const Mat image = makeScene(Size(200, 150));
    std::vector<Mat> expected, levels;
    detector->buildPyramid(image, expected);
    ASSERT_EQ(8u, expected.size());

    Mat colour;
    cvtColor(image, colour, COLOR_GRAY2BGR);
    detector->buildPyramid(colour.getUMat(ACCESS_READ), levels);
    ASSERT_EQ(expected.size(), levels.size());
    for (size_t i = 0; i < levels.size(); i++)
        EXPECT_TRUE(sameMat(expected[i], levels[i]));

    std::vector<UMat> ulevels(2);
    detector->buildPyramid(image, ulevels);
    ASSERT_EQ(expected.size(), ulevels.size());
    for (size_t i = 0; i < ulevels.size(); i++)
        EXPECT_TRUE(sameMat(expected[i], ulevels[i].getMat(ACCESS_READ)));

    const Mat before = levels[0];
    levels[0].setTo(0);
    detector->buildPyramid(image, levels);
    EXPECT_TRUE(sameMat(expected[0], levels[0]));
    EXPECT_TRUE(sameMat(image, expected[0]));  // its own memory
    EXPECT_NE(before.data, levels[0].data);

    EXPECT_THROW(detector->buildPyramid(Mat(9, 9, CV_32FC1, Scalar(0)), levels), cv::Exception);
    EXPECT_EQ(8u, levels.size());
    detector->buildPyramid(Mat(), levels);
    EXPECT_TRUE(levels.empty());
    detector->setFirstLevel(8);
    EXPECT_THROW(detector->buildPyramid(image, levels), cv::Exception);
}

}  // namespace
}  // namespace opencv_test
