// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// The rule by which corners become keypoints, in the order of doc/selection.md: its points 2 to 6, within a level.

#include "precomp.hpp"

#include "selection.hpp"

namespace cv
{
namespace aqorb
{

// ---- 2. tree ----------------------------------------------------------------------------------

int maxRankedDepth(Size region)
{
    const int MAX_RANKED_DEPTH = 12, side = std::min(region.width, region.height);
    int depth = 0;
    while (depth < MAX_RANKED_DEPTH && (int64(4) << depth) <= side)
        depth++;
    return depth;
}

int rankedDepth(Size region, double usable, int quota)
{
    const double LEAVES_PER_POINT = 9;
    const int deepest = maxRankedDepth(region);
    int depth = 0;
    while (depth < deepest && double(int64(1) << (2 * depth)) * usable < LEAVES_PER_POINT * quota)
        depth++;
    return depth;
}

LeafGrid::LeafGrid(const Rect& region_, int depth_) : region(region_), depth(depth_)
{
    for (int x = 0; x < region.width; x++)
        columns.push_back(index(x, region.width, depth));
    for (int y = 0; y < region.height; y++)
        rows.push_back(index(y, region.height, depth) << depth);
}

Point LeafGrid::centre(unsigned leaf) const
{
    const int64 column = leaf & ((1u << depth) - 1), row = leaf >> depth;
    return region.tl() + Point(int(((2 * column + 1) * region.width) >> (depth + 1)),
                               int(((2 * row + 1) * region.height) >> (depth + 1)));
}

// ---- 3. representatives -----------------------------------------------------------------------

std::vector<unsigned> findRepresentatives(const std::vector<LeafPoint>& points, int depth,
                                          OrderScratch& scratch)
{
    const unsigned side = 1u << depth, stride = side + 2;  // the grid has a border of one leaf
    const auto inGrid = [=](unsigned leaf) { return leaf + 2 * (leaf >> depth) + stride + 1; };
    scratch.grid.assign(size_t(stride) * stride, INT_MIN);
    scratch.best.resize(scratch.grid.size());
    int* const grid = scratch.grid.data();
    unsigned* const best = scratch.best.data();
    for (size_t i = 0; i < points.size(); i++)
    {
        // Without branches, which would be hard to predict. Of equal points the first one stays.
        const unsigned leaf = inGrid(points[i].leaf);
        const bool isBetter = points[i].key > grid[leaf];
        grid[leaf] = isBetter ? points[i].key : grid[leaf];
        best[leaf] = isBetter ? unsigned(i) : best[leaf];
    }
    const int MOST_BETTER = 2;  // neighbours
    std::vector<uchar> better(side);
    std::vector<unsigned> representatives(points.size() + 1);
    size_t count = 0;
    for (unsigned row = 0; row < side; row++)
    {
        const unsigned first = inGrid(row << depth);
        countBetterNeighbors(&grid[first], ptrdiff_t(stride), int(side), better.data());
        for (unsigned column = 0; column < side; column++)
        {
            representatives[count] = best[first + column];
            count += (grid[first + column] != INT_MIN) & (better[column] <= MOST_BETTER);
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
    for (size_t i = 0; i < corners.size() && !useHarris; i++)
        responses[i] = {corners[i].x, corners[i].y, float(corners[i].score)};
    return responses;
}

// A corner whose moment is long has a well-defined direction, and is found again with the same direction.
std::vector<float> strengthsOf(const Mat& image, const std::vector<Corner>& corners,
                               const std::vector<CornerResponse>& responses, bool useHarris,
                               const OrientationPatch& patch)
{
    std::vector<FeaturePoint> points(corners.size());
    for (size_t i = 0; i < points.size(); i++)
        points[i] = {corners[i].x, corners[i].y, 0};
    std::vector<Moments> moments(points.size());
    patchMoments(image, patch, points.data(), points.size(), moments.data());
    std::vector<float> strengths(points.size());
    for (size_t i = 0; i < points.size(); i++)
    {
        const float score = float(corners[i].score), fast = score * score;
        const float harris = useHarris ? std::max(responses[i].response, 0.f) : 1.f;
        const int64 m10 = moments[i].m10, m01 = moments[i].m01;
        const float moment = float(uint64(m10 * m10) + uint64(m01 * m01)) * (1.f / 4294967296.f);
        strengths[i] = (fast * fast * harris) * (moment * moment);
    }
    return strengths;
}

// ---- 5. rank ----------------------------------------------------------------------------------

// A disc of leaves: those at offsets (dx, dy) with dx^2 width^2 + dy^2 height^2 <= squared, where a leaf is of width x
// height. The unit is 2^-depth pixels, in which a leaf is as large as the region is in pixels.
struct LeafDisc
{
    explicit LeafDisc(const RankRule& rule)
    {
        Size leaf = rule.region;
        while (std::max(leaf.width, leaf.height) > 1 << 18)  // so that squares fit
            leaf = Size(std::max(leaf.width / 2, 1), std::max(leaf.height / 2, 1));
        const double leaves = double(int64(1) << (2 * rule.depth));
        const double area = rule.usable * leaf.width * leaf.height * leaves / rule.quota;
        const int64 squared = int64(std::min(rule.radius * rule.radius * area, 4e18));
        const int64 width2 = int64(leaf.width) * leaf.width, height2 = int64(leaf.height) * leaf.height;
        int64 dx = int64(std::sqrt(double(squared))) / leaf.width + 1;  // not too small
        for (int64 dy = 0; dy < int64(1) << rule.depth && dy * dy * height2 <= squared; dy++)
        {
            while (dx * dx * width2 + dy * dy * height2 > squared)
                dx--;
            halfWidths.push_back(int(std::min<int64>(dx, (1 << rule.depth) - 1)));
        }
    }
    int width() const { return halfWidths[0]; }
    int height() const { return int(halfWidths.size()) - 1; }

    std::vector<int> halfWidths;  // by |dy|: the greatest |dx|; both below the side of the grid
};

// How many leaves before each one in the list lie within the disc around it.
static std::vector<int> countStronger(const std::vector<unsigned>& leaves, const LeafDisc& disc, int depth)
{
    const int side = 1 << depth, step = RankGrid::STEP, columns = 2 * disc.width() + 1,
              rows = 2 * disc.height() + 1;
    RankGrid grid = RankGrid();
    grid.depth = depth;
    grid.left = disc.width();
    grid.top = disc.height() + 1;
    grid.stride = (side + columns) / step + 2;
    std::vector<uint64> bits(size_t(grid.stride) * (side + rows)), masks;
    std::vector<int> words, counts(leaves.size());
    for (int y = 0; y < rows; y += 2)
    {
        for (int first = 0; first < columns; first += step)
        {
            uint64 mask = 0;
            for (int bit = 0; bit < 2 * step; bit++)
            {
                const int dx = first + bit % step - disc.width(), dy = y + bit / step - disc.height();
                if (dy <= disc.height() && std::abs(dx) <= disc.halfWidths[std::abs(dy)])
                    mask |= uint64(1) << (bit % step + bit / step * 32);
            }
            words.push_back((y + 1) * grid.stride + first / step + 1);
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

// By how much ranks are scaled up: the leaves of the square around the disc over those of them that lie inside of the
// region and are not masked. A leaf with a representative counts even if its centre is masked.
static std::vector<double> inverseSharesOf(const std::vector<unsigned>& leaves, const LeafDisc& disc,
                                           int depth, std::vector<uchar> usable)
{
    const int side = 1 << depth;
    for (size_t i = 0; i < leaves.size() && !usable.empty(); i++)
        usable[leaves[i]] = 1;
    Mat1i sums(side + 1, side + 1, 0);  // of the usable leaves above and on the left
    for (int row = 0; row < side; row++)
        for (int column = 0, sum = 0; column < side; column++)
        {
            sum += usable.empty() || usable[size_t(row) * side + column];
            sums(row + 1, column + 1) = sums(row, column + 1) + sum;
        }
    const double whole = (2. * disc.width() + 1) * (2. * disc.height() + 1);
    std::vector<double> inverses(leaves.size());
    for (size_t i = 0; i < leaves.size(); i++)
    {
        const int column = int(leaves[i]) & (side - 1), row = int(leaves[i] >> depth);
        const int left = std::max(column - disc.width(), 0),
                  right = std::min(column + disc.width() + 1, side);
        const int top = std::max(row - disc.height(), 0), bottom = std::min(row + disc.height() + 1, side);
        inverses[i] = whole / (sums(bottom, right) - sums(bottom, left) - sums(top, right) + sums(top, left));
    }
    return inverses;
}

// ---- 6. order ---------------------------------------------------------------------------------

// The binary logarithm of a positive number, in units of 2^-23 and with an error below .09: the exponent of the float,
// and its significand as the fraction. It is monotonic, and the same on every CPU.
static double binaryLogarithm(float v)
{
    Cv32suf bits;
    bits.f = v;
    return double(bits.i);
}

// The logarithm of (1 + rank) / strength^exponent. A strength of 0 or infinity exceeds what any other one and any rank
// contribute.
static int64 placeOf(double rank, float strength, double exponent)
{
    const double BEYOND_RANKS = 1 << 28;
    double key = binaryLogarithm(float(1 + rank));
    if (exponent > 0 && strength > 0)
        key -= exponent * binaryLogarithm(strength) + (cvIsInf(strength) ? BEYOND_RANKS : 0);
    else if (exponent > 0)
        key += BEYOND_RANKS;
    return int64(key * (1 << 16));
}

std::vector<unsigned> orderRepresentatives(const std::vector<unsigned>& leavesGiven,
                                           const std::vector<float>& strengths, const RankRule& rule,
                                           const std::vector<uchar>& usable)
{
    CV_TRACE_FUNCTION();
    std::vector<uint64> keys(strengths.size());
    for (size_t i = 0; i < keys.size(); i++)
        keys[i] = descendingKey(sortKey(strengths[i]));
    const std::vector<unsigned> byStrength = sortIndices(keys);
    std::vector<unsigned> leaves(byStrength.size());
    for (size_t i = 0; i < leaves.size(); i++)
        leaves[i] = leavesGiven[byStrength[i]];
    const LeafDisc disc(rule);
    const std::vector<int> ranks = countStronger(leaves, disc, rule.depth);
    const std::vector<double> inverseShares = inverseSharesOf(leaves, disc, rule.depth, usable);
    for (size_t i = 0; i < keys.size(); i++)
    {
        const int64 place = placeOf(ranks[i] * inverseShares[i], strengths[byStrength[i]], rule.exponent);
        keys[i] = uint64(place) ^ uint64(1) << 63;  // without a sign, in the same order
    }
    std::vector<unsigned> order = sortIndices(keys);
    for (unsigned& index : order)
        index = byStrength[index];
    return order;
}

std::vector<unsigned> orderOthers(const std::vector<LeafPoint>& points,
                                  const std::vector<unsigned>& representatives)
{
    CV_TRACE_FUNCTION();
    std::vector<uint64> keys;
    for (const LeafPoint& point : points)
        keys.push_back(uint64(point.leaf) << 32 | descendingKey(point.key));
    const std::vector<unsigned> byLeaf = sortIndices(keys);
    for (size_t i = 0, place = 0; i < byLeaf.size(); i++)
    {
        const LeafPoint& point = points[byLeaf[i]];
        place = i > 0 && points[byLeaf[i - 1]].leaf == point.leaf ? place + 1 : 0;
        keys[byLeaf[i]] = uint64(place) << 32 | descendingKey(point.key);
    }
    std::vector<uchar> represents(points.size());
    for (unsigned point : representatives)
        represents[point] = 1;
    std::vector<unsigned> others = sortIndices(keys);
    others.erase(
        std::remove_if(others.begin(), others.end(), [&](unsigned point) { return represents[point] != 0; }),
        others.end());
    return others;
}

// The points of corners: of a leaf the corner of the highest FAST score is the best.
static void findLeaves(const LevelPlan& plan, const std::vector<Corner>& corners,
                       std::vector<LeafPoint>& points)
{
    const LeafGrid leaves(plan.root, plan.depth);
    points.resize(corners.size());
    for (size_t i = 0; i < corners.size(); i++)
        points[i] = {leaves.leaf(corners[i].x, corners[i].y), corners[i].score};
}

// By leaf: whether its centre may have a corner; empty: they all may.
static std::vector<uchar> usableLeaves(const Mat& mask, const LevelPlan& plan)
{
    const LeafGrid leaves(plan.root, plan.depth);
    std::vector<uchar> usable;
    for (unsigned leaf = 0; !mask.empty() && leaf < 1u << (2 * plan.depth); leaf++)
        usable.push_back(mask.at<uchar>(leaves.centre(leaf)));
    return usable;
}

LevelOrder orderCorners(const Parameters& parameters, const Level& level, const LevelPlan& plan,
                        const OrientationPatch& patch, const std::vector<Corner>& corners,
                        OrderScratch& scratch)
{
    CV_TRACE_FUNCTION();
    const bool useHarris = parameters.scoreType == ORB::HARRIS_SCORE;
    LevelOrder order;
    if (parameters.selectionType == AdaptiveQuadtreeORB::BALANCED_SELECTION)
    {
        order.corners = responsesOf(level.image, corners, useHarris);
        order.indices.resize(corners.size());
        std::iota(order.indices.begin(), order.indices.end(), 0u);
        return order;
    }
    findLeaves(plan, corners, scratch.points);
    order.indices = findRepresentatives(scratch.points, plan.depth, scratch);
    std::vector<Corner> representatives(order.indices.size());
    std::vector<unsigned> leaves(order.indices.size());
    for (size_t i = 0; i < leaves.size(); i++)
    {
        representatives[i] = corners[order.indices[i]];
        leaves[i] = scratch.points[order.indices[i]].leaf;
    }
    const std::vector<CornerResponse> responses = responsesOf(level.image, representatives, useHarris);
    const RankRule rule = {plan.root.size(),      plan.depth,
                           plan.usable,           std::max(plan.quota, 1),
                           parameters.rankRadius, parameters.strengthWeight / 4};
    for (unsigned index :
         orderRepresentatives(leaves, strengthsOf(level.image, representatives, responses, useHarris, patch),
                              rule, usableLeaves(level.mask, plan)))
        order.corners.push_back(responses[index]);
    return order;
}

void appendOthers(const Parameters& parameters, const Level& level, const LevelPlan& plan,
                  const std::vector<Corner>& corners, LevelOrder& order)
{
    std::vector<LeafPoint> points;
    findLeaves(plan, corners, points);
    std::vector<Corner> others;
    for (unsigned index : orderOthers(points, order.indices))
    {
        others.push_back(corners[index]);
        order.indices.push_back(index);
    }
    const std::vector<CornerResponse> responses =
        responsesOf(level.image, others, parameters.scoreType == ORB::HARRIS_SCORE);
    order.corners.insert(order.corners.end(), responses.begin(), responses.end());
}

}  // namespace aqorb
}  // namespace cv
