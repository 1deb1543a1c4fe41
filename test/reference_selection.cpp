// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "reference.hpp"

#include <numeric>

#include <cfloat>
#include <limits>
#include <map>
#include <set>

namespace opencv_test
{
namespace reference
{

double binaryLogarithm(float v)
{
    int e = 0;
    const double f = std::frexp((double)v, &e) * 2 - 1;  // v = 2^(e - 1) * (1 + f)
    return v < FLT_MIN ? std::ldexp((double)v, 149) : ((e - 1 + 127) + f) * (1 << 23);
}

std::vector<int> rankedQuotas(int nfeatures, const std::vector<Size>& regions,
                              const std::vector<float>& scales)
{
    std::vector<double> shares;
    for (size_t level = 0; level < regions.size(); level++)
        shares.push_back((double)regions[level].width * regions[level].height *
                         (scales[level] * std::sqrt(std::sqrt((double)scales[level]))));
    shares[0] *= 1.5;
    const double whole = std::accumulate(shares.begin(), shares.end(), 0.);
    std::vector<int> result(1);
    for (size_t level = 1; level < regions.size(); level++)
        result.push_back(cvRound(nfeatures * (shares[level] / whole)));
    int64 sum = std::accumulate(result.begin(), result.end(), (int64)0);
    result[0] = (int)std::max(nfeatures - sum, (int64)0);
    sum += result[0];
    for (int level = 0; sum > nfeatures; sum--)
    {
        while (result[level] == 0)
            level++;
        result[level]--;
    }
    return result;
}

int depthForQuota(int quota, double usable, int most)
{
    int depth = 0;
    while (depth < most && std::pow(4., depth) * usable < 9. * quota)
        depth++;
    return depth;
}

int rankedDepth(int quota, double usable, Size root)
{
    int depth = depthForQuota(quota, usable, 12);
    while (depth > 0 && (2 << depth) > std::min(root.width, root.height))
        depth--;
    return depth;
}

float cornerBase(int fastScore, float response, bool isHarris)
{
    const float f2 = (float)fastScore * (float)fastScore;
    return isHarris ? f2 * f2 * std::max(response, 0.f) : f2 * f2;
}

float momentsScore(float base, int64 m10, int64 m01)
{
    const float M = (float)((uint64)(m10 * m10) + (uint64)(m01 * m01)) * std::ldexp(1.f, -32);
    return base * (M * M);
}

// Higher first. NaN is lower than everything.
static bool isHigher(float a, float b)
{
    return cvIsNaN(a) ? false : cvIsNaN(b) ? true : a > b;
}

static bool isBetterBase(const LeafCorner& a, const LeafCorner& b)
{
    if (isHigher(a.base, b.base) || isHigher(b.base, a.base))
        return isHigher(a.base, b.base);
    if (a.y != b.y)
        return a.y < b.y;
    return a.x != b.x ? a.x < b.x : a.index < b.index;
}

namespace
{

// A corner with all that its place in the sequence depends on.
struct Placed
{
    LeafCorner corner;
    int place;  // in the leaf
    bool isRepresentative;
    float strength;  // the rest is for representatives only
    int part;        // of the sequence of representatives: 0 is infinite, 2 is not positive
    int64 key;
};

bool isStronger(const Placed& a, const Placed& b)
{
    if (isHigher(a.strength, b.strength) || isHigher(b.strength, a.strength))
        return isHigher(a.strength, b.strength);
    return a.corner.row != b.corner.row ? a.corner.row < b.corner.row : a.corner.column < b.corner.column;
}

bool comesBefore(const Placed& a, const Placed& b)
{
    if (a.isRepresentative != b.isRepresentative)
        return a.isRepresentative;
    if (!a.isRepresentative)
        return a.place != b.place ? a.place < b.place : isBetterBase(a.corner, b.corner);
    if (a.part != b.part)
        return a.part < b.part;
    return a.key != b.key ? a.key < b.key : isStronger(a, b);
}

}  // namespace

std::vector<int> rankedSequence(const std::vector<LeafCorner>& corners, const RankedRule& rule,
                                const std::function<bool(int column, int row)>& isUnmasked,
                                const std::function<float(const LeafCorner&)>& strengthOf)
{
    typedef std::map<std::pair<int, int>, std::vector<LeafCorner>> Leaves;
    Leaves leaves;
    for (size_t i = 0; i < corners.size(); i++)
        leaves[std::make_pair(corners[i].row, corners[i].column)].push_back(corners[i]);
    for (Leaves::iterator leaf = leaves.begin(); leaf != leaves.end(); ++leaf)
        std::sort(leaf->second.begin(), leaf->second.end(), isBetterBase);

    // The best of a leaf represents it, unless three or more of the 8 leaves around have a better one.
    std::vector<Placed> representatives, sequence;
    std::set<std::pair<int, int>> represented;
    for (Leaves::iterator leaf = leaves.begin(); leaf != leaves.end(); ++leaf)
    {
        int better = 0;
        for (int dy = -1; dy <= 1; dy++)
            for (int dx = -1; dx <= 1; dx++)
            {
                const Leaves::iterator other =
                    leaves.find(std::make_pair(leaf->first.first + dy, leaf->first.second + dx));
                if (other == leaves.end() || other == leaf)
                    continue;
                const float base = leaf->second[0].base, otherBase = other->second[0].base;
                const bool isEqual = !isHigher(base, otherBase) && !isHigher(otherBase, base);
                better += isHigher(otherBase, base) || (isEqual && other->first < leaf->first);
            }
        for (size_t i = 0; i < leaf->second.size(); i++)
        {
            const bool represents = i == 0 && better < 3;
            (represents ? representatives : sequence)
                .push_back({leaf->second[i], (int)i, represents,
                            represents ? strengthOf(leaf->second[i]) : 0.f, 0, 0});
        }
        if (better < 3)
            represented.insert(leaf->first);
    }

    // Leaves that are (dx, dy) away are in the disc if dx^2 W^2 + dy^2 H^2 <= reach.
    int64 W = rule.root.width, H = rule.root.height;
    while (std::max(W, H) > 1 << 18)
    {
        W = std::max<int64>(W / 2, 1);
        H = std::max<int64>(H / 2, 1);
    }
    const double R = rule.rankRadius;
    const int64 reach = (int64)std::floor(R * R * rule.usable * (double)W * (double)H *
                                          std::pow(4., rule.depth) / rule.quota);
    int64 most = 0;  // |dx|
    while ((most + 1) * (most + 1) * W * W <= reach)
        most++;
    int64 highest = 0;  // |dy|
    while ((highest + 1) * (highest + 1) * H * H <= reach)
        highest++;
    const int64 side = (int64)1 << rule.depth;
    most = std::min(most, side - 1);
    highest = std::min(highest, side - 1);
    const int64 total = (2 * most + 1) * (2 * highest + 1);  // leaves of the square around the disc
    for (size_t i = 0; i < representatives.size(); i++)
    {
        Placed& a = representatives[i];
        const int64 column = a.corner.column, row = a.corner.row;
        int64 stronger = 0, inside = 0;
        for (size_t j = 0; j < representatives.size(); j++)
        {
            const Placed& b = representatives[j];
            const int64 dx = b.corner.column - column, dy = b.corner.row - row;
            if (dx * dx * W * W + dy * dy * H * H <= reach && isStronger(b, a))
                stronger++;
        }
        for (int64 y = std::max(row - highest, (int64)0); y <= std::min(row + highest, side - 1); y++)
            for (int64 x = std::max(column - most, (int64)0); x <= std::min(column + most, side - 1); x++)
                inside +=
                    isUnmasked((int)x, (int)y) || represented.count(std::make_pair((int)y, (int)x)) != 0;
        double key = binaryLogarithm((float)(1 + stronger * ((double)total / inside)));
        if (rule.exponent > 0)
        {
            a.part = a.strength == std::numeric_limits<float>::infinity() ? 0 : a.strength > 0 ? 1 : 2;
            if (a.part == 1)
                key -= rule.exponent * binaryLogarithm(a.strength);
        }
        a.key = (int64)(key * 65536);
        sequence.push_back(a);
    }

    std::sort(sequence.begin(), sequence.end(), comesBefore);
    std::vector<int> indices;
    for (size_t i = 0; i < sequence.size(); i++)
        indices.push_back(sequence[i].corner.index);
    return indices;
}

KeyPoints retainUniform(const KeyPoints& keypoints, Size imageSize, int npoints)
{
    const int depth = depthForQuota(npoints, 1, 12);
    std::vector<LeafCorner> corners;
    for (size_t i = 0; i < keypoints.size(); i++)
    {
        const Point2f p = keypoints[i].pt;
        if (!(p.x >= 0 && p.y >= 0 && p.x < imageSize.width && p.y < imageSize.height))
            continue;
        const double side = 1 << depth;
        corners.push_back({int(p.x * side / imageSize.width), int(p.y * side / imageSize.height), p.x, p.y,
                           keypoints[i].response, (int)i});
    }
    std::vector<int> order;
    if (npoints > 0)
        order = rankedSequence(
            corners, {imageSize, depth, 1, npoints, 1, 0.15}, [](int, int) { return true; },
            [](const LeafCorner& corner) { return corner.base; });
    order.resize(std::min(order.size(), (size_t)npoints));
    std::sort(order.begin(), order.end());
    KeyPoints kept;
    for (size_t i = 0; i < order.size(); i++)
        kept.push_back(keypoints[order[i]]);
    return kept;
}

}  // namespace reference
}  // namespace opencv_test
