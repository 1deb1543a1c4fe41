// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "reference.hpp"

#include <limits>

namespace opencv_test
{
namespace
{

using aqorb::stages::LeafPoint;

KeyPoints randomKeypoints(int count, Size size, int seed)
{
    RNG rng(seed);
    KeyPoints keypoints;
    for (int i = 0; i < count; i++)
    {
        // a third of them in one corner
        const float part = i % 3 ? 1.f : 0.2f;
        keypoints.push_back(KeyPoint(rng.uniform(0.f, part * size.width),
                                     rng.uniform(0.f, part * size.height), rng.uniform(1.f, 99.f),
                                     rng.uniform(-1.f, 360.f), rng.uniform(-5.f, 5.f), rng.uniform(-3, 99),
                                     i));  // class_id tells which it was
    }
    return keypoints;
}

TEST(Aqorb_RetainUniform, equals_reference_and_touches_no_field)
{
    const Size size(640, 481);
    const KeyPoints all = randomKeypoints(1000, size, 1);
    const int numbers[] = {0, 1, 2, 5, 16, 17, 100, 500, 999, 1000, 5000};
    for (int n : numbers)
    {
        SCOPED_TRACE(n);
        const int depth = reference::quadtreeDepth(n);
        std::vector<LeafPoint> points;
        for (size_t i = 0; i < all.size(); i++)
        {
            const double leaves = 1 << depth;
            const LeafPoint point = {reference::leafCode(unsigned(all[i].pt.x * leaves / size.width),
                                                         unsigned(all[i].pt.y * leaves / size.height)),
                                     all[i].response, all[i].pt.x, all[i].pt.y, int(i)};
            points.push_back(point);
        }
        points = reference::balancedSequence(points, depth);
        points.resize(std::min(points.size(), size_t(n)));
        std::vector<int> indices;
        for (const LeafPoint& point : points)
            indices.push_back(point.index);
        std::sort(indices.begin(), indices.end());
        KeyPoints expected, kept = all;
        for (int index : indices)
            expected.push_back(all[index]);  // in input order
        aqorb::retainUniform(kept, size, n);
        EXPECT_TRUE(sameKeypoints(kept, expected));
        aqorb::retainUniform(kept, size, n);  // once more changes nothing
        EXPECT_TRUE(sameKeypoints(kept, expected));
    }
}

TEST(Aqorb_RetainUniform, drops_what_lies_outside)
{
    const float nan = std::numeric_limits<float>::quiet_NaN();
    const float inf = std::numeric_limits<float>::infinity();
    const Point2f outside[] = {Point2f(-0.5f, 5), Point2f(5, -1e-6f), Point2f(10, 5),  Point2f(5, 20),
                               Point2f(nan, 5),   Point2f(5, nan),    Point2f(inf, 5), Point2f(5, -inf)};
    KeyPoints keypoints;
    for (const Point2f& p : outside)
        keypoints.push_back(KeyPoint(p, 1));
    keypoints.push_back(KeyPoint(0, 0, 1));
    keypoints.push_back(KeyPoint(9.999f, 19.999f, 1));
    const KeyPoints inside(keypoints.end() - 2, keypoints.end());
    aqorb::retainUniform(keypoints, Size(10, 20), 1000);  // also where fewer than npoints are there
    EXPECT_TRUE(sameKeypoints(keypoints, inside));
    keypoints.clear();
    aqorb::retainUniform(keypoints, Size(10, 20), 3);
    EXPECT_TRUE(keypoints.empty());
}

TEST(Aqorb_RetainUniform, takes_nan_last_and_at_most_one_of_a_leaf_first)
{
    const float nan = std::numeric_limits<float>::quiet_NaN();
    KeyPoints keypoints;
    keypoints.push_back(KeyPoint(10, 10, 1, -1, nan));
    keypoints.push_back(KeyPoint(11, 10, 1, -1, -1e30f));
    keypoints.push_back(KeyPoint(12, 10, 1, -1, nan));
    KeyPoints kept = keypoints;
    aqorb::retainUniform(kept, Size(100, 100), 1);
    EXPECT_TRUE(sameKeypoints(kept, KeyPoints(1, keypoints[1])));
    kept = keypoints;
    aqorb::retainUniform(kept, Size(100, 100), 3);
    EXPECT_EQ(kept.size(), 3u);

    // Two in one quarter; the weak one in another quarter goes before the second of them.
    keypoints.clear();
    keypoints.push_back(KeyPoint(10, 10, 1, -1, 9));
    keypoints.push_back(KeyPoint(20, 10, 1, -1, 8));
    keypoints.push_back(KeyPoint(90, 90, 1, -1, 1));
    kept = keypoints;
    aqorb::retainUniform(kept, Size(100, 100), 2);
    ASSERT_EQ(kept.size(), 2u);
    EXPECT_EQ(kept[0].response, 9);
    EXPECT_EQ(kept[1].response, 1);
}

}  // namespace
}  // namespace opencv_test
