// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "reference.hpp"

#include "selection.hpp"

#include <climits>
#include <limits>

namespace opencv_test
{
namespace
{

using namespace aqorb;

TEST(Aqorb_Quadtree, depth_of_the_papers_example)
{
    // 500 features on 8 levels: 109 on the first, 30 on the last. The paper's text says 5 for the first,
    // which its equation (9) does not give.
    EXPECT_EQ(balancedDepth(109), 4);
    EXPECT_EQ(balancedDepth(30), 3);
}

TEST(Aqorb_Quadtree, depth_is_the_smallest_with_enough_leaves)
{
    EXPECT_EQ(balancedDepth(0), 0);
    EXPECT_EQ(balancedDepth(1), 0);
    EXPECT_EQ(balancedDepth(INT_MAX), 15);
    for (int depth = 0; depth < 15; depth++)
    {
        EXPECT_EQ(balancedDepth(1 << (2 * depth)), depth);
        EXPECT_EQ(balancedDepth((1 << (2 * depth)) + 1), depth + 1);
    }
}

TEST(Aqorb_Quadtree, leaves_divide_a_region_evenly)
{
    RNG rng(1);
    for (int i = 0; i < 300; i++)
    {
        const Size region(rng.uniform(1, 700), rng.uniform(1, 700));
        const int depth = rng.uniform(0, 16), trees = depth > 10 ? 1 : rng.uniform(1, 100);
        const LeafGrid grid = leafGrid(region, trees, depth);
        const int columns = (region.width > region.height ? trees : 1) << depth,
                  rows = (region.width > region.height ? 1 : trees) << depth;
        ASSERT_EQ(Size(grid.columns, grid.rows), Size(columns, rows));
        for (int j = 0; j < 50; j++)
        {
            const int x = rng.uniform(0, region.width), y = rng.uniform(0, region.height);
            const unsigned leaf = leafOf(x, y, region, grid);
            ASSERT_EQ(grid.columnOf(leaf), int64(x) * columns / region.width) << region << depth;
            ASSERT_EQ(grid.rowOf(leaf), int64(y) * rows / region.height) << region << depth;
        }
    }
}

std::vector<reference::LeafCorner> randomCorners(int count, int depth, int responses, int seed)
{
    RNG rng(seed);
    std::vector<reference::LeafCorner> corners;
    for (int i = 0; i < count; i++)
    {
        const int x = rng.uniform(0, 300), y = rng.uniform(0, 200);
        corners.push_back({(x << depth) / 300, (y << depth) / 200, float(x), float(y),
                           float(rng.uniform(-responses, responses)), i});
    }
    return corners;
}

//! The indices of corners in balancedOrder.
std::vector<int> balancedIndices(std::vector<reference::LeafCorner> corners, int depth)
{
    std::sort(corners.begin(), corners.end(),
              [](const reference::LeafCorner& a, const reference::LeafCorner& b) {
                  return a.y != b.y ? a.y < b.y : a.x != b.x ? a.x < b.x : a.index < b.index;
              });
    std::vector<LeafPoint> points;
    for (const reference::LeafCorner& corner : corners)
        points.push_back({unsigned(corner.row << depth | corner.column), aqorb::sortKey(corner.base)});
    std::vector<int> indices;
    for (unsigned index : balancedOrder(points, depth))
        indices.push_back(corners[index].index);
    return indices;
}

void expectOrder(const std::vector<reference::LeafCorner>& corners, int depth)
{
    EXPECT_EQ(balancedIndices(corners, depth), reference::balancedSequence(corners));
}

TEST(Aqorb_Quadtree, balanced_order_equals_its_definition)
{
    const int counts[] = {0, 1, 2, 7, 60, 500, 3000};
    for (int count : counts)
        for (int depth = 0; depth <= 15; depth++)
        {
            SCOPED_TRACE(format("%d points, depth %d", count, depth));
            expectOrder(randomCorners(count, depth, 1000000, depth), depth);
            expectOrder(randomCorners(count, depth, 3, depth), depth);  // many ties
        }
}

TEST(Aqorb_Quadtree, balanced_order_of_all_floats)
{
    const float inf = std::numeric_limits<float>::infinity();
    const float nan = std::numeric_limits<float>::quiet_NaN();
    const float responses[] = {nan, -inf, -1.f, -1e-42f, -0.f, 0.f, 1e-42f, 2.f, inf, -nan};
    for (int depth = 0; depth <= 3; depth++)
    {
        SCOPED_TRACE(depth);
        std::vector<reference::LeafCorner> corners;
        for (int i = 0; i < 300; i++)
        {
            const int leaf = i / 10 % (1 << (2 * depth)), side = 1 << depth;
            corners.push_back({leaf % side, leaf / side, float(i / 50), float(i % 3), responses[i % 10], i});
        }
        expectOrder(corners, depth);
    }
}

TEST(Aqorb_Quadtree, balanced_order_by_hand)
{
    // Depth 3: columns 0 and 1 are in the first group of 16 leaves, 4 in the second.
    const std::vector<reference::LeafCorner> given = {{0, 0, 0, 0, 9, 0}, {0, 0, 0, 0, 8, 1},
                                                      {1, 0, 0, 0, 5, 2}, {4, 0, 0, 0, 7, 3},
                                                      {4, 0, 0, 0, 1, 4}, {0, 0, 0, 0, 7.5f, 5}};
    // The groups' lists are 0 2 1 5 and 3 4; taken in turn by response: 0 3, 2 4, 1, 5.
    EXPECT_EQ(balancedIndices(given, 3), std::vector<int>({0, 3, 2, 4, 1, 5}));
}

}  // namespace
}  // namespace opencv_test
