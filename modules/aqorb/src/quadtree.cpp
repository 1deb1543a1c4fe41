// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "precomp.hpp"

#include "quadtree.hpp"

namespace cv
{
namespace aqorb
{
namespace stages
{

int quadtreeDepth(int quota)
{
    int depth = 0;
    while (depth < MAX_QUADTREE_DEPTH && (int64(1) << (2 * depth)) < quota)
        depth++;
    return depth;
}

int maxRankedDepth(Size size)
{
    const int MAX_RANKED_DEPTH = 12, side = std::min(size.width, size.height);
    int depth = 0;
    while (depth < MAX_RANKED_DEPTH && (int64(4) << depth) <= side)
        depth++;
    return depth;
}

int rankedDepth(Size size, double usable, int quota)
{
    const double LEAVES_PER_POINT = 12;
    const int deepest = maxRankedDepth(size);
    int depth = 0;
    while (depth < deepest && double(int64(1) << (2 * depth)) * usable < LEAVES_PER_POINT * quota)
        depth++;
    return depth;
}

// Puts a zero before each bit: abcd becomes 0a0b0c0d.
static unsigned spreadBits(unsigned v)
{
    v = (v | (v << 8)) & 0x00ff00ffu;
    v = (v | (v << 4)) & 0x0f0f0f0fu;
    v = (v | (v << 2)) & 0x33333333u;
    return (v | (v << 1)) & 0x55555555u;
}

unsigned leafCode(unsigned column, unsigned row)
{
    return spreadBits(column) | (spreadBits(row) << 1);
}

// For each pixel along one axis of a root of the given length, what this axis contributes to the code of its leaf.
static void leafCodes(int length, int depth, std::vector<unsigned>& codes)
{
    codes.resize(length);
    const int64 leaves = int64(1) << depth;
    int64 leaf = 0, remainder = 0;  // pixel * leaves = leaf * length + remainder
    unsigned code = leafCode(0, 0);
    for (int i = 0; i < length; i++)
    {
        codes[i] = code;
        remainder += leaves;
        if (remainder >= length)
        {
            leaf += remainder / length;
            remainder %= length;
            code = leafCode(unsigned(leaf), 0);
        }
    }
}

void leafPoints(const std::vector<RankedCorner>& corners, const Rect& root, int depth, LeafScratch& scratch,
                std::vector<LeafPoint>& points)
{
    CV_TRACE_FUNCTION();
    leafCodes(root.width, depth, scratch.columns);
    leafCodes(root.height, depth, scratch.rows);
    points.resize(corners.size());
    for (size_t i = 0; i < corners.size(); i++)
    {
        const RankedCorner& c = corners[i];
        // The sides of a level are at most 2^20 - 1, so a float holds its coordinates exactly.
        const LeafPoint point = {scratch.columns[c.x - root.x] | scratch.rows[c.y - root.y] << 1, c.response,
                                 float(c.x), float(c.y), int(i)};
        points[i] = point;
    }
}

}  // namespace stages
}  // namespace aqorb
}  // namespace cv
