// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "reference.hpp"

// An object keeps its work space from call to call. Nothing of an earlier call may show in a later one.

namespace opencv_test
{
namespace
{

//! A call that fails after the work space is in use. It may leave other parameters.
void fail(AdaptiveQuadtreeORB& detector, const Mat& image, int kind)
{
    Features features;
    if (kind == 0)
    {
        KeyPoints keypoints(1, KeyPoint(Point2f(20, 20), 31.f, 0.f, 0.f, 1 << 16));
        EXPECT_THROW(detector.compute(image, keypoints, features.descriptors), cv::Exception);
    }
    else if (kind == 1)
    {
        const Mat mask(image.rows, image.cols + 1, CV_8UC1, Scalar(1));
        EXPECT_THROW(detector.detect(image, features.keypoints, mask), cv::Exception);
    }
    else
    {
        detector.setNLevels(60);
        detector.setFirstLevel(59);
        detector.setScaleFactor(1e6);  // a level of more pixels than can be
        EXPECT_THROW(detector.detect(image, features.keypoints), cv::Exception);
    }
}

TEST(Aqorb_Reuse, an_object_gives_what_a_new_one_gives)
{
    RNG rng(20);
    const Ptr<AdaptiveQuadtreeORB> used = AdaptiveQuadtreeORB::create();
    reference::Settings settings;
    for (int round = 0; round < 80; round++)
    {
        SCOPED_TRACE(round);
        if (round % 3 != 1)  // Every third time only the image changes.
            settings = reference::randomSettings(rng);
        const Size size(rng.uniform(30, 200), rng.uniform(30, 200));
        Mat image = round % 5 ? makeScene(size, round + 1) : makeNoise(size, round + 1);
        if (round % 16 == 7)
            image.setTo(7);  // There is nothing to find.
        Mat mask;
        if (round % 4 == 0)
            mask = makeNoise(Size(size.width / 8 + 1, size.height / 8 + 1), round + 9) > 60;
        if (!mask.empty())
            cv::resize(mask, mask, size, 0, 0, INTER_NEAREST);
        fail(*used, image, round % 3);
        settings.set(*used);
        const Features expected = detectAndCompute(*settings.create(), image, mask);
        EXPECT_TRUE(sameFeatures(expected, detectAndCompute(*used, image, mask)));
        // compute keeps its levels in the same memory.
        Features computed = {expected.keypoints, Mat()}, computedAnew = computed;
        used->compute(image, computed.keypoints, computed.descriptors);
        settings.create()->compute(image, computedAnew.keypoints, computedAnew.descriptors);
        EXPECT_TRUE(sameFeatures(computedAnew, computed));
    }
}

TEST(Aqorb_Reuse, inputs_are_not_written_to)
{
    const Mat image = makeScene(Size(180, 140)), mask = makeNoise(image.size()) > 10;
    const Mat imageBefore = image.clone(), maskBefore = mask.clone();
    for (int firstLevel = 0; firstLevel < 3; firstLevel++)
    {
        const Ptr<AdaptiveQuadtreeORB> detector = AdaptiveQuadtreeORB::create(200, 1.2f, 5, 8, firstLevel);
        for (int round = 0; round < 2; round++)
        {
            Features features = detectAndCompute(*detector, image, mask);
            // The levels of another image of the same size go where those of this one went.
            detectAndCompute(*detector, makeNoise(image.size(), 3));
            detector->compute(image, features.keypoints, features.descriptors);
            EXPECT_TRUE(sameMat(imageBefore, image));
            EXPECT_TRUE(sameMat(maskBefore, mask));
        }
    }
}

TEST(Aqorb_Reuse, earlier_outputs_stay_as_they_are)
{
    const Ptr<AdaptiveQuadtreeORB> detector = AdaptiveQuadtreeORB::create(150);
    const Mat first = makeScene(Size(200, 150), 1), second = makeScene(Size(200, 150), 2);
    const Features kept = detectAndCompute(*detector, first);
    const Features copy = {kept.keypoints, kept.descriptors.clone()};
    detectAndCompute(*detector, second);
    EXPECT_TRUE(sameFeatures(copy, kept));
}

TEST(Aqorb_Reuse, outputs_may_hold_anything)
{
    const Ptr<AdaptiveQuadtreeORB> detector = AdaptiveQuadtreeORB::create(100);
    const Mat image = makeScene(Size(200, 150));
    const Features expected = detectAndCompute(*detector, image);
    ASSERT_EQ(100, expected.descriptors.rows);
    const Mat outputs[] = {Mat(), Mat(100, 32, CV_32FC1, Scalar(3)), Mat(7, 9, CV_8UC3, Scalar::all(3)),
                           Mat(100, 32, CV_8UC1, Scalar(3))};
    for (const Mat& output : outputs)
    {
        Features features = {KeyPoints(333), output.clone()};
        detector->detectAndCompute(image, noArray(), features.keypoints, features.descriptors);
        EXPECT_TRUE(sameFeatures(expected, features));
    }
    // The output may be a part of a larger matrix, whose rows are not contiguous.
    Mat large(104, 40, CV_8UC1, Scalar(77));
    const Rect part(5, 2, 32, 100);
    Features features = {KeyPoints(), large(part)};
    detector->detectAndCompute(image, noArray(), features.keypoints, features.descriptors);
    EXPECT_TRUE(sameMat(expected.descriptors, large(part)));
    large(part).setTo(77);
    EXPECT_EQ(0, countNonZero(large != 77));
}

TEST(Aqorb_Reuse, outputs_may_be_left_out)
{
    const Ptr<AdaptiveQuadtreeORB> detector = AdaptiveQuadtreeORB::create(100);
    const Mat image = makeScene(Size(200, 150));
    const Features expected = detectAndCompute(*detector, image);
    KeyPoints keypoints;
    detector->detectAndCompute(image, noArray(), keypoints, noArray());
    EXPECT_TRUE(sameKeypoints(expected.keypoints, keypoints));
    // Without outputs there is nothing to do, so the keypoints are not even looked at. cv::ORB does the same.
    keypoints.assign(3, KeyPoint(Point2f(-5, 1e9f), 31.f, 0.f, 0.f, -4));
    const KeyPoints given = keypoints;
    detector->detectAndCompute(image, noArray(), keypoints, noArray(), true);
    EXPECT_TRUE(sameKeypoints(given, keypoints));
    // Without keypoints there are no descriptors.
    keypoints.clear();
    Mat descriptors(3, 32, CV_8UC1);
    detector->compute(image, keypoints, descriptors);
    EXPECT_TRUE(keypoints.empty());
    EXPECT_TRUE(descriptors.empty());
}

}  // namespace
}  // namespace opencv_test
