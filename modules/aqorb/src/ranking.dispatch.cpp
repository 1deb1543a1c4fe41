// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "precomp.hpp"

#include "ranking.hpp"

#include "ranking.simd.hpp"
#include "ranking.simd_declarations.hpp"  // defines CV_CPU_DISPATCH_MODES_ALL

namespace cv
{
namespace aqorb
{
namespace stages
{

void LeafDisc::begin(const Size& cell, int64 squaredRadius, int side)
{
    const int64 width2 = int64(cell.width) * cell.width, height2 = int64(cell.height) * cell.height;
    halfWidths.clear();
    total = 0;
    int64 dx = int64(std::sqrt(double(squaredRadius))) / cell.width + 1;  // not too small
    for (int64 dy = 0; dy * dy * height2 <= squaredRadius; dy++)
    {
        while (dx * dx * width2 + dy * dy * height2 > squaredRadius)
            dx--;
        if (dy < side)
            halfWidths.push_back(int(std::min<int64>(dx, side - 1)));
        total += (2 * dx + 1) * (dy > 0 ? 2 : 1);
    }
    widest = halfWidths[0];
}

static void flagRow(const int* strengths, ptrdiff_t stride, int side, uchar* flags)
{
    CV_CPU_DISPATCH(flagRepresentatives, (strengths, stride, side, flags), CV_CPU_DISPATCH_MODES_ALL);
}

void representativeLeaves(const std::vector<int>& strengths, int side, std::vector<uchar>& flags,
                          std::vector<unsigned>& leaves)
{
    const int stride = side + 2, AT_ONCE = int(sizeof(uint64));
    flags.assign(alignSize(size_t(side), AT_ONCE), uchar(0));
    leaves.resize(size_t(side) * side);
    size_t count = 0;
    for (int row = 0; row < side; row++)
    {
        flagRow(&strengths[size_t(row + 1) * stride + 1], stride, side, flags.data());
        for (int first = 0; first < side; first += AT_ONCE)
        {
            // Few leaves are representatives, so that most groups have none.
            uint64 any;
            std::memcpy(&any, &flags[first], sizeof(any));
            for (int i = first; any && i < std::min(first + AT_ONCE, side); i++)
            {
                leaves[count] = unsigned(row * side + i);
                count += flags[i];
            }
        }
    }
    leaves.resize(count);
}

void leafRanks(const unsigned* leaves, size_t count, int depth, const LeafDisc& disc, RankingScratch& scratch,
               int* ranks)
{
    // The border has one more row above, and each row one more word before, for the bits that are set twice.
    const int side = 1 << depth, reach = int(disc.halfWidths.size()) - 1, WORD = 16;
    RankingGrid grid;
    grid.depth = depth;
    grid.left = disc.widest;
    grid.top = reach + 1;
    grid.stride = (side + 2 * disc.widest) / WORD + 2;
    scratch.bits.assign(size_t(grid.stride) * (side + 2 * reach + 1), 0);
    scratch.words.clear();
    scratch.masks.clear();
    // Two rows at a time, the bits from the column disc.widest before the leaf on.
    for (int row = 0; row <= 2 * reach; row += 2)
    {
        for (int first = 0; first < 2 * disc.widest + 1;)
        {
            const int last = first + (2 * disc.widest + 1 - first == WORD + 1 ? WORD + 1 : WORD);
            uint64 mask = 0;
            for (int i = 0; i < 2 && row + i <= 2 * reach; i++)
            {
                const int halfWidth = disc.halfWidths[std::abs(row + i - reach)];
                const int begin = std::max(disc.widest - halfWidth, first);
                const int end = std::min(disc.widest + halfWidth + 1, last);
                for (int bit = begin; bit < end; bit++)
                    mask |= uint64(1) << (bit - first + 32 * i);
            }
            if (mask)
            {
                scratch.words.push_back((row + 1) * grid.stride + first / WORD + 1);
                scratch.masks.push_back(mask);
            }
            first = last;
        }
    }
    grid.bits = scratch.bits.data();
    grid.words = scratch.words.data();
    grid.masks = scratch.masks.data();
    grid.wordCount = int(scratch.words.size());
    CV_CPU_DISPATCH(countBefore, (grid, leaves, count, ranks), CV_CPU_DISPATCH_MODES_ALL);
}

}  // namespace stages
}  // namespace aqorb
}  // namespace cv
