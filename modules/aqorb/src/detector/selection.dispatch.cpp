// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// Selection of keypoints from corners, points 1 to 6 of doc/selection.md: the order of a level's corners.

#include "precomp.hpp"

#include "detector/selection.hpp"

#include "detector/selection.simd.hpp"
// Generated: CV_CPU_DISPATCH_MODES_ALL=AVX512_SKX, AVX2, BASELINE on x86-64.
#include "detector/selection.simd_declarations.hpp"

namespace cv
{
namespace aqorb
{

// ---- 1. quotas --------------------------------------------------------------------------------

std::vector<int> rankedQuotas(int nfeatures, const std::vector<Size>& regions,
                              const std::vector<float>& scales)
{
    std::vector<double> sums(regions.size());  // shares of a level and all coarser levels
    double sum = 0;
    for (size_t level = regions.size(); level-- > 0;)
    {
        const double scale = scales[level], area = double(regions[level].width) * regions[level].height;
        sum += (level == 0 ? 1.5 : 1.) * area * (scale * std::sqrt(std::sqrt(scale)));
        sums[level] = sum;
    }
    std::vector<int> quotas(regions.size());
    int given = 0;
    for (size_t level = regions.size(); level-- > 0;)
    {
        // Rounds the sums, so that the quotas add up to nfeatures.
        const int upToLevel = cvRound(nfeatures * (sums[level] / sum));
        quotas[level] = upToLevel - given;
        given = upToLevel;
    }
    return quotas;
}

// ---- 2. tree ----------------------------------------------------------------------------------

LeafGrid leafGrid(Size region, int trees, int depth)
{
    const bool isWide = region.width > region.height;
    LeafGrid grid = {(isWide ? trees : 1) << depth, (isWide ? 1 : trees) << depth, 0};
    while (1 << grid.columnBits < grid.columns)
        grid.columnBits++;
    return grid;
}

LeafGrid rankedGrid(Size region, double usable, int quota, double density)
{
    const double LEAVES_PER_POINT = 9 * density;
    const int MAX_LEAVES = 1 << 24;
    const int shorter = std::min(region.width, region.height), longer = std::max(region.width, region.height);
    const auto hasEnough = [&](int trees, int depth)
    { return trees * double(int64(1) << (2 * depth)) * usable >= LEAVES_PER_POINT * quota; };
    const auto depthOf = [&](int trees)
    {
        int depth = 0;
        while (int64(4) << depth <= shorter && int64(trees) << (2 * depth + 2) <= MAX_LEAVES &&
               !hasEnough(trees, depth))
            depth++;
        return depth;
    };
    const int depth = depthOf(1);
    if (hasEnough(1, depth) || int64(4) << depth <= shorter)
        return leafGrid(region, 1, depth);
    const int trees = std::max(longer / std::max(shorter, 2), 1);
    return leafGrid(region, trees, depthOf(trees));
}

// Unmasked share of the region. Counts row by row, because countNonZero returns an int.
static double usableShare(const Mat& mask, const Rect& region)
{
    if (mask.empty())
        return 1;
    double usable = 0;
    for (int y = region.y; y < region.y + region.height; y++)
        usable += countNonZero(mask.row(y).colRange(region.x, region.x + region.width));
    return usable / (double(region.width) * region.height);
}

// ---- 3. representatives -----------------------------------------------------------------------

static void countBetterNeighbors(const int* keys, ptrdiff_t stride, int count, uchar* counts)
{
    CV_CPU_DISPATCH(countBetter, (keys, stride, count, counts), CV_CPU_DISPATCH_MODES_ALL);
}

double representativeDensity(double strengthWeight)
{
    return std::max(strengthWeight / 0.15, 1.);
}

std::vector<unsigned> findRepresentatives(const std::vector<LeafPoint>& points, const LeafGrid& grid,
                                          double density)
{
    const int columnBits = grid.columnBits;
    const unsigned stride = (1u << columnBits) + 2;  // there is a border of one leaf
    const auto inKeys = [=](unsigned leaf) { return leaf + 2 * (leaf >> columnBits) + stride + 1; };
    std::vector<int> keys(stride * size_t(grid.rows + 2), INT_MIN);  // key of a leaf's best point
    std::vector<unsigned> best(keys.size());                         // index of this point
    for (size_t i = 0; i < points.size(); i++)
    {
        // No branches: the CPU cannot predict them. Of equal points the first stays.
        const unsigned leaf = inKeys(points[i].leaf);
        const bool isBetter = points[i].key > keys[leaf];
        keys[leaf] = isBetter ? points[i].key : keys[leaf];
        best[leaf] = isBetter ? unsigned(i) : best[leaf];
    }
    const double MIN_BETTER = 3 * density;  // neighbours that displace a representative
    std::vector<uchar> better(grid.columns);
    std::vector<unsigned> representatives(points.size() + 1);
    size_t count = 0;
    for (unsigned row = 0; row < unsigned(grid.rows); row++)
    {
        const unsigned first = inKeys(row << columnBits);
        countBetterNeighbors(&keys[first], ptrdiff_t(stride), grid.columns, better.data());
        for (unsigned column = 0; column < unsigned(grid.columns); column++)
        {
            representatives[count] = best[first + column];
            count += int(keys[first + column] != INT_MIN) & (better[column] < MIN_BETTER);
        }
    }
    representatives.resize(count);
    return representatives;
}

// ---- 4. strength ------------------------------------------------------------------------------

std::vector<CornerResponse> responsesOf(const Mat& image, const std::vector<Corner>& corners, bool useHarris)
{
    std::vector<CornerResponse> responses(corners.size());
    if (useHarris)
        harrisResponses(image, corners.data(), corners.size(), responses.data());
    else
        for (size_t i = 0; i < corners.size(); i++)
            responses[i] = {corners[i].x, corners[i].y, float(corners[i].score)};
    return responses;
}

OrientationPatch patchForStrength(int patchSize)
{
    const int ROWS_ABOVE = 5;  // and below the middle row; more rows give no better order
    return OrientationPatch(circularPatch(patchSize), std::max(1, patchSize / 2 / ROWS_ABOVE));
}

// The moment counts because a long moment has a well-defined direction, which other images reproduce.
std::vector<float> strengthsOf(const Mat& image, const std::vector<Corner>& corners,
                               const std::vector<CornerResponse>& responses, bool useHarris,
                               const OrientationPatch& patch)
{
    std::vector<FeaturePoint> points(corners.size());
    for (size_t i = 0; i < points.size(); i++)
        points[i] = {corners[i].x, corners[i].y, 0};
    std::vector<Moments> moments(points.size());
    patchMoments(image, patch, points.data(), points.size(), moments.data());
    const float UNIT = 1.f / 4294967296.f;  // 2^-32 keeps the product in the range of a float
    std::vector<float> strengths(points.size());
    for (size_t i = 0; i < points.size(); i++)
    {
        const float score = float(corners[i].score), fast = score * score;
        const float harris = useHarris ? std::max(responses[i].response, 0.f) : 1.f;
        const int64 m10 = moments[i].m10, m01 = moments[i].m01;
        const float moment = float(uint64(m10 * m10) + uint64(m01 * m01)) * UNIT;
        strengths[i] = (fast * fast * harris) * (moment * moment);
    }
    return strengths;
}

// ---- 5. rank ----------------------------------------------------------------------------------

// Disc of leaves: offsets (dx, dy) of all leaves with centres within the radius.
struct LeafDisc
{
    explicit LeafDisc(const RankRule& rule)
    {
        const double width = double(rule.region.width) / rule.grid.columns,
                     height = double(rule.region.height) / rule.grid.rows;
        // Features of a narrow region lie in a row. The disc then spans the length of the row that has the disc's area.
        const double area = rule.usable * rule.region.width * rule.region.height / rule.quota;
        const double inRow =
            CV_PI / 2 * rule.radius * rule.radius * area / std::min(rule.region.width, rule.region.height);
        const double squared = std::max(rule.radius * rule.radius * area, inRow * inRow);
        const auto product = [](int d, double length) { return double(d) * d * (length * length); };
        int dx = rule.grid.columns - 1;
        for (int dy = 0; dy < rule.grid.rows && product(dy, height) <= squared; dy++)
        {
            while (product(dx, width) + product(dy, height) > squared)
                dx--;
            halfWidths.push_back(dx);
        }
    }
    int width() const { return halfWidths[0]; }
    int height() const { return int(halfWidths.size()) - 1; }

    std::vector<int> halfWidths;  // the greatest |dx| for each |dy|, both smaller than the grid
};

static void countLeavesBefore(const RankGrid& grid, const unsigned* leaves, size_t count, int* counts)
{
    CV_CPU_DISPATCH(countBefore, (grid, leaves, count, counts), CV_CPU_DISPATCH_MODES_ALL);
}

// Counts, for each leaf, the earlier leaves of the list within the disc around it.
static std::vector<int> countStronger(const std::vector<unsigned>& leaves, const LeafDisc& disc,
                                      const LeafGrid& tree)
{
    const int step = RankGrid::STEP, columns = 2 * disc.width() + 1, rows = 2 * disc.height() + 1;
    RankGrid grid = RankGrid();
    grid.columnBits = tree.columnBits;
    grid.left = disc.width();
    grid.top = disc.height();
    grid.stride = (tree.columns + columns) / step + 2;
    std::vector<uint64> bits(size_t(grid.stride) * (tree.rows + rows)), masks;
    std::vector<int> words, counts(leaves.size());
    for (int y = 0; y < rows; y++)
    {
        for (int first = 0; first < columns; first += step)
        {
            uint64 mask = 0;
            for (int bit = 0; bit < step; bit++)
            {
                const int dx = first + bit - disc.width(), dy = y - disc.height();
                if (std::abs(dx) <= disc.halfWidths[std::abs(dy)])
                    mask |= uint64(1) << bit;
            }
            words.push_back(y * grid.stride + first / step + 1);
            masks.push_back(mask);
        }
    }
    grid.bits = bits.data();
    grid.words = words.data();
    grid.masks = masks.data();
    grid.wordCount = int(words.size());
    countLeavesBefore(grid, leaves.data(), leaves.size(), counts.data());
    return counts;
}

// Factors that scale ranks up: number of leaves in the square around the disc, over the number of unmasked leaves in it
// and in the region. A leaf with a representative counts even if its centre is masked.
static std::vector<double> inverseSharesOf(const std::vector<unsigned>& leaves, const LeafDisc& disc,
                                           const LeafGrid& grid, const std::vector<uchar>& usable)
{
    Mat1b counted(grid.rows, grid.columns, 1);
    for (int row = 0; row < grid.rows && !usable.empty(); row++)
        for (int column = 0; column < grid.columns; column++)
            counted(row, column) = usable[grid.numberOf(column, row)] != 0;
    for (unsigned leaf : leaves)
        counted(grid.rowOf(leaf), grid.columnOf(leaf)) = 1;
    Mat1i sums;  // integral image of the leaves
    integral(counted, sums, CV_32S);
    const double whole = (2. * disc.width() + 1) * (2. * disc.height() + 1);
    std::vector<double> inverses(leaves.size());
    for (size_t i = 0; i < leaves.size(); i++)
    {
        const int column = grid.columnOf(leaves[i]), row = grid.rowOf(leaves[i]);
        const int left = std::max(column - disc.width(), 0),
                  right = std::min(column + disc.width() + 1, grid.columns);
        const int top = std::max(row - disc.height(), 0),
                  bottom = std::min(row + disc.height() + 1, grid.rows);
        inverses[i] = whole / (sums(bottom, right) - sums(bottom, left) - sums(top, right) + sums(top, left));
    }
    return inverses;
}

// ---- 6. order ---------------------------------------------------------------------------------

// Binary logarithm of a positive number plus 127, in units of 2^-23, with an error below .09: the bits of the float,
// with its exponent as the whole part and its significand as the fraction. Positive, monotonic, and the same on every
// CPU.
static double binaryLogarithm(float v)
{
    Cv32suf bits;
    bits.f = v;
    return double(bits.i);
}

// Logarithm of (1 + rank) / strength^exponent. Representatives without strength come last.
static int64 orderKey(double rank, float strength, double exponent)
{
    const double BEYOND_RANKS = 1 << 29;
    double key = binaryLogarithm(float(1 + rank));
    key += strength > 0 ? -exponent * binaryLogarithm(strength) : BEYOND_RANKS;
    return int64(key * (1 << 16));
}

std::vector<unsigned> orderRepresentatives(const std::vector<unsigned>& leavesGiven,
                                           const std::vector<float>& strengths, const RankRule& rule,
                                           const std::vector<uchar>& usableLeaves)
{
    CV_TRACE_FUNCTION();
    std::vector<uint64> keys(strengths.size());
    for (size_t i = 0; i < keys.size(); i++)
        keys[i] = descendingKey(sortKey(strengths[i]));
    const std::vector<unsigned> strengthOrder = sortIndices(keys);
    std::vector<unsigned> leaves(strengthOrder.size());
    for (size_t i = 0; i < leaves.size(); i++)
        leaves[i] = leavesGiven[strengthOrder[i]];
    const LeafDisc disc(rule);
    const std::vector<int> ranks = countStronger(leaves, disc, rule.grid);
    const std::vector<double> inverseShares = inverseSharesOf(leaves, disc, rule.grid, usableLeaves);
    for (size_t i = 0; i < keys.size(); i++)
    {
        const int64 place = orderKey(ranks[i] * inverseShares[i], strengths[strengthOrder[i]], rule.exponent);
        keys[i] = uint64(place) ^ uint64(1) << 63;  // unsigned, in the same order
    }
    std::vector<unsigned> order = sortIndices(keys);
    for (unsigned& index : order)
        index = strengthOrder[index];
    return order;
}

// Whether the centre of each leaf is unmasked; empty: all are.
static std::vector<uchar> findUsableLeaves(const Mat& mask, const Rect& region, const LeafGrid& grid)
{
    std::vector<uchar> usable(mask.empty() ? 0 : grid.numbers());
    const auto centerOf = [](int index, int count, int length)
    { return int((2 * int64(index) + 1) * length / (2 * count)); };
    for (int row = 0; row < grid.rows && !mask.empty(); row++)
    {
        const uchar* const maskRow = mask.ptr(region.y + centerOf(row, grid.rows, region.height));
        for (int column = 0; column < grid.columns; column++)
            usable[grid.numberOf(column, row)] =
                maskRow[region.x + centerOf(column, grid.columns, region.width)];
    }
    return usable;
}

std::vector<CornerResponse> rankedOrder(const Parameters& parameters, const OrientationPatch& patch,
                                        const LevelPlan& plan, const Level& level,
                                        const std::vector<Corner>& corners)
{
    CV_TRACE_FUNCTION();
    const Size region = plan.region.size();
    const int quota = std::max(plan.quota, 1);
    const double usable = usableShare(level.mask, plan.region);
    const double density = representativeDensity(parameters.strengthWeight);
    const LeafGrid grid = rankedGrid(region, usable, quota, density);
    // Leaf numbers of the first row and of the first column: a division for each corner takes longer.
    std::vector<unsigned> inFirstRow, inFirstColumn;
    for (int x = 0; x < region.width; x++)
        inFirstRow.push_back(leafOf(x, 0, region, grid));
    for (int y = 0; y < region.height; y++)
        inFirstColumn.push_back(leafOf(0, y, region, grid));
    std::vector<LeafPoint> points(corners.size());
    for (size_t i = 0; i < corners.size(); i++)
        points[i] = {inFirstRow[corners[i].x - plan.region.x] | inFirstColumn[corners[i].y - plan.region.y],
                     corners[i].score};
    std::vector<Corner> representatives;
    std::vector<unsigned> leaves;
    for (unsigned index : findRepresentatives(points, grid, density))
    {
        representatives.push_back(corners[index]);
        leaves.push_back(points[index].leaf);
    }
    const std::vector<CornerResponse> responses =
        responsesOf(level.image, representatives, parameters.useHarris());
    const std::vector<float> strengths =
        strengthsOf(level.image, representatives, responses, parameters.useHarris(), patch);
    const RankRule rule = {region, grid, usable, quota, parameters.rankRadius, parameters.strengthWeight / 4};
    std::vector<CornerResponse> ordered;
    for (unsigned index :
         orderRepresentatives(leaves, strengths, rule, findUsableLeaves(level.mask, plan.region, grid)))
        ordered.push_back(responses[index]);
    return ordered;
}

}  // namespace aqorb
}  // namespace cv
