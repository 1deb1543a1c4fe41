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
    isCutShort = false;
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

// Strengths of 0 or infinity lie far outside of the range of others.
static const int64 LAST_KEY = int64(1) << 61;

// The key of a representative is the logarithm of (1 + rank * leaves / leavesInside) / strength^weight, in units of 2^-42.
struct RankedSequence::KeyRule
{
    int64 ofRank(int rank, int64 leavesInside) const
    {
        return (logarithm(float(leavesInside + rank * leaves)) - logarithm(float(leavesInside))) * (1 << 18);
    }
    int64 ofStrength(float strength) const
    {
        if (exponent == 0)
            return 0;
        if (strength > 0 && !cvIsInf(strength))
            return -exponent * logarithm(strength);
        return strength > 0 ? -LAST_KEY : LAST_KEY;
    }

    const BinaryLogarithm& logarithm;
    int64 leaves;  // of the disc
    int exponent;  // of strengths, in units of 2^-18
};

void RankedSequence::rank(const RankRule& rule, int power, const std::vector<uchar>& usable, size_t enough)
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

    if (usable.empty())
        countInside();
    const KeyRule keyRule = {BinaryLogarithm::shared(), disc.total,
                             cvRound(rule.strengthWeight * (1 << 16)) * (4 / power)};
    sortByKeys(keyRule, enough);
    scratch = 0;
}

int64 RankedSequence::keyOf(size_t index, int64 ofStrength, const KeyRule& rule) const
{
    const int leaf = int(scratch->ranked[index]);
    const int inside = leavesInside(leaf & ((1 << depth) - 1), leaf >> depth);
    return rule.ofRank(scratch->ranks[index], inside) + ofStrength;
}

// Lists the representatives that may have one of the least keys, and returns a bound: those with greater keys are left out.
int64 RankedSequence::findCandidates(const KeyRule& rule, size_t enough)
{
    const std::vector<int>& ranks = scratch->ranks;
    const size_t size = ranks.size(), FEW = 256, BLOCK = 8;
    std::vector<unsigned>& candidates = scratch->candidates;
    candidates.resize(size);
    std::iota(candidates.begin(), candidates.end(), 0u);
    if (size <= FEW || enough >= size / 4 * 3)
        return std::numeric_limits<int64>::max();

    // The first representative of each block is a sample. It tells which bound the keys of about enough of all do not exceed.
    std::vector<int64>&ofBlocks = scratch->strengthsOfBlocks, &keys = scratch->keysOfBlocks;
    ofBlocks.clear();
    keys.clear();
    for (size_t i = 0; i < size; i += BLOCK)
    {
        ofBlocks.push_back(rule.ofStrength(scratch->strengths[scratch->byStrength[i]]));
        keys.push_back(keyOf(i, ofBlocks.back(), rule));
    }
    std::nth_element(keys.begin(), keys.begin() + enough / BLOCK, keys.end());
    const int64 greatestKey = keys[enough / BLOCK];

    // Ranks are scaled up where a part of the disc does not count, so these are the least parts of ranks in keys.
    const int RANKS = 32;
    int64 ofRanks[RANKS];
    for (int i = 0; i < RANKS; i++)
        ofRanks[i] = rule.ofRank(i, rule.leaves);
    // The first representative is the strongest one of its block. It tells how many ranks, from 0 on, are low enough there.
    const int64 SLACK = int64(1) << 24;  // more than what rounding adds to the difference of two keys
    int lowRanks = RANKS;
    size_t count = 0;
    for (size_t first = 0; first < size; first += BLOCK)
    {
        while (lowRanks > 0 && ofRanks[lowRanks - 1] - SLACK > greatestKey - ofBlocks[first / BLOCK])
            lowRanks--;
        for (size_t i = first; i < std::min(first + BLOCK, size); i++)
        {
            candidates[count] = unsigned(i);
            count += std::min(ranks[i], RANKS - 1) < lowRanks;
        }
    }
    candidates.resize(count);
    return greatestKey;
}

void RankedSequence::sortByKeys(const KeyRule& rule, size_t enough)
{
    const int64 greatestKey = findCandidates(rule, enough);
    const std::vector<unsigned>& byStrength = scratch->byStrength;
    std::vector<unsigned>& candidates = scratch->candidates;
    std::vector<uint64>& numbers = scratch->numbers;
    numbers.resize(candidates.size());
    // The numbers order keys as the keys themselves do.
    const auto numberOf = [](int64 key) { return uint64(key) ^ uint64(1) << 63; };
    int64 least = LAST_KEY, greatest = -LAST_KEY;  // without those of strengths of 0 or infinity
    size_t count = 0;
    for (unsigned candidate : candidates)
    {
        const int64 key = keyOf(candidate, rule.ofStrength(scratch->strengths[byStrength[candidate]]), rule);
        if (key > greatestKey)
            continue;
        if (std::abs(key) < LAST_KEY / 2)
        {
            least = std::min(least, key);
            greatest = std::max(greatest, key);
        }
        candidates[count] = candidate;
        numbers[count++] = numberOf(key);
    }
    numbers.resize(count);
    sortIndices(numbers, numberOf(std::min(least, greatest)), numberOf(greatest), scratch->sorting,
                scratch->sorted);
    entries.resize(count);
    for (size_t i = 0; i < count; i++)
    {
        const unsigned index = byStrength[candidates[scratch->sorted[i]]];
        entries[i].point = scratch->points[index];
        entries[i].response = scratch->responses[index];
    }
    isCutShort = count < scratch->ranks.size();
}

// Of the disc around a leaf, the number of leaves in the rows above its own that lie inside of the region depends on the
// column and on the number of rows alone. The table holds it by column, then by number of rows. The rows below are alike.
// Columns whose discs reach neither border are like the first such column, and are left out.
void RankedSequence::countInside()
{
    const std::vector<int>& halfWidths = scratch->disc.halfWidths;
    const int side = 1 << depth, widest = scratch->disc.widest, columns = std::min(side, 2 * widest + 1);
    const size_t rows = halfWidths.size();
    scratch->inside.resize(columns * rows);
    for (int i = 0; i < columns; i++)
    {
        const int left = std::min(i, widest), right = std::min(columns - 1 - i, widest);
        int* const inside = &scratch->inside[i * rows];
        inside[0] = 0;
        for (size_t dy = 1; dy < rows; dy++)
            inside[dy] =
                inside[dy - 1] + std::min(halfWidths[dy], left) + std::min(halfWidths[dy], right) + 1;
    }
}

// The number of usable leaves of the disc around a leaf.
int RankedSequence::leavesInside(int column, int row) const
{
    const std::vector<int>&halfWidths = scratch->disc.halfWidths, &usableBefore = scratch->usableBefore;
    const int side = 1 << depth, reach = int(halfWidths.size()) - 1;
    const int above = std::min(row, reach), below = std::min(side - 1 - row, reach);
    if (usableBefore.empty())
    {
        const int widest = scratch->disc.widest, columns = std::min(side, 2 * widest + 1);
        const int like = std::min(column, std::max(widest, column - (side - columns)));
        const int* const inside = &scratch->inside[size_t(like) * (reach + 1)];
        return inside[above] + inside[below] + std::min(column, widest) +
               std::min(side - 1 - column, widest) + 1;
    }
    int inside = 0;
    for (int y = row - above; y <= row + below; y++)
    {
        const int halfWidth = halfWidths[std::abs(y - row)];
        const int begin = std::max(column - halfWidth, 0), end = std::min(column + halfWidth + 1, side);
        const int* before = &usableBefore[size_t(y) * (side + 1)];
        inside += before[end] - before[begin];
    }
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
    others.assign(byPlace.begin(), byPlace.end());
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
            if (isCutShort)
                return false;
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
