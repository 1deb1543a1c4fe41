// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "reference.hpp"

#include "ranked_order.hpp"

#include <climits>

namespace opencv_test
{
namespace
{

using namespace aqorb;

bool isInDisc(int64 dx, int64 dy, Size cell, int64 squaredRadius)
{
    return dx * dx * cell.width * cell.width + dy * dy * cell.height * cell.height <= squaredRadius;
}

TEST(Aqorb_RankKernels, disc_by_hand)
{
    LeafDisc disc;
    disc.reset(Size(1, 1), 0, 8);
    EXPECT_EQ(disc.halfWidths, std::vector<int>(1, 0));
    EXPECT_EQ(disc.total, 1);
    disc.reset(Size(3, 2), 36, 8);  // 2 leaves wide, 3 high, and (1, 2) is 5 away
    EXPECT_EQ(disc.halfWidths, std::vector<int>({2, 1, 1, 0}));
    EXPECT_EQ(disc.widest, 2);
    EXPECT_EQ(disc.total, 5 + 2 * (3 + 3 + 1));
    disc.reset(Size(3, 2), 36, 2);  // No leaf of a grid of 2 x 2 is 2 leaves away.
    EXPECT_EQ(disc.halfWidths, std::vector<int>({1, 1}));
    EXPECT_EQ(disc.widest, 1);
    EXPECT_EQ(disc.total, 19);
}

TEST(Aqorb_RankKernels, disc_equals_its_definition)
{
    LeafDisc disc;
    for (int seed = 1; seed <= 300; seed++)
    {
        SCOPED_TRACE(seed);
        RNG rng(seed);
        const Size cell(rng.uniform(1, 30), rng.uniform(1, 30));
        const int side = 1 << rng.uniform(0, 8);
        const int64 squaredRadius = rng.uniform(0, 1 << rng.uniform(1, 20));
        disc.reset(cell, squaredRadius, side);
        int total = 0, widest = 0;
        const int most = cvFloor(std::sqrt(double(squaredRadius))) + 1;
        std::vector<int> halfWidths;
        for (int dy = 0; dy <= most; dy++)
        {
            int halfWidth = -1;
            while (isInDisc(halfWidth + 1, dy, cell, squaredRadius))
                halfWidth++;
            total += (2 * halfWidth + 1) * (halfWidth < 0 ? 0 : dy > 0 ? 2 : 1);
            if (halfWidth >= 0 && dy < side)
                halfWidths.push_back(std::min(halfWidth, side - 1));
            widest = std::max(widest, std::min(halfWidth, side - 1));
        }
        EXPECT_EQ(disc.halfWidths, halfWidths);
        EXPECT_EQ(disc.total, total);
        EXPECT_EQ(disc.widest, widest);
    }
}

//! Checks the ranks of some leaves in random order, on the kernels for this CPU and on the baseline's.
void expectRanks(int depth, int count, Size cell, int64 squaredRadius, int seed, RankedScratch& scratch)
{
    const int side = 1 << depth;
    RNG rng(seed);
    std::vector<unsigned> leaves;
    for (int i = 0; i < count; i++)
        leaves.push_back(unsigned(rng.uniform(0, side * side)));
    if (count > 4)  // the corners, too
    {
        leaves[0] = 0;
        leaves[1] = unsigned(side - 1);
        leaves[2] = unsigned(side * side - 1);
        leaves[3] = unsigned(side * (side - 1));
    }
    std::sort(leaves.begin(), leaves.end());
    leaves.erase(std::unique(leaves.begin(), leaves.end()), leaves.end());
    for (size_t i = leaves.size(); i > 1; i--)
        std::swap(leaves[i - 1], leaves[rng.uniform(0, int(i))]);
    std::vector<int> expected;
    for (size_t i = 0; i < leaves.size(); i++)
    {
        int rank = 0;
        for (size_t j = 0; j < i; j++)
        {
            const int dx = int(leaves[j] % side) - int(leaves[i] % side);
            const int dy = int(leaves[j] / side) - int(leaves[i] / side);
            rank += isInDisc(dx, dy, cell, squaredRadius);
        }
        expected.push_back(rank);
    }
    LeafDisc disc;
    disc.reset(cell, squaredRadius, side);
    std::vector<int> ranks(leaves.size(), -1);
    leafRanks(leaves.data(), leaves.size(), depth, disc, scratch, ranks.data());
    EXPECT_EQ(ranks, expected);
    WithoutOptimization baseline;
    ranks.assign(leaves.size(), -1);
    leafRanks(leaves.data(), leaves.size(), depth, disc, scratch, ranks.data());
    EXPECT_EQ(ranks, expected);
}

TEST(Aqorb_RankKernels, ranks_equal_a_count_for_every_depth)
{
    RankedScratch scratch;  // It is used again, so what one case leaves in it must not matter.
    for (int depth = 0; depth <= 12; depth++)
        for (int radius : {0, 1, 2, 5})
        {
            SCOPED_TRACE(format("depth %d, radius %d", depth, radius));
            const int unit = std::max((1 << depth) / 16, 1);  // so that discs have others in them
            const int64 reach = int64(radius) * unit;
            if (depth < 12 || radius < 5)
                expectRanks(depth, 300, Size(1, 1), reach * reach, depth + 1, scratch);
        }
}

TEST(Aqorb_RankKernels, ranks_equal_a_count_for_discs_of_all_widths)
{
    RankedScratch scratch;
    // Up to 16, 17 and 33 columns the words of a row differ in number. The largest discs cover the grid.
    for (int radius = 0; radius <= 140; radius++)
    {
        SCOPED_TRACE(radius);
        expectRanks(7, 400, Size(1, 1), int64(radius) * radius, radius + 1, scratch);
        expectRanks(5, 400, Size(1, 3), int64(radius) * radius, radius + 1, scratch);
        expectRanks(6, 400, Size(5, 2), int64(radius) * radius, radius + 1, scratch);
    }
}

TEST(Aqorb_RankKernels, no_leaves_have_no_ranks)
{
    RankedScratch scratch;
    expectRanks(3, 0, Size(1, 1), 4, 1, scratch);
    expectRanks(0, 1, Size(1, 1), 100, 1, scratch);
}

//! Checks the representatives of a grid of strengths with its border.
void expectRepresentatives(const std::vector<int>& strengths, int side)
{
    std::vector<unsigned> expected;
    for (int row = 0; row < side; row++)
        for (int column = 0; column < side; column++)
        {
            const int own = strengths[size_t(row + 1) * (side + 2) + column + 1];
            int stronger = 0;
            for (int dy = -1; dy <= 1; dy++)
                for (int dx = -1; dx <= 1; dx++)
                {
                    const int other = strengths[size_t(row + dy + 1) * (side + 2) + column + dx + 1];
                    const bool isBefore = dy < 0 || (dy == 0 && dx < 0);
                    stronger += other > own || (other == own && isBefore);
                }
            if (own != INT_MIN && stronger < 3)
                expected.push_back(unsigned(row * side + column));
        }
    std::vector<uchar> flags(3, uchar(9));
    std::vector<unsigned> leaves(3, 9u);
    representativeLeaves(strengths, side, flags, leaves);
    EXPECT_EQ(leaves, expected);
    WithoutOptimization baseline;
    representativeLeaves(strengths, side, flags, leaves);
    EXPECT_EQ(leaves, expected);
}

TEST(Aqorb_RankKernels, representatives_equal_a_count_for_every_width)
{
    for (int side = 1; side <= MAX_WIDTH; side++)
        for (int kind = 0; kind < 4; kind++)
        {
            SCOPED_TRACE(format("side %d, kind %d", side, kind));
            RNG rng(side);
            std::vector<int> strengths(size_t(side + 2) * (side + 2), INT_MIN);
            for (int row = 1; row <= side; row++)
                for (int column = 1; column <= side; column++)
                {
                    int& strength = strengths[size_t(row) * (side + 2) + column];
                    if (kind == 0)
                        strength = std::max(int(rng.next()), INT_MIN + 1);
                    else if (kind == 1)
                        strength =
                            rng.uniform(0, 2) ? INT_MIN + rng.uniform(1, 4) : INT_MIN;  // many are equal
                    else if (kind == 2)
                        strength = rng.uniform(0, 40) ? INT_MIN : INT_MAX - rng.uniform(0, 3);  // few
                    else
                        strength = 7;
                }
            expectRepresentatives(strengths, side);
        }
}

}  // namespace
}  // namespace opencv_test
