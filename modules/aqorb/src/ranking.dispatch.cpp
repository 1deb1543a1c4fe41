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
    widest = total = 0;
    int64 dx = side - 1;
    for (int64 dy = 0; dy < side && dy * dy * height2 <= squaredRadius; dy++)
    {
        while (dx * dx * width2 + dy * dy * height2 > squaredRadius)
            dx--;
        halfWidths.push_back(int(dx));
        widest = std::max(widest, int(dx));
        total += int(2 * dx + 1) * (dy > 0 ? 2 : 1);
    }
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
    leaves.clear();
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
                if (flags[i])
                    leaves.push_back(unsigned(row * side + i));
            }
        }
    }
}

void leafRanks(const unsigned* leaves, size_t count, int depth, const LeafDisc& disc, RankingScratch& scratch,
               int* ranks)
{
    const int side = 1 << depth, reach = int(disc.halfWidths.size()) - 1, WORD = 32;
    RankingGrid grid;
    grid.depth = depth;
    grid.left = disc.widest;
    grid.top = reach;
    grid.stride = (side + 2 * disc.widest) / WORD + 1;
    scratch.bits.assign(size_t(grid.stride) * (side + 2 * reach), 0);
    scratch.words.clear();
    scratch.masks.clear();
    for (int row = 0; row <= 2 * reach; row++)
    {
        // The bits of the row, from the column disc.widest before the leaf on.
        const int halfWidth = disc.halfWidths[std::abs(row - reach)];
        const int begin = disc.widest - halfWidth, end = disc.widest + halfWidth + 1;
        for (int first = 0; first < end; first += WORD)
        {
            uint64 mask = 0;
            for (int bit = std::max(begin, first); bit < std::min(end, first + WORD); bit++)
                mask |= uint64(1) << (bit - first);
            if (!mask)
                continue;
            scratch.words.push_back(row * grid.stride + first / WORD);
            scratch.masks.push_back(mask);
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
