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

namespace
{

// log2 of numbers > 0 that are finite, as fixed-point numbers with 24 bits of fraction. It is computed in integers, so
// it is the same on every CPU.
class BinaryLogarithm
{
public:
    BinaryLogarithm()
    {
        for (int i = 0; i < SIZE; i++)
        {
            // A number in [1, 2) with 62 bits of fraction. Each squaring yields one more bit of its logarithm.
            uint64 v = uint64(SIZE + i) << (62 - SIZE_BITS);
            int logarithm = 0;
            for (int bit = 0; bit < TABLE_BITS; bit++)
            {
                const uint64 high = v >> 32, low = v & 0xffffffff;
                v = 4 * high * high + (high * low >> 29) + (low * low >> 62);
                const int isTwoOrMore = int(v >> 63);
                logarithm = 2 * logarithm + isTwoOrMore;
                v >>= isTwoOrMore;
            }
            table[i] = logarithm;
        }
        table[SIZE] = 1 << TABLE_BITS;
    }
    int64 operator()(float v) const
    {
        int exponent = -127;
        if (v < FLT_MIN)
        {
            v *= 18446744073709551616.f;  // 2^64, so that it is normal
            exponent -= 64;
        }
        Cv32suf bits;
        bits.f = v;
        exponent += int(bits.u >> 23);
        const int STEP_BITS = 23 - SIZE_BITS;
        const unsigned fraction = bits.u & 0x7fffff, i = fraction >> STEP_BITS;
        const int64 step = fraction & ((1 << STEP_BITS) - 1);
        const int64 low = table[i], high = table[i + 1];
        return int64(exponent) * (1 << FRACTION_BITS) +
               ((low * (1 << STEP_BITS) + (high - low) * step) >> (STEP_BITS + TABLE_BITS - FRACTION_BITS));
    }

private:
    enum
    {
        FRACTION_BITS = 24,
        TABLE_BITS = 26,
        SIZE_BITS = 12,
        SIZE = 1 << SIZE_BITS
    };
    int table[SIZE + 1];  // floor(2^TABLE_BITS log2(1 + i / SIZE))
};

const BinaryLogarithm& sharedLogarithm()
{
    static const BinaryLogarithm logarithm;
    return logarithm;
}

}  // namespace

int64 binaryLogarithm(float v)
{
    return sharedLogarithm()(v);
}

bool RankedSequence::StrongerInLeaf::operator()(const LeafPoint& a, const LeafPoint& b) const
{
    if (a.leaf != b.leaf)
        return a.leaf < b.leaf;
    const int strengthOfA = orderOf(a.response), strengthOfB = orderOf(b.response);
    return strengthOfA != strengthOfB ? strengthOfA > strengthOfB : TieBefore()(a, b);
}

void RankedSequence::begin(int depth_, size_t size)
{
    depth = depth_;
    count = given = sorted = 0;
    hasOthers = false;
    others.clear();
    points.resize(size);
    const size_t stride = (size_t(1) << depth) + 2;
    grid.assign(stride * stride, INT_MIN);
    best.resize(grid.size());
}

void RankedSequence::findRepresentatives()
{
    CV_TRACE_FUNCTION();
    const int side = 1 << depth;
    representativeLeaves(grid, side, flags, leaves);
    chosen.resize(leaves.size());
    strengths.resize(leaves.size());
    for (size_t i = 0; i < leaves.size(); i++)
    {
        const int column = int(leaves[i]) & (side - 1), row = int(leaves[i] >> depth);
        chosen[i] = points[best[leafColumn(column) + leafRow(row)]];
        strengths[i] = chosen[i].response;
    }
}

// Sorts by counting, one byte after the other, because comparisons would be hard to predict.
void RankedSequence::sortByStrength()
{
    const size_t size = chosen.size();
    byStrength.resize(size);
    resorted.resize(size);
    for (size_t i = 0; i < size; i++)
        byStrength[i] = keyOf(strengths[i], i);
    const int DIGITS = 4;
    unsigned starts[DIGITS][256] = {{0}};
    for (size_t i = 0; i < size; i++)
    {
        for (int digit = 0; digit < DIGITS; digit++)
            starts[digit][byStrength[i] >> (32 + 8 * digit) & 255]++;
    }
    for (int digit = 0; digit < DIGITS; digit++)
    {
        unsigned begin = 0;
        for (int value = 255; value >= 0; value--)
        {
            const unsigned ofValue = starts[digit][value];
            starts[digit][value] = begin;
            begin += ofValue;
        }
        for (size_t i = 0; i < size; i++)
            resorted[starts[digit][byStrength[i] >> (32 + 8 * digit) & 255]++] = byStrength[i];
        byStrength.swap(resorted);
    }
}

void RankedSequence::rank(const RankRule& rule, int power, const std::vector<uchar>& usable)
{
    CV_TRACE_FUNCTION();
    const int side = 1 << depth;
    const size_t size = chosen.size();
    sortByStrength();
    ranked.resize(size);
    for (size_t i = 0; i < size; i++)
        ranked[i] = leaves[indexOf(byStrength[i])];

    Size region = rule.size;
    while (std::max(region.width, region.height) > 1 << 18)  // so that squares fit
        region = Size(std::max(region.width / 2, 1), std::max(region.height / 2, 1));
    const double squaredRadius = rule.radius * rule.radius * rule.usable * region.width * region.height *
                                 double(int64(1) << (2 * depth)) / rule.quota;
    disc.begin(region, int64(std::min(squaredRadius, 4e18)), side);
    ranks.resize(size);
    leafRanks(ranked.data(), size, depth, disc, ranking, ranks.data());

    // By row and column: how many leaves before the column are usable.
    usableBefore.clear();
    if (!usable.empty())
    {
        usableBefore.assign(size_t(side + 1) * side, 0);
        for (size_t i = 0; i < size; i++)
            usableBefore[size_t(ranked[i] >> depth) * (side + 1) + (ranked[i] & (side - 1)) + 1] = 1;
        for (int row = 0; row < side; row++)
        {
            int* before = &usableBefore[size_t(row) * (side + 1)];
            for (int column = 0; column < side; column++)
                before[column + 1] =
                    before[column] + (before[column + 1] || usable[size_t(row) * side + column]);
        }
    }

    // Away from the borders the part of the key that the rank decides depends on nothing else.
    const BinaryLogarithm& logarithm = sharedLogarithm();
    const auto rankKey = [&](int rank, int64 inside)
    { return (logarithm(float(inside + rank * disc.total)) - logarithm(float(inside))) * (1 << 18); };
    const int exponent = cvRound(rule.strengthWeight * (1 << 16)) * (4 / power);  // in units of 2^-18
    const int SHARED_RANKS = 32;
    int64 shared[SHARED_RANKS];
    for (int i = 0; i < SHARED_RANKS; i++)
        shared[i] = rankKey(i, disc.total);

    const int reach = int(disc.halfWidths.size()) - 1;
    entries.resize(size);
    for (size_t i = 0; i < size; i++)
    {
        const int column = int(ranked[i]) & (side - 1), row = int(ranked[i] >> depth);
        Entry& entry = entries[i];
        entry.place = unsigned(i);
        entry.index = indexOf(byStrength[i]);
        const bool isWhole = usable.empty() && column >= disc.widest && column < side - disc.widest &&
                             row >= reach && row < side - reach;
        entry.key = isWhole && ranks[i] < SHARED_RANKS
                        ? shared[ranks[i]]
                        : rankKey(ranks[i], isWhole ? disc.total : leavesInside(column, row));
        if (exponent > 0)
        {
            const float strength = strengths[entry.index];
            const int64 LAST = int64(1) << 61;
            if (!(strength > 0))
                entry.key += LAST;
            else if (cvIsInf(strength))
                entry.key -= LAST;
            else
                entry.key -= exponent * logarithm(strength);
        }
    }
    firstSorted = size_t(rule.quota) + size_t(rule.quota) / 4 + 16;
}

// The number of usable leaves of the disc around a leaf.
int RankedSequence::leavesInside(int column, int row) const
{
    const int side = 1 << depth, reach = int(disc.halfWidths.size()) - 1;
    int inside = 0;
    for (int y = std::max(row - reach, 0); y <= std::min(row + reach, side - 1); y++)
    {
        const int halfWidth = disc.halfWidths[std::abs(y - row)];
        const int begin = std::max(column - halfWidth, 0), end = std::min(column + halfWidth + 1, side);
        if (usableBefore.empty())
        {
            inside += end - begin;
            continue;
        }
        const int* before = &usableBefore[size_t(y) * (side + 1)];
        inside += before[end] - before[begin];
    }
    return inside;
}

void RankedSequence::sortMore()
{
    const size_t more = std::min(std::max(sorted, firstSorted), entries.size() - sorted);
    const std::vector<Entry>::iterator begin = entries.begin() + sorted;
    std::nth_element(begin, begin + (more - 1), entries.end());
    std::sort(begin, begin + more);
    sorted += more;
}

void RankedSequence::listOthers()
{
    hasOthers = true;
    flags.assign(grid.size(), uchar(0));
    for (size_t i = 0; i < chosen.size(); i++)
        flags[chosen[i].leaf] = 1;
    others.assign(points.begin(), points.begin() + count);
    std::sort(others.begin(), others.end(), StrongerInLeaf());
    // They are sorted by their place in their leaf, which takes the place of the leaf's number.
    size_t left = 0;
    unsigned place = 0, leaf = 0;
    for (size_t i = 0; i < count; i++)
    {
        place = i > 0 && others[i].leaf == leaf ? place + 1 : 0;
        leaf = others[i].leaf;
        if (place == 0 && flags[leaf])
            continue;
        others[left] = others[i];
        others[left++].leaf = place;
    }
    others.resize(left);
    std::sort(others.begin(), others.end(), StrongerInLeaf());
}

bool RankedSequence::next(LeafPoint& point, const PointFilter* filter)
{
    for (;;)
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
        given++;
        if (!filter || filter->accepts(point))
            return true;
    }
}

void numberLeaves(const Size& region, int depth, const RankedSequence& sequence, LeafScratch& scratch)
{
    scratch.columns.resize(region.width);
    scratch.rows.resize(region.height);
    for (int i = 0; i < region.width; i++)
        scratch.columns[i] = sequence.leafColumn(int((int64(i) << depth) / region.width));
    for (int i = 0; i < region.height; i++)
        scratch.rows[i] = sequence.leafRow(int((int64(i) << depth) / region.height));
}

void orderByResponse(std::vector<LeafPoint>& points, const RankRule& rule, RankedSequence& sequence)
{
    if (!areSortedByTies(points))
        std::sort(points.begin(), points.end(), TieBefore());
    for (size_t i = 0; i < points.size(); i++)
        sequence.add(points[i]);
    sequence.findRepresentatives();
    sequence.rank(rule, 1, std::vector<uchar>());
}

}  // namespace stages
}  // namespace aqorb
}  // namespace cv
