// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "reference.hpp"

#include <iostream>

// What follows from the rule of RANKED_SELECTION, whatever its numbers are.

namespace opencv_test
{
namespace
{

using reference::Settings;

KeyPoints detect(const Settings& settings, const Mat& image, const Mat& mask = Mat())
{
    KeyPoints keypoints;
    settings.create()->detect(image, keypoints, mask);
    return keypoints;
}

// Of an image a quarter is not masked. The other image is that quarter with its border. Tree, spacing and discs are
// the same then, although the root is four times as large.
TEST(Aqorb_RankedSelection, masked_area_is_no_area)
{
    const int EDGE = 16;
    size_t compared = 0;
    for (int seed = 1; seed <= 40; seed++)
    {
        SCOPED_TRACE(seed);
        RNG rng(seed);
        const Size quarter(rng.uniform(40, 120), rng.uniform(40, 120));
        const Size size(2 * quarter.width + 2 * EDGE, 2 * quarter.height + 2 * EDGE);
        const Mat image = makeScene(size, seed);
        const Mat part = image(Rect(0, 0, quarter.width + 2 * EDGE, quarter.height + 2 * EDGE)).clone();
        Mat mask(size, CV_8UC1, Scalar(0));
        mask(Rect(EDGE, EDGE, quarter.width, quarter.height)).setTo(1);
        Settings settings;
        settings.nlevels = 1;
        settings.edgeThreshold = EDGE;
        settings.adaptiveThreshold = false;
        settings.subPixel = false;
        settings.nfeatures = rng.uniform(1, 100);
        settings.rankRadius = seed % 3 ? 1 : 2.5;
        settings.strengthWeight = seed % 4 ? 0.2 : 0;
        const KeyPoints ofPart = detect(settings, part);
        EXPECT_TRUE(sameKeypoints(detect(settings, image, mask), ofPart));
        compared += ofPart.size();
    }
    EXPECT_GT(compared, 1000u);
}

// With radius 0 there are no ranks. With one that covers all of the image the rank is that of the strength.
TEST(Aqorb_RankedSelection, strength_alone_decides_at_either_end_of_the_radius)
{
    for (int seed = 1; seed <= 10; seed++)
    {
        const Mat image = makeScene(Size(200, 150), seed);
        Settings settings;
        settings.nlevels = 1;
        settings.nfeatures = 10 + 6 * seed;
        settings.strengthWeight = 0.2;
        const KeyPoints asUsual = detect(settings, image);
        settings.rankRadius = 0;
        const KeyPoints expected = detect(settings, image);
        EXPECT_FALSE(sameKeypoints(asUsual, expected));
        for (double weight : {0., 0.001, 1., 1000.})
        {
            SCOPED_TRACE(format("seed %d, weight %g", seed, weight));
            settings.strengthWeight = weight;
            settings.rankRadius = 0;
            EXPECT_TRUE(sameKeypoints(detect(settings, image), expected));
            settings.rankRadius = 16;
            EXPECT_TRUE(sameKeypoints(detect(settings, image), expected));
        }
    }
}

//! How many keypoints two lists have in common.
int common(const KeyPoints& a, const KeyPoints& b)
{
    int count = 0;
    for (const KeyPoint& k : a)
        count += std::any_of(b.begin(), b.end(),
                             [&](const KeyPoint& other)
                             { return sameKeypoints(KeyPoints(1, k), KeyPoints(1, other)); });
    return count;
}

TEST(Aqorb_RankedSelection, the_weight_leads_from_evenness_to_strength)
{
    for (int seed = 1; seed <= 5; seed++)
    {
        SCOPED_TRACE(seed);
        const Mat image = makeScene(Size(640, 480), seed);
        Settings settings;
        settings.nfeatures = 300;
        settings.rankRadius = 0;
        const KeyPoints strongest = detect(settings, image);
        settings.rankRadius = 1;
        int before = 0;
        double evenness = 2;
        for (double weight : {0., 1., 4., 1000.})
        {
            SCOPED_TRACE(weight);
            settings.strengthWeight = weight;
            const KeyPoints keypoints = detect(settings, image);
            ASSERT_EQ(keypoints.size(), 300u);
            const int strong = common(keypoints, strongest);
            EXPECT_GT(strong, before);
            before = strong;
            const double occupancy = aqorb::distributionOccupancy(keypoints, image.size());
            EXPECT_LT(occupancy, evenness);
            evenness = occupancy;
        }
        EXPECT_GE(before, 285);
    }
}

//! The share of keypoints that are found again, of the same size, in the image turned by quarters.
double shareAfterTurn(const Settings& settings, const Mat& image, int quarters)
{
    Mat turned;
    cv::rotate(image, turned, quarters == 1 ? ROTATE_90_CLOCKWISE : ROTATE_180);
    const KeyPoints before = detect(settings, image), after = detect(settings, turned);
    int found = 0;
    for (const KeyPoint& k : before)
    {
        const Point2f place = quarters == 1
                                  ? Point2f(float(image.rows - 1) - k.pt.y, k.pt.x)
                                  : Point2f(float(image.cols - 1) - k.pt.x, float(image.rows - 1) - k.pt.y);
        found += std::any_of(after.begin(), after.end(),
                             [&](const KeyPoint& other)
                             { return other.octave == k.octave && cv::norm(other.pt - place) < 1.5; });
    }
    return double(found) / double(before.size());
}

TEST(Aqorb_RankedSelection, a_turned_image_keeps_more_keypoints_than_with_the_papers_selection)
{
    double ranked = 0, balanced = 0;
    const int SCENES = 6;
    for (int seed = 1; seed <= SCENES; seed++)
    {
        const Mat image = makeScene(Size(640, 480), seed);
        for (int quarters = 1; quarters <= 2; quarters++)
        {
            Settings settings;
            settings.nfeatures = 300;
            ranked += shareAfterTurn(settings, image, quarters) / (2 * SCENES);
            settings.selectionType = AdaptiveQuadtreeORB::BALANCED_SELECTION;
            balanced += shareAfterTurn(settings, image, quarters) / (2 * SCENES);
        }
    }
    std::cout << format("[ FIGURE   ] found again in the turned image: %.3f, with the paper's selection %.3f",
                        ranked, balanced)
              << std::endl;
    EXPECT_GT(ranked, balanced + 0.02);
}

}  // namespace
}  // namespace opencv_test
