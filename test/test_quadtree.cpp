// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "reference.hpp"

#include "balanced_sequence.hpp"
#include "quadtree.hpp"

#include <climits>
#include <limits>

namespace opencv_test
{
namespace
{

using namespace aqorb::stages;

TEST(Aqorb_Quadtree, depth_of_the_papers_example)
{
    // 500 features on 8 levels: 109 on the first, 30 on the last. The paper's text says 5 for the first,
    // which its equation (9) does not give.
    EXPECT_EQ(quadtreeDepth(109), 4);
    EXPECT_EQ(quadtreeDepth(30), 3);
}

TEST(Aqorb_Quadtree, depth_is_the_smallest_with_enough_leaves)
{
    EXPECT_EQ(quadtreeDepth(0), 0);
    EXPECT_EQ(quadtreeDepth(1), 0);
    EXPECT_EQ(quadtreeDepth(INT_MAX), 15);
    for (int depth = 0; depth < 15; depth++)
    {
        EXPECT_EQ(quadtreeDepth(1 << (2 * depth)), depth);
        EXPECT_EQ(quadtreeDepth((1 << (2 * depth)) + 1), depth + 1);
    }
}

TEST(Aqorb_Quadtree, leaf_code_interleaves_bits)
{
    EXPECT_EQ(leafCode(0, 0), 0u);
    EXPECT_EQ(leafCode(1, 0), 1u);
    EXPECT_EQ(leafCode(0, 1), 2u);
    EXPECT_EQ(leafCode(2, 3), 14u);
    EXPECT_EQ(leafCode(32767, 32767), (1u << 30) - 1);
    for (unsigned i = 0; i < 2000; i++)
        ASSERT_EQ(leafCode(i * 7919 % 32768, i * 104729 % 32768),
                  reference::leafCode(i * 7919 % 32768, i * 104729 % 32768));
}

std::vector<LeafPoint> randomPoints(int count, int depth, int responses, int seed)
{
    RNG rng(seed);
    std::vector<LeafPoint> points;
    for (int i = 0; i < count; i++)
    {
        const int x = rng.uniform(0, 300), y = rng.uniform(0, 200);
        const LeafPoint point = {leafCode((unsigned(x) << depth) / 300, (unsigned(y) << depth) / 200),
                                 float(rng.uniform(-responses, responses)), float(x), float(y), i};
        points.push_back(point);
    }
    return points;
}

void expectSequence(std::vector<LeafPoint> points, int depth, BalancedSequence& sequence)
{
    const std::vector<LeafPoint> expected = reference::balancedSequence(points, depth);
    sequence.begin(points, depth);
    LeafPoint point;
    for (size_t i = 0; i < expected.size(); i++)
    {
        ASSERT_TRUE(sequence.next(point)) << i;
        ASSERT_EQ(point.index, expected[i].index) << i;
        ASSERT_EQ(point.leaf, expected[i].leaf);
        ASSERT_EQ(point.x, expected[i].x);
        ASSERT_EQ(point.y, expected[i].y);
    }
    EXPECT_FALSE(sequence.next(point));
    EXPECT_FALSE(sequence.next(point));
}

TEST(Aqorb_Quadtree, sequence_equals_its_definition)
{
    const int counts[] = {0, 1, 2, 7, 60, 500, 3000};
    BalancedSequence sequence;  // It is used again and again, so begin must reset it.
    for (int count : counts)
    {
        for (int depth = 0; depth <= 15; depth++)
        {
            SCOPED_TRACE(format("%d points, depth %d", count, depth));
            expectSequence(randomPoints(count, depth, 1000000, depth), depth, sequence);
            expectSequence(randomPoints(count, depth, 3, depth), depth, sequence);  // many ties
        }
    }
}

// Corners come by rows, which spares the sequence a sort. Zeros of different signs must not make it believe that
// points come by rows when they do not.
TEST(Aqorb_Quadtree, sequence_of_points_in_raster_order)
{
    BalancedSequence sequence;
    for (int depth = 0; depth <= 8; depth++)
    {
        SCOPED_TRACE(depth);
        std::vector<LeafPoint> points = randomPoints(3000, depth, 3, depth);
        std::sort(points.begin(), points.end(),
                  [](const LeafPoint& a, const LeafPoint& b) { return a.y != b.y ? a.y < b.y : a.x < b.x; });
        for (size_t i = 0; i < points.size(); i++)
            points[i].index = int(i);
        expectSequence(points, depth, sequence);
    }
    std::vector<LeafPoint> points;
    const float xs[] = {0.f, 3.f, -0.f, -2.f};
    for (int i = 0; i < 4; i++)
    {
        const LeafPoint point = {0, 1.f, xs[i], 5.f, i};
        points.push_back(point);
    }
    expectSequence(points, 0, sequence);
}

// The sequence with a filter is that of the points which the filter accepts.
TEST(Aqorb_Quadtree, filter_leaves_points_out)
{
    struct NotThird : PointFilter
    {
        bool accepts(const LeafPoint& point) const CV_OVERRIDE { return point.index % 3 != 0; }
    };
    BalancedSequence sequence;
    for (int depth = 0; depth <= 6; depth++)
    {
        std::vector<LeafPoint> points = randomPoints(700, depth, 1000, depth), accepted;
        for (const LeafPoint& point : points)
        {
            if (NotThird().accepts(point))
                accepted.push_back(point);
        }
        const std::vector<LeafPoint> expected = reference::balancedSequence(accepted, depth);
        sequence.begin(points, depth);
        const NotThird filter;
        LeafPoint point;
        for (size_t i = 0; i < expected.size(); i++)
        {
            ASSERT_TRUE(sequence.next(point, &filter));
            ASSERT_EQ(point.index, expected[i].index) << i;
        }
        EXPECT_FALSE(sequence.next(point, &filter));
    }
}

TEST(Aqorb_Quadtree, sequence_ranks_all_floats)
{
    const float inf = std::numeric_limits<float>::infinity();
    const float nan = std::numeric_limits<float>::quiet_NaN();
    const float responses[] = {nan, -inf, -1.f, -1e-42f, -0.f, 0.f, 1e-42f, 2.f, inf, -nan};
    BalancedSequence sequence;
    for (int depth = 0; depth <= 3; depth++)
    {
        SCOPED_TRACE(depth);
        std::vector<LeafPoint> points;
        for (int i = 0; i < 300; i++)
        {
            const LeafPoint point = {unsigned(i / 10 % (1 << (2 * depth))), responses[i % 10], float(i / 50),
                                     float(i % 3), i};
            points.push_back(point);
        }
        expectSequence(points, depth, sequence);
    }
}

TEST(Aqorb_Quadtree, sequence_by_hand)
{
    // Depth 3: leaves 0 and 1 are in the first group of 16 leaves, 16 in the second.
    const LeafPoint given[] = {{0, 9, 0, 0, 0},  {0, 8, 0, 0, 1},  {1, 5, 0, 0, 2},
                               {16, 7, 0, 0, 3}, {16, 1, 0, 0, 4}, {0, 7.5f, 0, 0, 5}};
    // The groups' lists are 0 2 1 5 and 3 4; taken in turn by response: 0 3, 2 4, 1, 5.
    const int expected[] = {0, 3, 2, 4, 1, 5};
    std::vector<LeafPoint> points(given, given + 6);
    BalancedSequence sequence;
    sequence.begin(points, 3);
    for (int index : expected)
    {
        LeafPoint point;
        ASSERT_TRUE(sequence.next(point));
        EXPECT_EQ(point.index, index);
    }
}

}  // namespace
}  // namespace opencv_test
