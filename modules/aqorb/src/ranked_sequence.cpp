// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "precomp.hpp"

#include "logarithm.hpp"
#include "ranked_sequence.hpp"

namespace cv
{
namespace aqorb
{
namespace stages
{

namespace
{

// Orders points by leaf, and in a leaf by strength.
struct StrongerInLeaf
{
    bool operator()(const LeafPoint& a, const LeafPoint& b) const
    {
        if (a.leaf != b.leaf)
            return a.leaf < b.leaf;
        const int strengthOfA = orderOf(a.response), strengthOfB = orderOf(b.response);
        return strengthOfA != strengthOfB ? strengthOfA > strengthOfB : TieBefore()(a, b);
    }
};

// Of equally strong representatives the one of lower index has the greater key.
uint64 keyOf(float strength, size_t index)
{
    return uint64(unsignedOrderOf(strength)) << 32 | unsigned(~index);
}
unsigned indexOf(uint64 key)
{
    return ~unsigned(key);
}

}  // namespace

void PointList::sort()
{
    if (!areSortedByTies(points))
        std::sort(points.begin(), points.end(), TieBefore());
}

void RankedSequence::begin(int depth_, const PointSource& points, RankedScratch& scratch_)
{
    depth = depth_;
    source = &points;
    scratch = &scratch_;
    given = sorted = 0;
    hasOthers = false;
    others.clear();
    const size_t stride = (size_t(1) << depth) + 2;
    scratch->grid.assign(stride * stride, INT_MIN);
    scratch->best.resize(scratch->grid.size());
}

void RankedSequence::addAll()
{
    Adder adder(*this);
    for (size_t i = 0; i < source->count(); i++)
    {
        const LeafPoint point = source->point(i);
        adder.add(source->leaf(point), point.response, i);
    }
}

void RankedSequence::findRepresentatives()
{
    CV_TRACE_FUNCTION();
    const int side = 1 << depth;
    std::vector<unsigned>& leaves = scratch->leaves;
    representativeLeaves(scratch->grid, side, scratch->flags, leaves);
    chosen.resize(leaves.size());
    scratch->strengths.resize(leaves.size());
    for (size_t i = 0; i < leaves.size(); i++)
    {
        const int column = int(leaves[i]) & (side - 1), row = int(leaves[i] >> depth);
        const unsigned leaf = leafColumn(column) + leafRow(row, depth);
        chosen[i] = source->point(scratch->best[leaf]);
        chosen[i].leaf = leaf;
        scratch->strengths[i] = chosen[i].response;
    }
}

// Sorts by counting, one byte after the other, because comparisons would be hard to predict.
void RankedSequence::sortByStrength()
{
    const size_t size = chosen.size();
    std::vector<uint64>&byStrength = scratch->byStrength, &resorted = scratch->resorted;
    byStrength.resize(size);
    resorted.resize(size);
    for (size_t i = 0; i < size; i++)
        byStrength[i] = keyOf(scratch->strengths[i], i);
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

// By row and column: how many leaves before the column are usable. Leaves of representatives are.
void RankedSequence::countUsable(const std::vector<uchar>& usable)
{
    const int side = 1 << depth;
    std::vector<int>& usableBefore = scratch->usableBefore;
    usableBefore.clear();
    if (usable.empty())
        return;
    usableBefore.assign(size_t(side + 1) * side, 0);
    for (unsigned leaf : scratch->ranked)
        usableBefore[size_t(leaf >> depth) * (side + 1) + (leaf & (side - 1)) + 1] = 1;
    for (int row = 0; row < side; row++)
    {
        int* before = &usableBefore[size_t(row) * (side + 1)];
        for (int column = 0; column < side; column++)
            before[column + 1] = before[column] + (before[column + 1] || usable[size_t(row) * side + column]);
    }
}

void RankedSequence::rank(const RankRule& rule, int power, const std::vector<uchar>& usable)
{
    CV_TRACE_FUNCTION();
    const int side = 1 << depth;
    const size_t size = chosen.size();
    const LeafDisc& disc = scratch->disc;
    sortByStrength();
    std::vector<unsigned>& ranked = scratch->ranked;
    ranked.resize(size);
    for (size_t i = 0; i < size; i++)
        ranked[i] = scratch->leaves[indexOf(scratch->byStrength[i])];
    countUsable(usable);

    Size region = rule.size;
    while (std::max(region.width, region.height) > 1 << 18)  // so that squares fit
        region = Size(std::max(region.width / 2, 1), std::max(region.height / 2, 1));
    const double squaredRadius = rule.radius * rule.radius * rule.usable * region.width * region.height *
                                 double(int64(1) << (2 * depth)) / rule.quota;
    scratch->disc.begin(region, int64(std::min(squaredRadius, 4e18)), side);
    std::vector<int>& ranks = scratch->ranks;
    ranks.resize(size);
    leafRanks(ranked.data(), size, depth, disc, scratch->ranking, ranks.data());

    // Away from the borders the part of the key that the rank decides depends on nothing else.
    const BinaryLogarithm& logarithm = BinaryLogarithm::shared();
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
        entry.index = indexOf(scratch->byStrength[i]);
        const bool isWhole = usable.empty() && column >= disc.widest && column < side - disc.widest &&
                             row >= reach && row < side - reach;
        entry.key = isWhole && ranks[i] < SHARED_RANKS
                        ? shared[ranks[i]]
                        : rankKey(ranks[i], isWhole ? disc.total : leavesInside(column, row));
        if (exponent > 0)
        {
            const float strength = scratch->strengths[entry.index];
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
    scratch = 0;
}

// The number of usable leaves of the disc around a leaf.
int RankedSequence::leavesInside(int column, int row) const
{
    const LeafDisc& disc = scratch->disc;
    const std::vector<int>& usableBefore = scratch->usableBefore;
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
    const size_t stride = (size_t(1) << depth) + 2, count = source->count();
    std::vector<uchar> isRepresented(stride * stride, uchar(0));
    for (size_t i = 0; i < chosen.size(); i++)
        isRepresented[chosen[i].leaf] = 1;
    others.resize(count);
    for (size_t i = 0; i < count; i++)
    {
        others[i] = source->point(i);
        others[i].leaf = source->leaf(others[i]);
    }
    std::sort(others.begin(), others.end(), StrongerInLeaf());
    // They are sorted by their place in their leaf, which takes the place of the leaf's number.
    size_t left = 0;
    unsigned place = 0, leaf = 0;
    for (size_t i = 0; i < count; i++)
    {
        place = i > 0 && others[i].leaf == leaf ? place + 1 : 0;
        leaf = others[i].leaf;
        if (place == 0 && isRepresented[leaf])
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
        const bool isOther = given++ >= entries.size();
        if (filter && !filter->accepts(point))
            continue;
        if (isOther)
            point.response = source->response(point);
        return true;
    }
}

// By pixel of an axis: leaf, which is floor(pixel * leaves / length), without a division for each.
template <typename Number>
static void numberAxis(int length, int depth, const Number& number, std::vector<unsigned>& numbers)
{
    numbers.resize(length);
    const int64 leaves = int64(1) << depth;
    int64 leaf = 0, remainder = 0;  // pixel * leaves = leaf * length + remainder
    for (int i = 0; i < length; i++)
    {
        numbers[i] = number(int(leaf));
        for (remainder += leaves; remainder >= length; remainder -= length)
            leaf++;
    }
}

void numberLeaves(const Size& region, int depth, LeafScratch& scratch)
{
    numberAxis(region.width, depth, leafColumn, scratch.columns);
    numberAxis(
        region.height, depth, [&](int row) { return leafRow(row, depth); }, scratch.rows);
}

}  // namespace stages
}  // namespace aqorb
}  // namespace cv
