// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// Promises of the tutorial "What you can rely on", in its words, and of the header.

#include "reference.hpp"

#include "detector/parameter_table.hpp"

#include <set>

namespace opencv_test
{
namespace
{

using reference::Settings;

const AdaptiveQuadtreeORB::SelectionType SELECTIONS[] = {AdaptiveQuadtreeORB::RANKED_SELECTION,
                                                         AdaptiveQuadtreeORB::QUADTREE_SELECTION};

//! The pixel of its level at which a keypoint was detected.
Point detectedPixel(const KeyPoint& keypoint, const AdaptiveQuadtreeORB& detector)
{
    const float scale =
        reference::levelScale(keypoint.octave, detector.getFirstLevel(), detector.getScaleFactor());
    return Point(cvRound(keypoint.pt.x / scale), cvRound(keypoint.pt.y / scale));
}

TEST(Aqorb_Promises, as_many_keypoints_as_fast_finds_corners_on_the_levels)
{
    int64 corners = 0;
    for (int seed = 1; seed <= 200; seed++)
    {
        SCOPED_TRACE(seed);
        RNG rng(seed);
        Settings s = reference::randomSettings(rng);
        s.adaptiveThreshold = false;
        const Mat image = makeScene(Size(rng.uniform(40, 160), rng.uniform(40, 160)), seed);
        const Ptr<AdaptiveQuadtreeORB> detector = s.create();

        std::vector<Mat> levels;
        detector->buildPyramid(image, levels);
        const int lowest = reference::thresholds(0, false, s.fastThreshold, s.minThresholdRatio).min;
        int all = 0;
        KeyPoints keypoints;
        for (const Mat& level : levels)
        {
            const int border = s.edgeThreshold;
            const Rect inside(border, border, level.cols - 2 * border, level.rows - 2 * border);
            cv::FAST(level, keypoints, lowest, true);
            all += int(std::count_if(keypoints.begin(), keypoints.end(),
                                     [&](const KeyPoint& k) { return inside.contains(k.pt); }));
        }
        corners += all;
        for (int nfeatures : {all / 2, all, all + 1, 1 << 20})
        {
            detector->setMaxFeatures(nfeatures);
            detector->detect(image, keypoints);
            ASSERT_EQ(std::min(nfeatures, all), int(keypoints.size())) << "nfeatures " << nfeatures;
        }
    }
    EXPECT_GT(corners, 10000);
}

TEST(Aqorb_Promises, positions_lie_in_the_image)
{
    // Where levels are enlarged, a position may lie between the centre of the last pixel and its far side.
    int beyondTheLastCentre = 0;
    for (int seed = 1; seed <= 200; seed++)
    {
        SCOPED_TRACE(seed);
        RNG rng(seed);
        Settings s = reference::randomSettings(rng);
        s.nfeatures = 5000;
        s.nlevels = 5;
        s.firstLevel = rng.uniform(0, 5);
        s.edgeThreshold = rng.uniform(0, 4);
        const Mat image = makeNoise(Size(rng.uniform(8, 60), rng.uniform(8, 60)), seed);
        KeyPoints keypoints;
        s.create()->detect(image, keypoints);
        for (const KeyPoint& k : keypoints)
        {
            ASSERT_TRUE(k.pt.x >= 0 && k.pt.x < float(image.cols) && k.pt.y >= 0 &&
                        k.pt.y < float(image.rows));
            beyondTheLastCentre += k.pt.x > float(image.cols - 1) || k.pt.y > float(image.rows - 1);
        }
    }
    EXPECT_GT(beyondTheLastCentre, 0);
}

TEST(Aqorb_Promises, a_level_comes_by_response_and_then_in_raster_order_of_the_detected_pixels)
{
    int ties = 0, turned = 0;  // turned: the refined position comes before that of the keypoint before
    for (int seed = 1; seed <= 20; seed++)
    {
        SCOPED_TRACE(seed);
        const Ptr<AdaptiveQuadtreeORB> detector = AdaptiveQuadtreeORB::create(
            2000, 1.2f, 4, 16, seed % 2, 2, seed % 4 < 2 ? ORB::FAST_SCORE : ORB::HARRIS_SCORE);
        for (AdaptiveQuadtreeORB::SelectionType selection : SELECTIONS)
        {
            detector->setSelectionType(selection);
            KeyPoints keypoints;
            detector->detect(makeScene(Size(200, 150), seed), keypoints);
            for (size_t i = 1; i < keypoints.size(); i++)
            {
                const KeyPoint &before = keypoints[i - 1], &after = keypoints[i];
                ASSERT_LE(before.octave, after.octave);
                if (before.octave < after.octave)
                    continue;
                if (before.response != after.response)
                {
                    ASSERT_GT(before.response, after.response);
                    continue;
                }
                const Point a = detectedPixel(before, *detector), b = detectedPixel(after, *detector);
                ASSERT_TRUE(a.y < b.y || (a.y == b.y && a.x < b.x));
                ties++;
                turned += after.pt.y < before.pt.y;
            }
        }
    }
    EXPECT_GT(ties, 100);
    EXPECT_GT(turned, 100);
}

TEST(Aqorb_Promises, octave_suppression_keeps_detected_pixels_apart)
{
    int nearer = 0;  // refined positions that are
    // In the noise representatives run out, but corners that keep their distance do not.
    const Mat scene = makeScene(Size(640, 480)), noise = makeNoise(Size(411, 196));
    for (double distance : {0.5, 1., 2., 3., -2.})
    {
        const Mat& image = distance < 0 ? noise : scene;
        const int nfeatures = distance < 0 ? 2468 : 600;
        distance = std::abs(distance);
        SCOPED_TRACE(format("distance %g, %d", distance, nfeatures));
        const Ptr<AdaptiveQuadtreeORB> detector = AdaptiveQuadtreeORB::create(nfeatures);
        detector->setOctaveSuppression(distance);
        KeyPoints keypoints;
        detector->detect(image, keypoints);
        ASSERT_EQ(keypoints.size(), size_t(nfeatures));
        std::vector<Mat> levels;
        detector->buildPyramid(image, levels);
        const auto position = [&](const KeyPoint& k)
        {
            const Point pixel = detectedPixel(k, *detector);
            const Size size = levels[k.octave].size();
            return Point2d((pixel.x + 0.5) * image.cols / size.width - 0.5,
                           (pixel.y + 0.5) * image.rows / size.height - 0.5);
        };
        for (const KeyPoint& coarse : keypoints)
            for (const KeyPoint& fine : keypoints)
            {
                if (fine.octave + 1 != coarse.octave)
                    continue;
                const double minDistance =
                    distance * reference::levelScale(fine.octave, 0, detector->getScaleFactor());
                ASSERT_GE(cv::norm(position(coarse) - position(fine)), minDistance * (1 - 1e-9));
                nearer += cv::norm(coarse.pt - fine.pt) < minDistance;
            }
    }
    EXPECT_GT(nearer, 0);
}

//! The strength of a corner on level 0, from the documentation's formula.
double strengthOf(const Mat& image, const Point& pixel)
{
    int m10 = 0, m01 = 0;
    reference::discMoments(image, pixel.x, pixel.y, 31, 3, m10, m01);
    const double harris = std::max(reference::harrisResponse(image, pixel.x, pixel.y), 0.f);
    return reference::cornerScore(image, pixel.x, pixel.y) * std::pow(harris, 0.25) *
           std::sqrt(double(m10) * m10 + double(m01) * m01);
}

TEST(Aqorb_Promises, at_the_largest_weight_strengths_decide_to_two_per_cent)
{
    for (int seed = 1; seed <= 10; seed++)
    {
        SCOPED_TRACE(seed);
        const Mat image = makeScene(Size(320, 240), seed);
        const Ptr<AdaptiveQuadtreeORB> detector = AdaptiveQuadtreeORB::create(40, 1.2f, 1);
        detector->setStrengthWeight(1000);
        detector->setRankRadius(seed % 2 ? 1 : 16);
        KeyPoints fewer, more;
        detector->detect(image, fewer);
        detector->setMaxFeatures(80);
        detector->detect(image, more);
        ASSERT_EQ(40u, fewer.size());
        ASSERT_EQ(80u, more.size());
        double weakest = ENDLESS, strongest = 0;
        std::set<std::pair<int, int>> taken;
        for (const KeyPoint& k : fewer)
        {
            const Point pixel = detectedPixel(k, *detector);
            taken.insert({pixel.x, pixel.y});
            weakest = std::min(weakest, strengthOf(image, pixel));
        }
        for (const KeyPoint& k : more)
        {
            const Point pixel = detectedPixel(k, *detector);
            if (!taken.count({pixel.x, pixel.y}))
                strongest = std::max(strongest, strengthOf(image, pixel));
        }
        EXPECT_GE(weakest, 0.98 * strongest);
    }
}

TEST(Aqorb_Promises, ranked_corners_give_way_within_7x7_pixels)
{
    for (AdaptiveQuadtreeORB::SelectionType selection : SELECTIONS)
    {
        const Ptr<AdaptiveQuadtreeORB> detector = AdaptiveQuadtreeORB::create(2000, 1.2f, 1);
        detector->setSelectionType(selection);
        detector->setSubPixel(false);
        KeyPoints keypoints;
        detector->detect(makeScene(Size(640, 480)), keypoints);
        detector->setMaxFeatures(int(keypoints.size()) / 3);  // representatives suffice
        detector->detect(makeScene(Size(640, 480)), keypoints);
        int near = 0;
        for (const KeyPoint& a : keypoints)
            for (const KeyPoint& b : keypoints)
                near += a.pt != b.pt && std::abs(a.pt.x - b.pt.x) <= 3 && std::abs(a.pt.y - b.pt.y) <= 3;
        EXPECT_EQ(selection == AdaptiveQuadtreeORB::RANKED_SELECTION, near == 0) << near;
    }
}

TEST(Aqorb_Promises, the_papers_method_is_one_switch)
{
    const Mat image = makeScene(Size(320, 240));
    const Ptr<AdaptiveQuadtreeORB> detector = AdaptiveQuadtreeORB::create(300);
    detector->setSelectionType(AdaptiveQuadtreeORB::QUADTREE_SELECTION);
    const Features expected = detectAndCompute(*detector, image);
    for (const KeyPoint& keypoint : expected.keypoints)
    {
        const float scale = reference::levelScale(keypoint.octave, 0, detector->getScaleFactor());
        EXPECT_EQ(keypoint.pt, Point2f(detectedPixel(keypoint, *detector)) * scale);
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

TEST(Aqorb_Promises, it_is_an_orb_with_the_same_arguments)
{
    const Ptr<ORB> orb = AdaptiveQuadtreeORB::create(77, 1.5f, 3, 20, 1, 4, ORB::FAST_SCORE, 25, 9);
#define AQORB_VALUE(property, ...) double(orb->get##property()),
    const std::vector<double> values = {AQORB_PARAMETERS_OF_ORB(AQORB_VALUE)};
#undef AQORB_VALUE
    EXPECT_EQ((std::vector<double>{77, 1.5, 3, 20, 1, 4, ORB::FAST_SCORE, 25, 9}), values);
    EXPECT_EQ(32, orb->descriptorSize());
    EXPECT_EQ(CV_8U, orb->descriptorType());
    for (int WTA_K = 2; WTA_K <= 4; WTA_K++)
    {
        orb->setWTA_K(WTA_K);
        EXPECT_EQ(int(WTA_K == 2 ? NORM_HAMMING : NORM_HAMMING2), orb->defaultNorm());
    }
    EXPECT_FALSE(orb->empty());
    EXPECT_EQ("Feature2D.AdaptiveQuadtreeORB", orb->getDefaultName());
}

TEST(Aqorb_Promises, nothing_found_clears_both_outputs)
{
    const Mat images[] = {Mat(), Mat::zeros(1, 1, CV_8UC1), Mat::zeros(300, 300, CV_8UC1),
                          Mat(300, 300, CV_8UC1, Scalar(255)), makeNoise(Size(32, 32))};
    for (const Mat& image : images)
    {
        Features features = {KeyPoints(9), Mat::ones(9, 32, CV_8UC1)};
        AdaptiveQuadtreeORB::create()->detectAndCompute(image, noArray(), features.keypoints,
                                                        features.descriptors, image.empty());
        EXPECT_TRUE(sameFeatures(Features(), features));
    }
}

}  // namespace
}  // namespace opencv_test
