// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// The selection of the paper: equations (8) and (9), and Figure 2.

#include "precomp.hpp"

#include "selection.hpp"

namespace cv
{
namespace aqorb
{

// Takes the excess from the finest levels, which have the most features.
static void takeExcess(int64 excess, std::vector<int>& quotas)
{
    for (size_t level = 0; excess > 0; level++)
    {
        const int taken = int(std::min<int64>(excess, quotas[level]));
        quotas[level] -= taken;
        excess -= taken;
    }
}

std::vector<int> balancedQuotas(int nfeatures, double scaleFactor, int nlevels)
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
    takeExcess(sum + quotas[nlevels - 1] - nfeatures, quotas);  // the rounding of cv::ORB can ask for more
    return quotas;
}

int balancedDepth(int quota)
{
    const int MAX_DEPTH = 15;
    int depth = 0;
    while (depth < MAX_DEPTH && (int64(1) << (2 * depth)) < quota)
        depth++;
    return depth;
}

// Sorts the indices of keys, and counts the place of each among the keys with the same upper 32 bits, its set.
static std::vector<unsigned> placesInSets(const std::vector<uint64>& keys)
{
    const std::vector<unsigned> order = sortIndices(keys);
    std::vector<unsigned> places(keys.size());
    for (size_t i = 1; i < order.size(); i++)
        places[order[i]] = keys[order[i]] >> 32 == keys[order[i - 1]] >> 32 ? places[order[i - 1]] + 1 : 0;
    return places;
}

// Leaves are grouped by their ancestor two levels up. A group offers the best point of each of its leaves, then the
// second best of each, and so on, each time by response. The order takes the first offer of every group by response,
// then the second of every group, and so on.
std::vector<unsigned> balancedOrder(const std::vector<LeafPoint>& points, int depth)
{
    CV_TRACE_FUNCTION();
    std::vector<uint64> keys;
    for (const LeafPoint& point : points)
        keys.push_back(uint64(point.leaf) << 32 | descendingKey(point.key));
    const std::vector<unsigned> ofLeaf = placesInSets(keys);
    for (size_t i = 0; i < points.size(); i++)
        keys[i] = uint64(ofLeaf[i]) << 32 | descendingKey(points[i].key);
    const std::vector<unsigned> offers = sortIndices(keys);
    const unsigned columns = (1u << depth) - 1;
    for (size_t i = 0; i < offers.size(); i++)
    {
        const unsigned leaf = points[offers[i]].leaf, column = leaf & columns, row = leaf >> depth;
        keys[offers[i]] = uint64((row / 4) << depth | column / 4) << 32 | i;
    }
    const std::vector<unsigned> ofGroup = placesInSets(keys);
    for (size_t i = 0; i < points.size(); i++)
        keys[i] = uint64(ofGroup[i]) << 32 | descendingKey(points[i].key);
    return sortIndices(keys);
}

std::vector<CornerResponse> balancedCorners(const LevelPlan& plan, const std::vector<CornerResponse>& corners)
{
    std::vector<LeafPoint> points;
    for (const CornerResponse& corner : corners)
        points.push_back(
            {leafOf(corner.x - plan.region.x, corner.y - plan.region.y, plan.region.size(), plan.grid),
             sortKey(corner.response)});
    std::vector<CornerResponse> ordered;
    for (unsigned index : balancedOrder(points, plan.grid.columnBits))
        ordered.push_back(corners[index]);
    return ordered;
}

}  // namespace aqorb
}  // namespace cv
