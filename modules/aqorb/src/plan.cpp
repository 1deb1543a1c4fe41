// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "precomp.hpp"

#include "plan.hpp"

namespace cv
{
namespace aqorb
{

int shortestSide(const Parameters& parameters)
{
    const int FAST_RADIUS = 3;
    return int(std::min(2 * std::max<int64>(parameters.edgeThreshold, FAST_RADIUS) + 1, int64(INT_MAX)));
}

Rect keypointRegion(const Parameters& parameters, Size size)
{
    const int border = parameters.edgeThreshold;
    return Rect(border, border, size.width - 2 * border, size.height - 2 * border);
}

double suppressionRadius(const Parameters& parameters)
{
    if (parameters.octaveSuppression >= 0)
        return parameters.octaveSuppression;
    // Who asks for the strongest corners takes them on every level, as with cv::ORB.
    return parameters.selectionType == AdaptiveQuadtreeORB::BALANCED_SELECTION
               ? 0.5
               : 2.1 / (1 + parameters.strengthWeight);
}

// Takes what is too much from the finest levels, which have the most to give up.
static void takeExcess(int64 excess, std::vector<int>& quotas)
{
    for (size_t level = 0; excess > 0; level++)
    {
        const int taken = int(std::min<int64>(excess, quotas[level]));
        quotas[level] -= taken;
        excess -= taken;
    }
}

std::vector<int> levelQuotas(int nfeatures, double scaleFactor, int nlevels)
{
    const float factor = float(1.0 / scaleFactor);
    float desired = factor == 1  // rounded to a float, where scaleFactor is hardly more than 1
                        ? float(nfeatures) / nlevels
                        : nfeatures * (1 - factor) / (1 - float(std::pow(double(factor), double(nlevels))));
    const float LARGEST_INT = 2147483520.f;  // the largest int that a float can hold
    std::vector<int> quotas(nlevels);
    int64 sum = 0;
    for (int level = 0; level < nlevels - 1; level++)
    {
        quotas[level] = cvRound(std::min(desired, LARGEST_INT));
        sum += quotas[level];
        desired *= factor;
    }
    quotas[nlevels - 1] = int(std::max<int64>(nfeatures - sum, 0));
    // The rounding of cv::ORB can ask for more than nfeatures.
    takeExcess(sum + quotas[nlevels - 1] - nfeatures, quotas);
    return quotas;
}

void rankedQuotas(int nfeatures, const std::vector<LevelRegion>& regions, std::vector<int>& quotas)
{
    const auto shareOf = [&](size_t level)
    {
        const LevelRegion& region = regions[level];
        const double scale = region.scale, area = double(region.size.width) * region.size.height;
        return (level == 0 ? 1.5 : 1.) * area * (scale * std::sqrt(std::sqrt(scale)));
    };
    double whole = 0;
    for (size_t level = 0; level < regions.size(); level++)
        whole += shareOf(level);
    quotas.assign(regions.size(), 0);
    int64 rest = nfeatures;
    for (size_t level = 1; level < regions.size(); level++)
    {
        quotas[level] = cvRound(nfeatures * (shareOf(level) / whole));
        rest -= quotas[level];
    }
    if (!regions.empty())
        quotas[0] = int(std::max<int64>(rest, 0));
    takeExcess(-rest, quotas);  // where many levels round up
}

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
    const double LEAVES_PER_POINT = 9;
    const int deepest = maxRankedDepth(size);
    int depth = 0;
    while (depth < deepest && double(int64(1) << (2 * depth)) * usable < LEAVES_PER_POINT * quota)
        depth++;
    return depth;
}

LevelPlan planLevel(const Parameters& parameters, const Level& level, int quota, int added)
{
    LevelPlan plan = LevelPlan();
    plan.size = level.image.size();
    plan.scale = level.scale;
    plan.quota = quota + added;
    plan.root = keypointRegion(parameters, plan.size);
    plan.depth = parameters.maxDepth >= 0 ? parameters.maxDepth : quadtreeDepth(quota);
    plan.isRanked = parameters.selectionType == AdaptiveQuadtreeORB::RANKED_SELECTION;
    return plan;
}

// The share of the region that the mask does not exclude. Rows are counted one by one, because countNonZero counts by int.
static double usableShare(const Mat& mask, const Rect& region)
{
    double usable = 0;
    for (int y = region.y; y < region.y + region.height; y++)
        usable += countNonZero(mask.row(y).colRange(region.x, region.x + region.width));
    return usable / (double(region.width) * region.height);
}

void completePlan(const Parameters& parameters, const Mat& mask, LevelPlan& plan)
{
    if (!plan.isRanked)
        return;
    const Size size = plan.root.size();
    const double usable = mask.empty() ? 1 : usableShare(mask, plan.root);
    plan.rankRule = {size, usable, std::max(plan.quota, 1), parameters.rankRadius, parameters.strengthWeight};
    plan.depth = parameters.maxDepth >= 0 ? std::min(parameters.maxDepth, maxRankedDepth(size))
                                          : rankedDepth(size, usable, plan.rankRule.quota);
}

}  // namespace aqorb
}  // namespace cv
