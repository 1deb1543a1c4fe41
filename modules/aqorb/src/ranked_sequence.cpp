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

// Less for stronger points.
static unsigned weaknessOf(float response)
{
    return ~unsignedOrderOf(response);
}

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
    given = 0;
    hasOthers = false;
    others.clear();
    const size_t stride = (size_t(1) << depth) + 2;
    scratch->grid.assign(stride * stride, INT_MIN);
    scratch->best.resize(scratch->grid.size());
}

void RankedSequence::beginUnranked(const PointSource& points, const std::vector<RankedCorner>& responses)
{
    source = &points;
    scratch = 0;
    given = 0;
    hasOthers = true;
    others.clear();
    entries.resize(responses.size());
    for (size_t i = 0; i < responses.size(); i++)
    {
        entries[i].point = unsigned(i);
        entries[i].response = responses[i].response;
    }
}

void RankedSequence::addAll()
{
    Adder adder(*this);
    for (size_t i = 0; i < source->count(); i++)
    {
        const LeafPoint point = source->point(i);
        adder.add(source->leaf(point), orderOf(point.response), i);
    }
}

void RankedSequence::findRepresentatives()
{
    CV_TRACE_FUNCTION();
    const int side = 1 << depth;
    representativeLeaves(scratch->grid, side, scratch->flags, scratch->leaves);
    const size_t size = scratch->leaves.size();
    scratch->points.resize(size);
    scratch->strengths.resize(size);
    for (size_t i = 0; i < size; i++)
    {
        const int column = int(scratch->leaves[i]) & (side - 1), row = int(scratch->leaves[i] >> depth);
        const unsigned leaf = leafColumn(column) + leafRow(row, depth);
        scratch->points[i] = scratch->best[leaf];
        scratch->strengths[i] = responseOf(scratch->grid[leaf]);
    }
    scratch->responses = scratch->strengths;
}

void RankedSequence::sortByStrength()
{
    std::vector<uint64>& numbers = scratch->numbers;
    numbers.resize(scratch->strengths.size());
    for (size_t i = 0; i < numbers.size(); i++)
        numbers[i] = ~unsignedOrderOf(scratch->strengths[i]);
    sortIndices(numbers, scratch->sorting, scratch->byStrength);
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
    const size_t size = scratch->points.size();
    const LeafDisc& disc = scratch->disc;
    sortByStrength();
    std::vector<unsigned>& ranked = scratch->ranked;
    ranked.resize(size);
    for (size_t i = 0; i < size; i++)
        ranked[i] = scratch->leaves[scratch->byStrength[i]];
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

    // The numbers order keys as the keys themselves do. Strengths of 0 or infinity lie far outside of the range of others.
    const int64 LAST = int64(1) << 61;
    const auto numberOf = [](int64 key) { return uint64(key) ^ uint64(1) << 63; };
    uint64 least = numberOf(LAST), greatest = numberOf(-LAST);
    const int reach = int(disc.halfWidths.size()) - 1;
    scratch->inside.clear();
    scratch->numbers.resize(size);
    for (size_t i = 0; i < size; i++)
    {
        const int column = int(ranked[i]) & (side - 1), row = int(ranked[i] >> depth);
        const bool isWhole = usable.empty() && column >= disc.widest && column < side - disc.widest &&
                             row >= reach && row < side - reach;
        int64 key = isWhole && ranks[i] < SHARED_RANKS
                        ? shared[ranks[i]]
                        : rankKey(ranks[i], isWhole ? disc.total : leavesInsideAsBefore(column, row));
        const float strength = scratch->strengths[scratch->byStrength[i]];
        const bool isOrdinary = exponent == 0 || (strength > 0 && !cvIsInf(strength));
        if (exponent > 0)
            key += isOrdinary ? -exponent * logarithm(strength) : strength > 0 ? -LAST : LAST;
        const uint64 number = scratch->numbers[i] = numberOf(key);
        if (isOrdinary)
        {
            least = std::min(least, number);
            greatest = std::max(greatest, number);
        }
    }
    sortIndices(scratch->numbers, std::min(least, greatest), greatest, scratch->sorting, scratch->sorted);
    entries.resize(size);
    for (size_t i = 0; i < size; i++)
    {
        const unsigned index = scratch->byStrength[scratch->sorted[i]];
        entries[i].point = scratch->points[index];
        entries[i].response = scratch->responses[index];
    }
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

// The same, remembered by the distances to the borders of the region, on which alone it depends where all leaves are
// usable.
int RankedSequence::leavesInsideAsBefore(int column, int row) const
{
    const LeafDisc& disc = scratch->disc;
    const int side = 1 << depth, widest = disc.widest, reach = int(disc.halfWidths.size()) - 1;
    if (!scratch->usableBefore.empty() || side <= 2 * std::max(widest, reach))
        return leavesInside(column, row);
    const int columns = 2 * widest + 1, rows = 2 * reach + 1;
    if (scratch->inside.empty())
        scratch->inside.resize(size_t(columns) * rows);
    const int x = column < widest ? column : std::max(widest, 2 * widest - (side - 1 - column));
    const int y = row < reach ? row : std::max(reach, 2 * reach - (side - 1 - row));
    int& inside = scratch->inside[size_t(y) * columns + x];
    if (inside == 0)
        inside = leavesInside(column, row);
    return inside;
}

void RankedSequence::listOthers()
{
    hasOthers = true;
    const unsigned count = unsigned(source->count());
    isRepresentative.assign(count, uchar(0));
    for (size_t i = 0; i < entries.size(); i++)
        isRepresentative[entries[i].point] = 1;
    if (!takesAll)
        numberByPlaces();
    others.clear();
    for (unsigned i = 0; i < count; i++)
    {
        if (isRepresentative[i])
            continue;
        if (!takesAll)
            placeNumbers[others.size()] = placeNumbers[i];
        others.push_back(i);
    }
    if (takesAll)
        return;
    placeNumbers.resize(others.size());
    sortIndices(placeNumbers, sorting, byPlace);
    for (unsigned& index : byPlace)
        index = others[index];
    others.swap(byPlace);
}

// Numbers all points by their place in their leaf, then by strength. A representative has the first place in its leaf.
void RankedSequence::numberByPlaces()
{
    const size_t count = source->count();
    placeNumbers.resize(count);
    for (size_t i = 0; i < count; i++)
    {
        const LeafPoint point = source->point(i);
        placeNumbers[i] = uint64(source->leaf(point)) << 32 | weaknessOf(point.response);
    }
    sortIndices(placeNumbers, sorting, byPlace);
    uint64 leaf = 0, place = 0;
    for (size_t i = 0; i < count; i++)
    {
        uint64& number = placeNumbers[byPlace[i]];
        place = i > 0 && number >> 32 == leaf ? place + 1 : 0;
        leaf = number >> 32;
        number = place << 32 | unsigned(number);
    }
}

bool RankedSequence::next(LeafPoint& point, const PointFilter* filter)
{
    for (;;)
    {
        const bool isRanked = given < entries.size();
        if (isRanked)
        {
            point = source->point(entries[given].point);
            point.response = entries[given].response;
        }
        else
        {
            if (!hasOthers)
                listOthers();
            if (given - entries.size() == others.size())
                return false;
            point = source->point(others[given - entries.size()]);
        }
        given++;
        if (filter && !filter->accepts(point))
            continue;
        if (!isRanked)
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
