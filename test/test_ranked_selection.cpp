// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "reference.hpp"

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

// Leaves of one tree are limited by the shorter side. There were too few of them, and the strongest corners filled up.
TEST(Aqorb_RankedSelection, narrow_images_are_covered)
{
    const Size sizes[] = {Size(1024, 128), Size(1024, 64),   Size(4096, 64),
                          Size(32768, 40), Size(100000, 36), Size(64, 1024)};
    for (const Size& size : sizes)
    {
        SCOPED_TRACE(format("%d x %d", size.width, size.height));
        const bool isWide = size.width > size.height;
        Mat image = makeNoise(size, 7);
        Mat weaker = isWide ? image.colRange(0, size.width / 2) : image.rowRange(0, size.height / 2);
        weaker = weaker / 2 + 64;
        Settings settings;
        for (int n : {250, 500, 1000})
        {
            settings.nfeatures = n;
            const KeyPoints keypoints = detect(settings, image);
            ASSERT_EQ(keypoints.size(), size_t(n));
            const auto isInWeaker = [&](const KeyPoint& k)
            { return isWide ? k.pt.x < size.width / 2 : k.pt.y < size.height / 2; };
            EXPECT_GE(std::count_if(keypoints.begin(), keypoints.end(), isInWeaker), n * 27 / 100) << n;
        }
    }
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
