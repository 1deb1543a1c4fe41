// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// The rule by which corners become keypoints, in the order of doc/selection.md: its points 1 to 6, up to
// the order in which a level offers its corners.

#include "precomp.hpp"

#include "selection.hpp"

namespace cv
{
namespace aqorb
{

// ---- 1. quotas --------------------------------------------------------------------------------

std::vector<int> rankedQuotas(int nfeatures, const std::vector<Size>& regions,
                              const std::vector<float>& scales)
{
    std::vector<double> sums(regions.size());  // of the shares of a level and of the coarser ones
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
        // The sums are rounded, so that the quotas add up.
        const int upToLevel = cvRound(nfeatures * (sums[level] / sum));
        quotas[level] = upToLevel - given;
        given = upToLevel;
    }
    return quotas;
}

// The share of the region that the mask does not exclude. Rows are counted one by one, because countNonZero counts by
// int.
static double usableShare(const Mat& mask, const Rect& region)
{
    if (mask.empty())
        return 1;
    double usable = 0;
    for (int y = region.y; y < region.y + region.height; y++)
        usable += countNonZero(mask.row(y).colRange(region.x, region.x + region.width));
    return usable / (double(region.width) * region.height);
}

std::vector<LevelPlan> planLevels(const Parameters& parameters, const std::vector<Level>& levels)
{
    const bool isRanked = parameters.selectionType == AdaptiveQuadtreeORB::RANKED_SELECTION;
    std::vector<LevelPlan> plans;
    std::vector<Size> regions;
    std::vector<float> scales;
    for (const Level& level : levels)
    {
        const Rect root = parameters.keypointRegion(level.image.size());
        plans.push_back({root, 0, usableShare(level.mask, root), 0});
        regions.push_back(root.size());
        scales.push_back(level.scale);
    }
    const std::vector<int> quotas =
        isRanked ? rankedQuotas(parameters.nfeatures, regions, scales)
                 : balancedQuotas(parameters.nfeatures, parameters.scaleFactor, parameters.nlevels);
    for (size_t i = 0; i < plans.size(); i++)
    {
        plans[i].quota = quotas[i];
        plans[i].depth = isRanked ? rankedDepth(regions[i], plans[i].usable, std::max(quotas[i], 1))
                                  : balancedDepth(quotas[i]);
    }
    // The paper's quotas include those of levels too small for a keypoint, which go to the last level that is not.
    if (!plans.empty())
        plans.back().quota = std::accumulate(quotas.begin() + plans.size() - 1, quotas.end(), 0);
    return plans;
}

// ---- 2. tree ----------------------------------------------------------------------------------

int rankedDepth(Size region, double usable, int quota)
{
    const double LEAVES_PER_POINT = 9;
    const int DEEPEST = 12;
    int depth = 0;
    while (depth < DEEPEST && int64(4) << depth <= std::min(region.width, region.height) &&
           double(int64(1) << (2 * depth)) * usable < LEAVES_PER_POINT * quota)
        depth++;
    return depth;
}

// ---- 3. representatives -----------------------------------------------------------------------

std::vector<unsigned> findRepresentatives(const std::vector<LeafPoint>& points, int depth)
{
    const unsigned side = 1u << depth, stride = side + 2;  // the grid has a border of one leaf
    const auto inGrid = [=](unsigned leaf) { return leaf + 2 * (leaf >> depth) + stride + 1; };
    std::vector<int> grid(size_t(stride) * stride, INT_MIN);  // the key of the best point of a leaf
    std::vector<unsigned> best(grid.size());                  // that point
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
            count += int(grid[first + column] != INT_MIN) & (better[column] <= MOST_BETTER);
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
    return OrientationPatch(circularPatch(patchSize), std::max(1, patchSize / 2 / 5));
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

// A disc of leaves: those at offsets (dx, dy) whose centres are within the radius.
struct LeafDisc
{
    explicit LeafDisc(const RankRule& rule)
    {
        const int side = 1 << rule.depth;
        const double width = double(rule.region.width) / side, height = double(rule.region.height) / side;
        const double squared =
            rule.radius * rule.radius * rule.usable * rule.region.width * rule.region.height / rule.quota;
        int dx = side - 1;
        for (int dy = 0; dy < side && dy * dy * (height * height) <= squared; dy++)
        {
            while (dx * dx * (width * width) + dy * dy * (height * height) > squared)
                dx--;
            halfWidths.push_back(dx);
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
    grid.top = disc.height();
    grid.stride = (side + columns) / step + 2;
    std::vector<uint64> bits(size_t(grid.stride) * (side + rows)), masks;
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

// By how much ranks are scaled up: the leaves of the square around the disc over those of them that lie inside of the
// region and are not masked. A leaf with a representative counts even if its centre is masked.
static std::vector<double> inverseSharesOf(const std::vector<unsigned>& leaves, const LeafDisc& disc,
                                           int depth, const std::vector<uchar>& usable)
{
    const int side = 1 << depth;
    Mat1b counted(side, side, 1);
    for (size_t leaf = 0; leaf < usable.size(); leaf++)
        counted(int(leaf)) = usable[leaf] != 0;
    for (unsigned leaf : leaves)
        counted(int(leaf)) = 1;
    Mat1i sums;  // of the leaves above and on the left
    integral(counted, sums, CV_32S);
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

// 127 more than the binary logarithm of a positive number, in units of 2^-23 and with an error below .09: the exponent
// of the float as it is stored, and its significand as the fraction. It is positive, monotonic, and the same on every
// CPU.
static double binaryLogarithm(float v)
{
    Cv32suf bits;
    bits.f = v;
    return double(bits.i);
}

// The logarithm of (1 + rank) / strength^exponent. What has no strength comes last.
static int64 placeOf(double rank, float strength, double exponent)
{
    const double BEYOND_RANKS = 1 << 29;
    double key = binaryLogarithm(float(1 + rank));
    key += strength > 0 ? -exponent * binaryLogarithm(strength) : BEYOND_RANKS;
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

// By leaf: whether its centre may have a corner; empty: they all may.
static std::vector<uchar> usableLeaves(const Mat& mask, const LevelPlan& plan)
{
    std::vector<uchar> usable;
    if (mask.empty())
        return usable;
    for (unsigned leaf = 0; leaf < 1u << (2 * plan.depth); leaf++)
    {
        const int64 column = leaf & ((1u << plan.depth) - 1), row = leaf >> plan.depth;
        usable.push_back(
            mask.at<uchar>(plan.root.y + int((2 * row + 1) * plan.root.height >> (plan.depth + 1)),
                           plan.root.x + int((2 * column + 1) * plan.root.width >> (plan.depth + 1))));
    }
    return usable;
}

std::vector<CornerResponse> orderCorners(const Parameters& parameters, const Level& level,
                                         const LevelPlan& plan, const OrientationPatch& patch,
                                         const std::vector<Corner>& corners)
{
    CV_TRACE_FUNCTION();
    const bool useHarris = parameters.scoreType == ORB::HARRIS_SCORE;
    if (parameters.selectionType == AdaptiveQuadtreeORB::BALANCED_SELECTION)
        return balancedCorners(plan, responsesOf(level.image, corners, useHarris));
    std::vector<LeafPoint> points(corners.size());
    for (size_t i = 0; i < corners.size(); i++)
        points[i] = {
            leafOf(corners[i].x - plan.root.x, corners[i].y - plan.root.y, plan.root.size(), plan.depth),
            corners[i].score};
    std::vector<Corner> representatives;
    std::vector<unsigned> leaves;
    for (unsigned index : findRepresentatives(points, plan.depth))
    {
        representatives.push_back(corners[index]);
        leaves.push_back(points[index].leaf);
    }
    const std::vector<CornerResponse> responses = responsesOf(level.image, representatives, useHarris);
    const RankRule rule = {plan.root.size(),      plan.depth,
                           plan.usable,           std::max(plan.quota, 1),
                           parameters.rankRadius, parameters.strengthWeight / 4};
    std::vector<CornerResponse> ordered;
    for (unsigned index :
         orderRepresentatives(leaves, strengthsOf(level.image, representatives, responses, useHarris, patch),
                              rule, usableLeaves(level.mask, plan)))
        ordered.push_back(responses[index]);
    return ordered;
}

}  // namespace aqorb
}  // namespace cv
