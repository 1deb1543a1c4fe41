// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "reference.hpp"

#include "plan.hpp"

#include <cfloat>
#include <climits>
#include <limits>
#include <memory>

namespace opencv_test
{
namespace
{

using namespace aqorb;

const float INF = std::numeric_limits<float>::infinity();
const float NOT_A_NUMBER = std::numeric_limits<float>::quiet_NaN();

TEST(Aqorb_RankedOrder, logarithm_equals_reference)
{
    for (int e = -149; e <= 127; e++)
        ASSERT_EQ(binaryLogarithm(std::ldexp(1.f, e)), int64(e) * (1 << 24)) << e;
    RNG rng(1);
    for (int i = 0; i < 200000; i++)
    {
        Cv32suf bits;
        bits.u = unsigned(rng.uniform(1, 0x7f800000));  // any number > 0, denormals as well
        ASSERT_EQ(binaryLogarithm(bits.f), reference::binaryLogarithm(bits.f)) << bits.f;
    }
    EXPECT_EQ(binaryLogarithm(FLT_MAX), reference::binaryLogarithm(FLT_MAX));
    EXPECT_EQ(binaryLogarithm(FLT_MIN), int64(-126) * (1 << 24));
}

TEST(Aqorb_RankedOrder, logarithm_grows_and_is_exact_to_7_digits)
{
    // All numbers from 1 to 2: the table has 2^12 steps of 2^11 numbers.
    int64 before = 0;
    for (unsigned fraction = 0; fraction <= 1u << 23; fraction++)
    {
        Cv32suf bits;
        bits.u = 0x3f800000 + fraction;
        const int64 logarithm = binaryLogarithm(bits.f);
        ASSERT_GE(logarithm, before) << bits.f;
        if (fraction % 97 == 0)
        {
            ASSERT_NEAR(std::ldexp(double(logarithm), -24), std::log2(double(bits.f)), 1.5e-7) << bits.f;
        }
        before = logarithm;
    }
    EXPECT_EQ(before, 1 << 24);
}

TEST(Aqorb_RankedOrder, depth_equals_reference)
{
    RNG rng(1);
    for (int i = 0; i < 20000; i++)
    {
        const Size size(rng.uniform(1, 1 << rng.uniform(1, 15)), rng.uniform(1, 1 << rng.uniform(1, 15)));
        const int quota = rng.uniform(1, 1 << rng.uniform(1, 24));
        const double usable = i % 3 ? rng.uniform(0., 1.) : i % 2;
        ASSERT_EQ(rankedDepth(size, usable, quota), reference::rankedDepth(-1, quota, usable, size))
            << size << usable << quota;
        ASSERT_EQ(maxRankedDepth(size), reference::rankedDepth(15, quota, usable, size)) << size;
    }
    EXPECT_EQ(maxRankedDepth(Size(INT_MAX, INT_MAX)), 12);
}

//! Points over a region, and the strengths of the representatives among them by their indices.
struct Scene
{
    RankRule rule;
    int depth, power;
    std::vector<reference::LeafCorner> corners;  // in the order that breaks ties; their bases are their keys
    std::vector<float> strengths;                // by index
    std::vector<uchar> usable;
};

float randomStrength(RNG& rng, int kind)
{
    static const float odd[] = {NOT_A_NUMBER, -INF, -1.f, -1e-42f, -0.f, 0.f, 1e-45f, 1.f, FLT_MAX, INF};
    if (kind == 0 || (kind == 1 && rng.uniform(0, 3) == 0))
        return odd[rng.uniform(0, 10)];
    if (kind == 2)
        return float(rng.uniform(0, 3));  // many are equal
    return rng.uniform(0.f, 1000.f);
}

//! @param isLarge whether the scene has thousands of points in hundreds of leaves
Scene randomScene(int seed, bool isLarge = false)
{
    RNG rng(seed);
    const int kind = seed % 5;
    Scene scene;
    const int shortest = isLarge ? 200 : 1;
    const Size size(rng.uniform(shortest, 300), rng.uniform(shortest, 300));
    const RankRule rule = {size, 1, rng.uniform(1, 1 << rng.uniform(1, 9)),
                           seed % 3 ? rng.uniform(0., 3.) : rng.uniform(0., 16.),
                           seed % 4 ? rng.uniform(0., 2.) : rng.uniform(0, 2) * 1000.};
    scene.rule = rule;
    scene.depth = rng.uniform(isLarge ? 5 : 0, isLarge ? 7 : maxRankedDepth(size) + 1);
    scene.power = rng.uniform(0, 2) ? 4 : 1;
    const int count = (isLarge ? 4000 : 0) + rng.uniform(0, 1 << rng.uniform(1, 11));
    for (int i = 0; i < count; i++)
    {
        const Point p(rng.uniform(0, size.width), rng.uniform(0, size.height));
        scene.corners.push_back({(p.x << scene.depth) / size.width, (p.y << scene.depth) / size.height,
                                 float(p.x), float(p.y), randomStrength(rng, kind), i});
        scene.strengths.push_back(randomStrength(rng, kind));
    }
    std::sort(scene.corners.begin(), scene.corners.end(),
              [](const reference::LeafCorner& a, const reference::LeafCorner& b) {
                  return a.y != b.y ? a.y < b.y : a.x != b.x ? a.x < b.x : a.index < b.index;
              });
    if (rng.uniform(0, 2))
    {
        scene.rule.usable = rng.uniform(0., 1.);
        for (int i = 0; i < 1 << (2 * scene.depth); i++)
            scene.usable.push_back(uchar(rng.uniform(0, 3) ? rng.uniform(1, 256) : 0));
    }
    return scene;
}

std::vector<int> expectedOrder(const Scene& scene)
{
    const reference::RankedRule rule = {scene.rule.size,
                                        scene.depth,
                                        scene.rule.usable,
                                        scene.rule.quota,
                                        scene.rule.radius,
                                        scene.rule.strengthWeight,
                                        scene.power == 4 ? 1 << 18 : 1 << 16};
    return reference::rankedSequence(
        scene.corners, rule,
        [&](int column, int row)
        { return scene.usable.empty() || scene.usable[(size_t(row) << scene.depth) + column]; },
        [&](const reference::LeafCorner& corner) { return scene.strengths[corner.index]; });
}

std::vector<LeafPoint> pointsOf(const Scene& scene)
{
    std::vector<LeafPoint> points;
    for (const reference::LeafCorner& corner : scene.corners)
    {
        points.push_back({unsigned(corner.row << scene.depth | corner.column), aqorb::sortKey(corner.base)});
    }
    return points;
}

std::vector<int> indicesOf(const std::vector<unsigned>& order, const Scene& scene)
{
    std::vector<int> indices;
    for (unsigned index : order)
        indices.push_back(scene.corners[index].index);
    return indices;
}

//! The order of a scene, step by step.
std::vector<int> orderOf(const Scene& scene, RankedScratch& scratch)
{
    const std::vector<LeafPoint> points = pointsOf(scene);
    Representatives representatives;
    std::vector<unsigned> order, others;
    findRepresentatives(
        points.size(), [&](size_t i) { return points[i]; }, scene.depth, scratch, representatives);
    std::vector<float> strengths;
    for (unsigned index : representatives.points)
        strengths.push_back(scene.strengths[scene.corners[index].index]);
    orderRepresentatives(representatives.leaves, strengths, scene.power, scene.depth, scene.usable,
                         scene.rule, scratch, order);
    for (unsigned& index : order)
        index = representatives.points[index];
    orderOthers(points, representatives.points, scratch, others);
    order.insert(order.end(), others.begin(), others.end());
    return indicesOf(order, scene);
}

TEST(Aqorb_RankedOrder, equals_reference)
{
    RankedScratch scratch;  // It is used again, so what one scene leaves in it must not matter.
    size_t compared = 0;
    for (int seed = 1; seed <= 650; seed++)
    {
        SCOPED_TRACE(seed);
        // The kernels for this CPU and the baseline's.
        const std::unique_ptr<WithoutOptimization> baseline(seed % 4 ? 0 : new WithoutOptimization);
        const Scene scene = randomScene(seed, seed > 600);
        const std::vector<int> expected = expectedOrder(scene);
        ASSERT_EQ(orderOf(scene, scratch), expected);
        compared += expected.size();
    }
    EXPECT_GT(compared, 200000u);
}

TEST(Aqorb_RankedOrder, points_are_ordered_by_their_keys)
{
    RankedScratch scratch;
    for (int seed = 1; seed <= 100; seed++)
    {
        SCOPED_TRACE(seed);
        Scene scene = randomScene(seed);
        scene.power = 1;
        scene.usable.clear();
        for (const reference::LeafCorner& corner : scene.corners)
            scene.strengths[corner.index] = corner.base;
        std::vector<unsigned> order(3, 9u);
        rankedOrder(pointsOf(scene), scene.depth, scene.rule, scratch, order);
        ASSERT_EQ(indicesOf(order, scene), expectedOrder(scene));
    }
}

}  // namespace
}  // namespace opencv_test
