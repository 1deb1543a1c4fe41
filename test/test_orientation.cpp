// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "reference.hpp"

#include "detector/harris_orientation.hpp"

namespace opencv_test
{
namespace
{

using namespace aqorb;

TEST(Aqorb_Orientation, equals_reference_at_every_pixel)
{
    const int patches[] = {2, 3, 8, 21, 31, 32, 47, 63, 64, 90, 700};
    const Size sizes[] = {Size(96, 71), Size(40, 33), Size(12, 9), Size(1, 4)};
    for (int patchSize : patches)
    {
        const std::vector<int> halfWidths = circularPatch(patchSize);
        for (const Size& size : sizes)
        {
            SCOPED_TRACE(format("patch %d, %d x %d", patchSize, size.width, size.height));
            const Mat noise = makeNoise(size);
            const Mat images[] = {noise, noise > 128};
            for (const Mat& image : images)
            {
                std::vector<FeaturePoint> points, baselinePoints;
                for (int y = 0; y < size.height; y++)
                {
                    // Near the sides columns are taken more densely than between them.
                    for (int x = 0; x < size.width; x += patchSize < 32 || x % 50 > 40 ? 3 : 7)
                    {
                        points.push_back({x, y, -1});
                    }
                }
                baselinePoints = points;
                const OrientationPatch patch(halfWidths);
                orientations(image, patch, points.data(), points.size());
                {
                    WithoutOptimization baseline;
                    orientations(image, patch, baselinePoints.data(), points.size());
                }
                for (size_t i = 0; i < points.size(); i++)
                {
                    const FeaturePoint& p = points[i];
                    ASSERT_EQ(p.angle, baselinePoints[i].angle) << p.x << " " << p.y;
                    ASSERT_EQ(p.angle, reference::orientation(image, p.x, p.y, patchSize))
                        << p.x << " " << p.y;
                }
            }
        }
    }
}

TEST(Aqorb_Orientation, reference_is_fast_atan2)
{
    const bool fused = reference::opencvFusesMultiplyAdd();
    for (int y = -300; y <= 300; y += 3)
        for (int x = -300; x <= 300; x++)
        {
            const float plain = reference::arctangent(float(y), float(x));
            ASSERT_EQ(fastAtan2(float(y), float(x)), reference::arctangent(float(y), float(x), fused))
                << x << " " << y;
            ASSERT_NEAR(plain, fastAtan2(float(y), float(x)), 1e-4) << x << " " << y;
        }
}

}  // namespace
}  // namespace opencv_test
