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
