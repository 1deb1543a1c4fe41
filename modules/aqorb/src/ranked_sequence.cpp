// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "precomp.hpp"

#include "ranked_sequence.hpp"

namespace cv
{
namespace aqorb
{
namespace stages
{

int strengthExponent(double strengthWeight, int power)
{
    return cvRound(strengthWeight * 65536) * (4 / power);
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
    const double LEAVES_PER_POINT = 16;
    const int deepest = maxRankedDepth(size);
    int depth = 0;
    while (depth < deepest && double(int64(1) << (2 * depth)) * usable < LEAVES_PER_POINT * quota)
        depth++;
    return depth;
}

namespace
{

// floor(2^26 log2(1 + i / 4096)) for i = 0 .. 4096.
struct LogarithmTable
{
    LogarithmTable()
    {
        const int BITS = 26;
        for (int i = 0; i <= SIZE; i++)
        {
            // A number in [1, 2) with 31 bits of fraction. Each squaring yields one more bit of the logarithm.
            uint64 v = uint64(SIZE + i) << 19;
            int64 logarithm = 0;
            if (v >> 32)
            {
                values[i] = int64(1) << BITS;
                continue;
            }
            for (int bit = 0; bit < BITS; bit++)
            {
                v = (v * v) >> 31;
                logarithm *= 2;
                if (v >> 32)
                {
                    logarithm++;
                    v >>= 1;
                }
            }
            values[i] = logarithm;
        }
    }
    enum
    {
        SIZE = 4096
    };
    int64 values[SIZE + 1];
};

}  // namespace

int64 binaryLogarithm(float v)
{
    static const LogarithmTable table;
    int exponent = 0;
    if (v < FLT_MIN)
    {
        v *= 18446744073709551616.f;  // 2^64, so that it is normal
        exponent = -64;
    }
    Cv32suf bits;
    bits.f = v;
    exponent += int(bits.u >> 23) - 127;
    const unsigned fraction = bits.u & 0x7fffff, i = fraction >> 11, t = fraction & 2047;
    const int64 low = table.values[i], high = table.values[i + 1];
    return int64(exponent) * (1 << 24) + ((low * 2048 + (high - low) * t) >> 13);
}

void leafCells(const std::vector<RankedCorner>& corners, const Rect& root, int depth, LeafScratch& scratch,
               std::vector<LeafPoint>& points)
{
    CV_TRACE_FUNCTION();
    scratch.columns.resize(root.width);
    scratch.rows.resize(root.height);
    for (int i = 0; i < root.width; i++)
        scratch.columns[i] = unsigned((uint64(i) << depth) / root.width);
    for (int i = 0; i < root.height; i++)
        scratch.rows[i] = unsigned((uint64(i) << depth) / root.height) << depth;
    points.resize(corners.size());
    for (size_t i = 0; i < corners.size(); i++)
    {
        const RankedCorner& c = corners[i];
        const LeafPoint point = {scratch.columns[c.x - root.x] | scratch.rows[c.y - root.y], c.response,
                                 float(c.x), float(c.y), int(i)};
        points[i] = point;
    }
}

namespace
{

// A whole number that orders strengths as their values do. NaN comes before all others, and none is INT_MIN.
int orderOf(float strength)
{
    if (cvIsNaN(strength))
        return INT_MIN + 1;
    Cv32suf bits;
    bits.f = strength + 0.f;  // makes -0 equal to 0
    return bits.i >= 0 ? bits.i : INT_MIN + 1 + int(~bits.u & 0x7fffffff);
}

struct StrongerInLeaf
{
    bool operator()(const LeafPoint& a, const LeafPoint& b) const
    {
        if (a.leaf != b.leaf)
            return a.leaf < b.leaf;
        const int sa = orderOf(strengths[a.index]), sb = orderOf(strengths[b.index]);
        if (sa != sb)
            return sa > sb;
        return TieBefore()(a, b);
    }
    const float* strengths;
};

}  // namespace

void RankedSequence::begin(std::vector<LeafPoint>& points_, const std::vector<float>& strengths_, int depth_)
{
    CV_TRACE_FUNCTION();
    points.swap(points_);
    strengths = strengths_;
    depth = depth_;
    entries.clear();
    given = sorted = 0;
    hasOthers = false;
    others.clear();
    if (!areSortedByTies(points))
        std::sort(points.begin(), points.end(), TieBefore());

    best.assign(size_t(1) << (2 * depth), 0);
    for (size_t i = 0; i < points.size(); i++)
    {
        // Biased, so that it is never 0. Of equal strengths the first point wins.
        const uint64 key =
            uint64(unsigned(orderOf(strengths[points[i].index])) ^ 0x80000000u) << 32 | unsigned(~i);
        uint64& of = best[points[i].leaf];
        of = std::max(of, key);
    }
    chosen.clear();
    for (size_t leaf = 0; leaf < best.size(); leaf++)
    {
        if (best[leaf])
            chosen.push_back(points[unsigned(~best[leaf])]);
    }
}

void RankedSequence::rank(const std::vector<float>& scores, const RankRule& rule,
                          const std::vector<uchar>& usable)
{
    CV_TRACE_FUNCTION();
    const int side = 1 << depth;
    // The squared radius of the disc, in units in which leaf offsets (dx, dy) are dx * width and dy * height long.
    Size size = rule.size;
    while (std::max(size.width, size.height) > 1 << 18)
        size = Size((size.width + 1) / 2, (size.height + 1) / 2);
    const int64 width2 = int64(size.width) * size.width, height2 = int64(size.height) * size.height;
    const int64 reach = int64(std::min(rule.radius * rule.radius * rule.usable * size.width * size.height *
                                           double(int64(1) << (2 * depth)) / rule.quota,
                                       4e18));
    // By row of the disc, how far it extends to both sides.
    std::vector<int> halfWidths;
    int total = 0, widest = 0;
    for (int64 dy = 0; dy < side && dy * dy * height2 <= reach; dy++)
    {
        int64 dx = 0;
        while (dx + 1 < side && (dx + 1) * (dx + 1) * width2 + dy * dy * height2 <= reach)
            dx++;
        halfWidths.push_back(int(dx));
        widest = std::max(widest, int(dx));
        total += int(2 * dx + 1) * (dy > 0 ? 2 : 1);
    }
    const int reachY = int(halfWidths.size()) - 1;

    const int stride = side + 2 * widest;
    grid.assign(size_t(stride) * (side + 2 * reachY), INT_MIN);
    scoreOrder.resize(chosen.size());
    for (size_t i = 0; i < chosen.size(); i++)
    {
        const int column = int(chosen[i].leaf) & (side - 1), row = int(chosen[i].leaf >> depth);
        scoreOrder[i] = orderOf(scores[i]);
        grid[size_t(row + reachY) * stride + column + widest] = scoreOrder[i];
    }
    usableBefore.clear();
    if (!usable.empty())
    {
        // Prefix sums of the rows
        usableBefore.assign(size_t(side + 1) * side, 0);
        for (int row = 0; row < side; row++)
        {
            int* before = &usableBefore[size_t(row) * (side + 1)];
            for (int column = 0; column < side; column++)
            {
                const bool counts = usable[size_t(row) * side + column] ||
                                    grid[size_t(row + reachY) * stride + column + widest] != INT_MIN;
                before[column + 1] = before[column] + counts;
            }
        }
    }

    entries.resize(chosen.size());
    for (size_t i = 0; i < chosen.size(); i++)
    {
        const int column = int(chosen[i].leaf) & (side - 1), row = int(chosen[i].leaf >> depth);
        const int own = scoreOrder[i];
        int stronger = 0, inside = 0;
        for (int dy = -reachY; dy <= reachY; dy++)
        {
            const int halfWidth = halfWidths[std::abs(dy)];
            const int* at = &grid[size_t(row + reachY + dy) * stride + column + widest];
            if (dy < 0)
                for (int dx = -halfWidth; dx <= halfWidth; dx++)
                    stronger += at[dx] >= own;
            else if (dy > 0)
                for (int dx = -halfWidth; dx <= halfWidth; dx++)
                    stronger += at[dx] > own;
            else
                for (int dx = 1; dx <= halfWidth; dx++)
                    stronger += (at[-dx] >= own) + (at[dx] > own);
            if (row + dy >= 0 && row + dy < side)
            {
                const int begin = std::max(column - halfWidth, 0),
                          end = std::min(column + halfWidth + 1, side);
                inside += usable.empty() ? end - begin
                                         : usableBefore[size_t(row + dy) * (side + 1) + end] -
                                               usableBefore[size_t(row + dy) * (side + 1) + begin];
            }
        }
        Entry& entry = entries[i];
        entry.index = unsigned(i);
        entry.strength = own;
        entry.key = (binaryLogarithm(float(inside + int64(stronger) * total)) - binaryLogarithm(float(inside))) *
                    (1 << 18);
        if (rule.exponent > 0)
        {
            const float score = scores[i];
            const int64 LAST = int64(1) << 61;
            if (!(score > 0))
                entry.key += LAST;
            else if (cvIsInf(score))
                entry.key -= LAST;
            else
                entry.key -= rule.exponent * binaryLogarithm(score);
        }
    }
}

void RankedSequence::sortMore()
{
    const size_t more = std::min(std::max(sorted, size_t(64)), entries.size() - sorted);
    std::nth_element(entries.begin() + sorted, entries.begin() + sorted + more - 1, entries.end());
    std::sort(entries.begin() + sorted, entries.begin() + sorted + more);
    sorted += more;
}

void RankedSequence::listOthers()
{
    hasOthers = true;
    const StrongerInLeaf stronger = {strengths.data()};
    std::sort(points.begin(), points.end(), stronger);
    // Sorted by place in the leaf, strength, and ties: LeafPoint::leaf becomes the place.
    unsigned place = 0, leaf = 0;
    for (size_t i = 0; i < points.size(); i++)
    {
        place = i > 0 && points[i].leaf == leaf ? place + 1 : 0;
        leaf = points[i].leaf;
        if (place > 0)
        {
            others.push_back(points[i]);
            others.back().leaf = place;
        }
    }
    std::sort(others.begin(), others.end(), stronger);
}

bool RankedSequence::next(LeafPoint& point, const PointFilter* filter)
{
    for (;; given++)
    {
        if (given < entries.size())
        {
            if (given == sorted)
                sortMore();
            point = chosen[entries[given].index];
        }
        else
        {
            if (!hasOthers)
                listOthers();
            if (given - entries.size() == others.size())
                return false;
            point = others[given - entries.size()];
        }
        if (!filter || filter->accepts(point))
        {
            given++;
            return true;
        }
    }
}

void orderByResponse(std::vector<LeafPoint>& points, int depth, const RankRule& rule, RankedSequence& sequence)
{
    int last = -1;
    for (size_t i = 0; i < points.size(); i++)
        last = std::max(last, points[i].index);
    std::vector<float> strengths(size_t(last + 1)), scores;
    for (size_t i = 0; i < points.size(); i++)
        strengths[points[i].index] = points[i].response;
    sequence.begin(points, strengths, depth);
    const std::vector<LeafPoint>& best = sequence.representatives();
    for (size_t i = 0; i < best.size(); i++)
        scores.push_back(best[i].response);
    sequence.rank(scores, rule, std::vector<uchar>());
}

}  // namespace stages
}  // namespace aqorb
}  // namespace cv
