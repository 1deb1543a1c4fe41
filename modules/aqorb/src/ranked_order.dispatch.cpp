// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "precomp.hpp"

#include "ranked_order.hpp"

#include "ranked_order.simd.hpp"
#include "ranked_order.simd_declarations.hpp"

#include <cfloat>

namespace cv
{
namespace aqorb
{

namespace
{

const int FRACTION_BITS = 24, TABLE_BITS = 26, SIZE_BITS = 12;

struct LogarithmTable
{
    LogarithmTable();
    int values[(1 << SIZE_BITS) + 1];  // floor(2^TABLE_BITS log2(1 + i / 2^SIZE_BITS))
};

const LogarithmTable& logarithmTable()
{
    static const LogarithmTable table;
    return table;
}

LogarithmTable::LogarithmTable()
{
    const int SIZE = 1 << SIZE_BITS;
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
        values[i] = logarithm;
    }
    values[SIZE] = 1 << TABLE_BITS;
}

// log2(v) in units of 2^-24, for v > 0 and finite. It is computed in integers, so it is the same on every CPU.
inline int64 logarithm(const LogarithmTable& table, float v)
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
    const int64 low = table.values[i], high = table.values[i + 1];
    return int64(exponent) * (1 << FRACTION_BITS) +
           ((low * (1 << STEP_BITS) + (high - low) * step) >> (STEP_BITS + TABLE_BITS - FRACTION_BITS));
}

}  // namespace

void LeafDisc::reset(const Size& cell, int64 squaredRadius, int side)
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

static void flagRow(const int* keys, ptrdiff_t stride, int side, uchar* flags)
{
    CV_CPU_DISPATCH(flagRepresentatives, (keys, stride, side, flags), CV_CPU_DISPATCH_MODES_ALL);
}

void representativeLeaves(const std::vector<int>& keys, int side, std::vector<uchar>& flags,
                          std::vector<unsigned>& leaves)
{
    const int stride = side + 2, AT_ONCE = int(sizeof(uint64));
    flags.assign(alignSize(size_t(side), AT_ONCE), uchar(0));
    leaves.resize(size_t(side) * side);
    size_t count = 0;
    for (int row = 0; row < side; row++)
    {
        flagRow(&keys[size_t(row + 1) * stride + 1], stride, side, flags.data());
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

void leafRanks(const unsigned* leaves, size_t count, int depth, const LeafDisc& disc, RankedScratch& scratch,
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

// By row and column: how many leaves of the row before the column are usable. A leaf with a representative counts as
// usable even if its centre is masked.
static void countUsable(const std::vector<uchar>& usable, int depth, RankedScratch& scratch)
{
    const int side = 1 << depth;
    std::vector<int>& usableBefore = scratch.usableBefore;
    usableBefore.clear();
    if (usable.empty())
        return;
    usableBefore.assign(size_t(side + 1) * side, 0);
    for (unsigned leaf : scratch.leaves)
        usableBefore[size_t(leaf >> depth) * (side + 1) + (leaf & (side - 1)) + 1] = 1;
    for (int row = 0; row < side; row++)
    {
        int* before = &usableBefore[size_t(row) * (side + 1)];
        for (int column = 0; column < side; column++)
            before[column + 1] = before[column] + (before[column + 1] || usable[size_t(row) * side + column]);
    }
}

// Where all leaves are usable, by column and by dy >= 0: the leaves in the rows 0 .. dy of the disc around a leaf of the
// column that lie in the grid.
static void countInside(int side, RankedScratch& scratch)
{
    scratch.inside.clear();
    for (int column = 0; column < side; column++)
    {
        int inside = 0;
        for (int halfWidth : scratch.disc.halfWidths)
        {
            inside += std::min(column + halfWidth + 1, side) - std::max(column - halfWidth, 0);
            scratch.inside.push_back(inside);
        }
    }
}

// The number of usable leaves of the disc around a leaf.
static int leavesInside(int column, int row, int side, const RankedScratch& scratch)
{
    const std::vector<int>& halfWidths = scratch.disc.halfWidths;
    const int reach = int(halfWidths.size()) - 1;
    if (scratch.usableBefore.empty())
    {
        const int* const inside = &scratch.inside[size_t(column) * (reach + 1)];
        return inside[std::min(row, reach)] + inside[std::min(side - 1 - row, reach)] - inside[0];
    }
    int inside = 0;
    for (int y = std::max(row - reach, 0); y <= std::min(row + reach, side - 1); y++)
    {
        const int halfWidth = halfWidths[std::abs(y - row)];
        const int* const before = &scratch.usableBefore[size_t(y) * (side + 1)];
        inside += before[std::min(column + halfWidth + 1, side)] - before[std::max(column - halfWidth, 0)];
    }
    return inside;
}

// The disc around leaves, for a region of any size.
static void beginDisc(const RankRule& rule, int depth, LeafDisc& disc)
{
    Size region = rule.size;
    while (std::max(region.width, region.height) > 1 << 18)  // so that squares fit
        region = Size(std::max(region.width / 2, 1), std::max(region.height / 2, 1));
    const double squaredRadius = rule.radius * rule.radius * rule.usable * region.width * region.height *
                                 double(int64(1) << (2 * depth)) / rule.quota;
    disc.reset(region, int64(std::min(squaredRadius, 4e18)), 1 << depth);
}

// What the strength contributes to the logarithm of (1 + rank) / strength^weight, in units of 2^-42. A strength of 0 or
// infinity exceeds what any other strength and any rank contribute.
static int64 strengthPart(const LogarithmTable& table, float strength, int64 exponent)
{
    const int64 BEYOND_RANKS = int64(1) << 50, BEYOND_LOGARITHMS = int64(150) << 24;
    if (exponent == 0)
        return 0;
    if (strength > 0 && !cvIsInf(strength))
        return -exponent * logarithm(table, strength);
    return (strength > 0 ? -1 : 1) * (exponent * BEYOND_LOGARITHMS + BEYOND_RANKS);
}

void orderRepresentatives(const std::vector<unsigned>& leavesGiven, const std::vector<float>& strengths,
                          int power, int depth, const std::vector<uchar>& usable, const RankRule& rule,
                          RankedScratch& scratch, std::vector<unsigned>& order)
{
    CV_TRACE_FUNCTION();
    const int side = 1 << depth;
    const size_t size = strengths.size();
    std::vector<unsigned>&byStrength = scratch.byStrength, &leaves = scratch.leaves;
    scratch.keys.resize(size);
    for (size_t i = 0; i < size; i++)
        scratch.keys[i] = descendingKey(sortKey(strengths[i]));
    sortIndices(scratch.keys, scratch.sorting, byStrength);
    leaves.resize(size);
    for (size_t i = 0; i < size; i++)
        leaves[i] = leavesGiven[byStrength[i]];
    countUsable(usable, depth, scratch);
    beginDisc(rule, depth, scratch.disc);
    countInside(side, scratch);
    scratch.ranks.resize(size);
    leafRanks(leaves.data(), size, depth, scratch.disc, scratch, scratch.ranks.data());

    const LogarithmTable& table = logarithmTable();
    const int64 exponent = cvRound(rule.strengthWeight * (1 << 16)) * (4 / power);
    for (size_t i = 0; i < size; i++)
    {
        const int64 inside =
            leavesInside(int(leaves[i]) & (side - 1), int(leaves[i] >> depth), side, scratch);
        const int64 ofRank = logarithm(table, float(inside + scratch.ranks[i] * scratch.disc.total)) -
                             logarithm(table, float(inside));
        const int64 key = ofRank * (1 << 18) + strengthPart(table, strengths[byStrength[i]], exponent);
        scratch.keys[i] = uint64(key) ^ uint64(1) << 63;  // without a sign, in the same order
    }
    sortIndices(scratch.keys, scratch.sorting, order);
    for (unsigned& index : order)
        index = byStrength[index];
}

void orderOthers(const std::vector<LeafPoint>& points, const std::vector<unsigned>& representatives,
                 RankedScratch& scratch, std::vector<unsigned>& others)
{
    CV_TRACE_FUNCTION();
    const size_t size = points.size();
    std::vector<uint64>& keys = scratch.keys;
    keys.resize(size);
    for (size_t i = 0; i < size; i++)
        keys[i] = uint64(points[i].leaf) << 32 | descendingKey(points[i].key);
    sortIndices(keys, scratch.sorting, scratch.sorted);
    for (size_t i = 0, place = 0; i < size; i++)
    {
        const unsigned point = scratch.sorted[i];
        place = i > 0 && points[scratch.sorted[i - 1]].leaf == points[point].leaf ? place + 1 : 0;
        keys[point] = uint64(place) << 32 | descendingKey(points[point].key);
    }
    scratch.flags.assign(size, uchar(0));
    for (unsigned point : representatives)
        scratch.flags[point] = 1;
    sortIndices(keys, scratch.sorting, others);
    const auto represents = [&](unsigned point) { return scratch.flags[point] != 0; };
    others.erase(std::remove_if(others.begin(), others.end(), represents), others.end());
}

void rankedOrder(const std::vector<LeafPoint>& points, int depth, const RankRule& rule,
                 RankedScratch& scratch, std::vector<unsigned>& order)
{
    const std::vector<unsigned>& representatives = scratch.representatives.points;
    const auto pointAt = [&](size_t i) { return points[i]; };
    findRepresentatives(points.size(), pointAt, depth, scratch, scratch.representatives);
    scratch.strengths.clear();
    for (unsigned point : representatives)
        scratch.strengths.push_back(valueOf(points[point].key));
    orderRepresentatives(scratch.representatives.leaves, scratch.strengths, 1, depth, std::vector<uchar>(),
                         rule, scratch, order);
    for (unsigned& index : order)
        index = representatives[index];
    orderOthers(points, representatives, scratch, scratch.others);
    order.insert(order.end(), scratch.others.begin(), scratch.others.end());
}

int64 binaryLogarithm(float v)
{
    return logarithm(logarithmTable(), v);
}

}  // namespace aqorb
}  // namespace cv
