// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "reference.hpp"
#include "geometry.hpp"

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
// the same then, although the root is four times as large. (Not so where corners are used that other rules passed over:
// their order does not depend on the mask. With FAST_SCORE and one threshold there are none.)
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
        settings.scoreType = ORB::FAST_SCORE;
        settings.minThresholdRatio = 1;
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
        settings.rankRadius = 1;
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
        count +=
            std::any_of(b.begin(), b.end(),
                        [&](const KeyPoint& other)
                        { return other.pt == k.pt && other.octave == k.octave && other.angle == k.angle; });
    return count;
}

TEST(Aqorb_RankedSelection, the_weight_leads_from_evenness_to_strength)
{
    const double weights[] = {0, 1, 4, 1000};
    double strong[4] = {0, 0, 0, 0}, occupancy[4] = {0, 0, 0, 0};  // sums over scenes
    const int SCENES = 5, n = 300;
    for (int seed = 1; seed <= SCENES; seed++)
    {
        const Mat image = makeScene(Size(640, 480), seed);
        Settings settings;
        settings.nfeatures = n;
        settings.octaveSuppression = 1;  // its default would follow the weight
        settings.rankRadius = 0;
        const KeyPoints strongest = detect(settings, image);
        settings.rankRadius = 1;
        for (int i = 0; i < 4; i++)
        {
            settings.strengthWeight = weights[i];
            const KeyPoints keypoints = detect(settings, image);
            ASSERT_EQ(keypoints.size(), size_t(n));
            strong[i] += common(keypoints, strongest);
            occupancy[i] += aqorb::distributionOccupancy(keypoints, image.size());
        }
    }
    for (int i = 1; i < 4; i++)
    {
        EXPECT_GT(strong[i], strong[i - 1]) << weights[i];
        EXPECT_LT(occupancy[i], occupancy[i - 1]) << weights[i];
    }
    EXPECT_GE(strong[3], 0.95 * SCENES * n);
}

}  // namespace
}  // namespace opencv_test
