// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "reference.hpp"

#include "logarithm.hpp"
#include "ranked_sequence.hpp"

#include <cfloat>
#include <climits>
#include <limits>

namespace opencv_test
{
namespace
{

using namespace aqorb::stages;

const float INF = std::numeric_limits<float>::infinity();
const float NOT_A_NUMBER = std::numeric_limits<float>::quiet_NaN();

int64 logarithmOf(float v)
{
    return BinaryLogarithm::shared()(v);
}

TEST(Aqorb_RankedSequence, logarithm_equals_reference)
{
    for (int e = -149; e <= 127; e++)
        ASSERT_EQ(logarithmOf(std::ldexp(1.f, e)), int64(e) * (1 << 24)) << e;
    RNG rng(1);
    for (int i = 0; i < 200000; i++)
    {
        Cv32suf bits;
        bits.u = unsigned(rng.uniform(1, 0x7f800000));  // any number > 0, denormals as well
        ASSERT_EQ(logarithmOf(bits.f), reference::binaryLogarithm(bits.f)) << bits.f;
    }
    EXPECT_EQ(logarithmOf(FLT_MAX), reference::binaryLogarithm(FLT_MAX));
    EXPECT_EQ(logarithmOf(FLT_MIN), int64(-126) * (1 << 24));
}

TEST(Aqorb_RankedSequence, logarithm_grows_and_is_exact_to_7_digits)
{
    // All numbers from 1 to 2: the table has 2^12 steps of 2^11 numbers.
    int64 before = 0;
    for (unsigned fraction = 0; fraction <= 1u << 23; fraction++)
    {
        Cv32suf bits;
        bits.u = 0x3f800000 + fraction;
        const int64 logarithm = logarithmOf(bits.f);
        ASSERT_GE(logarithm, before) << bits.f;
        if (fraction % 97 == 0)
        {
            ASSERT_NEAR(std::ldexp(double(logarithm), -24), std::log2(double(bits.f)), 1.5e-7) << bits.f;
        }
        before = logarithm;
    }
    EXPECT_EQ(before, 1 << 24);
}

TEST(Aqorb_RankedSequence, depth_equals_reference)
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
    std::vector<LeafPoint> points;  // by TieBefore; the leaves are not numbered yet
    std::vector<float> strengths;
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
        const LeafPoint point = {0, randomStrength(rng, kind), float(rng.uniform(0, size.width)),
                                 float(rng.uniform(0, size.height)), i};
        scene.points.push_back(point);
        scene.strengths.push_back(randomStrength(rng, kind));
    }
    std::sort(scene.points.begin(), scene.points.end(), TieBefore());
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
    std::vector<reference::LeafCorner> corners;
    for (const LeafPoint& point : scene.points)
    {
        const Size size = scene.rule.size;
        const reference::LeafCorner corner = {(int(point.x) << scene.depth) / size.width,
                                              (int(point.y) << scene.depth) / size.height,
                                              point.x,
                                              point.y,
                                              point.response,
                                              point.index};
        corners.push_back(corner);
    }
    const reference::RankedRule rule = {scene.rule.size,
                                        scene.depth,
                                        scene.rule.usable,
                                        scene.rule.quota,
                                        scene.rule.radius,
                                        scene.rule.strengthWeight,
                                        scene.power == 4 ? 1 << 18 : 1 << 16};
    return reference::rankedSequence(
        corners, rule,
        [&](int column, int row)
        { return scene.usable.empty() || scene.usable[(size_t(row) << scene.depth) + column]; },
        [&](const reference::LeafCorner& corner) { return scene.strengths[corner.index]; });
}

//! A sequence of the points of one scene after the other.
struct Sequence
{
    Sequence() : list(points) {}

    std::vector<LeafPoint> points;
    PointList list;
    RankedScratch scratch;
    RankedSequence ranked;
    LeafScratch leaves;
};

void numberPoints(const Scene& scene, Sequence& sequence)
{
    numberLeaves(scene.rule.size, scene.depth, sequence.leaves);
    sequence.points = scene.points;
    for (LeafPoint& point : sequence.points)
        point.leaf = sequence.leaves.columns[int(point.x)] + sequence.leaves.rows[int(point.y)];
    sequence.list.sort();
}

RankedSequence& begin(const Scene& scene, Sequence& sequence, size_t enough = SIZE_MAX)
{
    numberPoints(scene, sequence);
    RankedSequence& ranked = sequence.ranked;
    ranked.begin(scene.depth, sequence.list, sequence.scratch);
    ranked.addAll();
    ranked.findRepresentatives();
    const std::vector<unsigned>& representatives = ranked.representatives();
    for (size_t i = 0; i < representatives.size(); i++)
    {
        // At first both are that of the point, also where it is no number.
        const LeafPoint& point = sequence.points[representatives[i]];
        EXPECT_EQ(orderOf(ranked.strength(i)), orderOf(point.response));
        EXPECT_EQ(orderOf(ranked.response(i)), orderOf(point.response));
        ranked.strength(i) = scene.strengths[point.index];
    }
    ranked.rank(scene.rule, scene.power, scene.usable, enough);
    return ranked;
}

TEST(Aqorb_RankedSequence, equals_reference)
{
    Sequence memory;  // It is used again, so what one scene leaves in it must not matter.
    size_t compared = 0;
    for (int seed = 1; seed <= 600; seed++)
    {
        SCOPED_TRACE(seed);
        const Scene scene = randomScene(seed);
        const std::vector<int> expected = expectedOrder(scene);
        RankedSequence& sequence = begin(scene, memory);
        LeafPoint point;
        for (size_t i = 0; i < expected.size(); i++)
        {
            ASSERT_TRUE(sequence.next(point)) << i;
            ASSERT_EQ(point.index, expected[i]) << i;
        }
        ASSERT_FALSE(sequence.next(point));
        ASSERT_FALSE(sequence.next(point));
        compared += expected.size();
    }
    EXPECT_GT(compared, 20000u);
}

// The kernels for this CPU and the baseline's.
TEST(Aqorb_RankedSequence, equals_reference_without_optimization)
{
    WithoutOptimization baseline;
    Sequence memory;
    for (int seed = 601; seed <= 700; seed++)
    {
        SCOPED_TRACE(seed);
        const Scene scene = randomScene(seed);
        RankedSequence& sequence = begin(scene, memory);
        LeafPoint point;
        for (int index : expectedOrder(scene))
        {
            ASSERT_TRUE(sequence.next(point));
            ASSERT_EQ(point.index, index);
        }
        ASSERT_FALSE(sequence.next(point));
    }
}

class OddIndices : public PointFilter
{
public:
    bool accepts(const LeafPoint& point) const CV_OVERRIDE { return point.index % 2 != 0; }
};

TEST(Aqorb_RankedSequence, a_filter_passes_over_points_and_changes_no_rank)
{
    Sequence memory;
    const OddIndices filter;
    for (int seed = 1; seed <= 50; seed++)
    {
        SCOPED_TRACE(seed);
        const Scene scene = randomScene(seed);
        RankedSequence& sequence = begin(scene, memory);
        LeafPoint point;
        for (int index : expectedOrder(scene))
        {
            if (index % 2 == 0)
                continue;
            ASSERT_TRUE(sequence.next(point, &filter));
            ASSERT_EQ(point.index, index);
        }
        ASSERT_FALSE(sequence.next(point, &filter));
    }
}

TEST(Aqorb_RankedSequence, where_fewer_are_enough_it_begins_the_same)
{
    Sequence memory;
    RNG rng(2);
    int early = 0;
    for (int seed = 701; seed <= 750; seed++)
    {
        SCOPED_TRACE(seed);
        const Scene scene = randomScene(seed, true);
        const std::vector<int> expected = expectedOrder(scene);
        const size_t enough = size_t(rng.uniform(20, 400));
        RankedSequence& sequence = begin(scene, memory, enough);
        const size_t representatives = memory.scratch.points.size();
        LeafPoint point;
        size_t given = 0;
        for (; sequence.next(point); given++)
        {
            ASSERT_LT(given, expected.size());
            ASSERT_EQ(point.index, expected[given]) << given;
        }
        EXPECT_EQ(sequence.passed(), given);
        if (!sequence.endsEarly())
        {
            EXPECT_EQ(given, expected.size());
            continue;
        }
        early++;
        EXPECT_GT(given, enough / 2);
        EXPECT_LT(given, representatives);
        if (seed % 5 != 2 && scene.rule.strengthWeight > 0)  // else many keys are equal
        {
            EXPECT_LT(given, enough * 3 / 2 + 30);
        }
        EXPECT_FALSE(sequence.next(point));
        sequence.beginUnranked(memory.list, std::vector<RankedCorner>());
        EXPECT_FALSE(sequence.endsEarly());
        RankedSequence& whole = begin(scene, memory);
        EXPECT_FALSE(whole.endsEarly());
        whole.goOnAfter(given);
        for (; whole.next(point); given++)
        {
            ASSERT_LT(given, expected.size());
            ASSERT_EQ(point.index, expected[given]) << given;
        }
        EXPECT_EQ(given, expected.size());
    }
    EXPECT_GT(early, 10);
}

// In any order; their strength is their response.
TEST(Aqorb_RankedSequence, points_are_ordered_by_their_response)
{
    Sequence memory;
    for (int seed = 1; seed <= 100; seed++)
    {
        SCOPED_TRACE(seed);
        Scene scene = randomScene(seed);
        scene.power = 1;
        scene.usable.clear();
        for (const LeafPoint& point : scene.points)
            scene.strengths[point.index] = point.response;
        const std::vector<int> expected = expectedOrder(scene);
        RNG rng(seed);
        for (size_t i = scene.points.size(); i > 1; i--)
            std::swap(scene.points[i - 1], scene.points[rng.uniform(0, int(i))]);
        numberPoints(scene, memory);
        RankedSequence& sequence = memory.ranked;
        sequence.begin(scene.depth, memory.list, memory.scratch);
        sequence.addAll();
        sequence.findRepresentatives();
        sequence.rank(scene.rule, 1, scene.usable);
        LeafPoint point;
        for (int index : expected)
        {
            ASSERT_TRUE(sequence.next(point));
            ASSERT_EQ(point.index, index);
        }
        ASSERT_FALSE(sequence.next(point));
    }
}

TEST(Aqorb_RankedSequence, representatives_come_in_the_order_of_their_leaves)
{
    // 4 x 4 leaves of 10 x 10 pixels. Beside 9 and 8 the 7 has two stronger leaves.
    const float responses[] = {9, 8, 7, 3, 4};
    const Point leaves[] = {Point(0, 0), Point(1, 0), Point(0, 1), Point(3, 3), Point(3, 3)};
    std::vector<LeafPoint> points;
    for (int i = 0; i < 5; i++)
    {
        const LeafPoint point = {leafColumn(leaves[i].x) + leafRow(leaves[i].y, 2), responses[i],
                                 float(10 * leaves[i].x + i), float(10 * leaves[i].y), i};
        points.push_back(point);
    }
    PointList list(points);
    list.sort();
    RankedScratch scratch;
    RankedSequence sequence;
    sequence.begin(2, list, scratch);
    sequence.addAll();
    sequence.findRepresentatives();
    std::vector<int> indices;
    for (unsigned point : sequence.representatives())
        indices.push_back(points[point].index);
    EXPECT_EQ(indices, std::vector<int>({0, 1, 4}));
    EXPECT_EQ(sequence.strength(2), 4.f);
    const RankRule rule = {Size(40, 40), 1, 16, 1, 0};
    sequence.rank(rule, 1, std::vector<uchar>());
    // By rank, then strength; those passed over by their place in the leaf.
    LeafPoint point;
    for (int index : {0, 4, 1, 2, 3})
    {
        ASSERT_TRUE(sequence.next(point));
        EXPECT_EQ(point.index, index);
    }
    EXPECT_FALSE(sequence.next(point));
}

}  // namespace
}  // namespace opencv_test
