// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "reference.hpp"

namespace opencv_test
{
namespace
{

TEST(Aqorb_Contracts, defaults)
{
    const Ptr<AdaptiveQuadtreeORB> detector = AdaptiveQuadtreeORB::create();
    EXPECT_EQ(500, detector->getMaxFeatures());
    EXPECT_EQ((double)1.2f, detector->getScaleFactor());
    EXPECT_EQ(8, detector->getNLevels());
    EXPECT_EQ(16, detector->getEdgeThreshold());
    EXPECT_EQ(0, detector->getFirstLevel());
    EXPECT_EQ(2, detector->getWTA_K());
    EXPECT_EQ(ORB::HARRIS_SCORE, detector->getScoreType());
    EXPECT_EQ(31, detector->getPatchSize());
    EXPECT_EQ(20, detector->getFastThreshold());
    EXPECT_TRUE(detector->getAdaptiveThreshold());
    EXPECT_EQ(4, detector->getMinThresholdRatio());
    EXPECT_EQ(AdaptiveQuadtreeORB::RANKED_SELECTION, detector->getSelectionType());
    EXPECT_EQ(0.05, detector->getStrengthWeight());
    EXPECT_EQ(1, detector->getRankRadius());
    EXPECT_EQ(-1, detector->getOctaveSuppression());
    EXPECT_TRUE(detector->getSubPixel());
}

TEST(Aqorb_Contracts, the_default_of_octave_suppression_follows_the_weight)
{
    const Mat image = makeScene(Size(320, 240));
    const auto features = [&](double octaveSuppression)
    {
        const Ptr<AdaptiveQuadtreeORB> detector = AdaptiveQuadtreeORB::create(1000);
        detector->setOctaveSuppression(octaveSuppression);
        return detectAndCompute(*detector, image);
    };
    EXPECT_TRUE(sameFeatures(features(2), features(-1)));
    EXPECT_FALSE(sameFeatures(features(0.5), features(-1)));
}

TEST(Aqorb_Contracts, the_papers_method_is_one_switch)
{
    const Mat image = makeScene(Size(320, 240));
    const Ptr<AdaptiveQuadtreeORB> detector = AdaptiveQuadtreeORB::create(300);
    detector->setSelectionType(AdaptiveQuadtreeORB::QUADTREE_SELECTION);
    const Features expected = detectAndCompute(*detector, image);
    for (const KeyPoint& keypoint : expected.keypoints)
    {
        const float scale = reference::levelScale(keypoint.octave, 0, detector->getScaleFactor());
        EXPECT_EQ(keypoint.pt,
                  Point2f(float(cvRound(keypoint.pt.x / scale)), float(cvRound(keypoint.pt.y / scale))) *
                      scale);
    }
    detector->setSubPixel(false);
    detector->setOctaveSuppression(3);
    detector->setStrengthWeight(5);
    detector->setRankRadius(7);
    EXPECT_TRUE(sameFeatures(expected, detectAndCompute(*detector, image)));
    EXPECT_FALSE(detector->getSubPixel());
    EXPECT_EQ(7, detector->getRankRadius());
    detector->setMinThresholdRatio(1);
    EXPECT_FALSE(sameFeatures(expected, detectAndCompute(*detector, image)));
}

TEST(Aqorb_Contracts, is_an_orb)
{
    const Ptr<ORB> orb = AdaptiveQuadtreeORB::create(77, 1.5f, 3, 20, 1, 4, ORB::FAST_SCORE, 25, 9);
    EXPECT_EQ(77, orb->getMaxFeatures());
    EXPECT_EQ(1.5, orb->getScaleFactor());
    EXPECT_EQ(3, orb->getNLevels());
    EXPECT_EQ(20, orb->getEdgeThreshold());
    EXPECT_EQ(1, orb->getFirstLevel());
    EXPECT_EQ(4, orb->getWTA_K());
    EXPECT_EQ(ORB::FAST_SCORE, orb->getScoreType());
    EXPECT_EQ(25, orb->getPatchSize());
    EXPECT_EQ(9, orb->getFastThreshold());
    EXPECT_EQ(32, orb->descriptorSize());
    EXPECT_EQ(CV_8U, orb->descriptorType());
    EXPECT_EQ((int)NORM_HAMMING2, orb->defaultNorm());
    orb->setWTA_K(3);
    EXPECT_EQ((int)NORM_HAMMING2, orb->defaultNorm());
    orb->setWTA_K(2);
    EXPECT_EQ((int)NORM_HAMMING, orb->defaultNorm());
    EXPECT_FALSE(orb->empty());
    EXPECT_EQ("Feature2D.AdaptiveQuadtreeORB", orb->getDefaultName());
}

TEST(Aqorb_Contracts, fields_of_keypoints)
{
    const AdaptiveQuadtreeORB::SelectionType selections[] = {AdaptiveQuadtreeORB::RANKED_SELECTION,
                                                             AdaptiveQuadtreeORB::QUADTREE_SELECTION};
    for (AdaptiveQuadtreeORB::SelectionType selection : selections)
    {
        SCOPED_TRACE(int(selection));
        const Ptr<AdaptiveQuadtreeORB> detector =
            AdaptiveQuadtreeORB::create(400, 1.3f, 5, 12, 0, 2, ORB::HARRIS_SCORE, 27);
        detector->setSelectionType(selection);
        KeyPoints keypoints;
        detector->detect(makeScene(Size(400, 300)), keypoints);
        ASSERT_EQ(400u, keypoints.size());
        for (const KeyPoint& keypoint : keypoints)
        {
            ASSERT_TRUE(keypoint.octave >= 0 && keypoint.octave < 5);
            EXPECT_EQ(27 * (float)std::pow((double)1.3f, keypoint.octave), keypoint.size);
            EXPECT_EQ(-1, keypoint.class_id);
            EXPECT_TRUE(keypoint.angle >= 0 && keypoint.angle < 360);
            EXPECT_TRUE(keypoint.pt.x >= 12 && keypoint.pt.x < 388 && keypoint.pt.y >= 12 &&
                        keypoint.pt.y < 288);
        }
        EXPECT_EQ(4, keypoints.back().octave);
    }
}

TEST(Aqorb_Contracts, one_level_needs_no_scale_factor)
{
    const Mat image = makeScene(Size(320, 240), 6);
    const Features expected = detectAndCompute(*AdaptiveQuadtreeORB::create(300, 2.f, 1), image);
    EXPECT_EQ(300u, expected.keypoints.size());
    const float factors[] = {1.f, 0.5f, 1e-30f, 1e30f};
    for (float factor : factors)
    {
        const Ptr<AdaptiveQuadtreeORB> detector = AdaptiveQuadtreeORB::create(300, factor, 1);
        EXPECT_TRUE(sameFeatures(expected, detectAndCompute(*detector, image))) << factor;
    }
}

TEST(Aqorb_Contracts, nothing_found_clears_both_outputs)
{
    const Ptr<AdaptiveQuadtreeORB> detector = AdaptiveQuadtreeORB::create();
    const Mat images[] = {Mat(), Mat::zeros(1, 1, CV_8UC1), Mat::zeros(300, 300, CV_8UC1),
                          Mat(300, 300, CV_8UC1, Scalar(255)), makeNoise(Size(32, 32))};
    for (const Mat& image : images)
    {
        Features stale = {KeyPoints(9), Mat::ones(9, 32, CV_8UC1)};
        detector->detectAndCompute(image, noArray(), stale.keypoints, stale.descriptors);
        EXPECT_TRUE(stale.keypoints.empty());
        EXPECT_TRUE(stale.descriptors.empty());
    }
    Features stale = {KeyPoints(9), Mat::ones(9, 32, CV_8UC1)};
    detector->detectAndCompute(Mat(), noArray(), stale.keypoints, stale.descriptors, true);
    EXPECT_TRUE(stale.keypoints.empty());
    EXPECT_TRUE(stale.descriptors.empty());
}

TEST(Aqorb_Contracts, night_and_half_black_images)
{
    const Ptr<AdaptiveQuadtreeORB> detector = AdaptiveQuadtreeORB::create(500);
    const Mat scene = makeScene(Size(640, 480), 3);
    KeyPoints keypoints;

    // A few lamps: equation (7) is in the hundreds, but the detector is not stricter than cv::ORB.
    Mat night = makeNoise(scene.size()) / 80;
    for (int i = 0; i < 5; i++)
        rectangle(night, Rect(60 + 110 * i, 90 + 60 * i, 18, 14), Scalar(255), -1);
    EXPECT_GT(aqorb::adaptiveFastThreshold(night), 60);
    KeyPoints ofORB;
    ORB::create(500, 1.2f, 8, 16)->detect(night, ofORB);
    detector->detect(night, keypoints);
    ASSERT_GT(ofORB.size(), 10u);
    EXPECT_GE(keypoints.size(), ofORB.size());

    Mat half = scene.clone();
    half.colRange(0, 320).setTo(0);
    detector->detect(half, keypoints);
    EXPECT_EQ(500u, keypoints.size());
    for (const KeyPoint& keypoint : keypoints)
        EXPECT_GT(keypoint.pt.x, 310);
}

}  // namespace
}  // namespace opencv_test
