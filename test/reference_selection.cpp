// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// The two selections of a level's corners. The paper's: equation (9) and Figure 2, with a node as an object. The default:
// points 1 to 6 of doc/selection.md, and retainUniform.

#include "reference.hpp"

#include <numeric>

#include <cfloat>
#include <limits>
#include <map>
#include <set>
#include <tuple>

namespace opencv_test
{
namespace reference
{

//! log2(v) for v > 0 and finite, in units of 2^-23: for v = 2^e * (1 + f) it is e + f, and 127 more.
static double binaryLogarithm(float v)
{
    int e = 0;
    const double f = std::frexp((double)v, &e) * 2 - 1;  // v = 2^(e - 1) * (1 + f)
    if (cvIsInf(v))
        return 255. * (1 << 23);
    return v < FLT_MIN ? std::ldexp((double)v, 149) : ((e - 1 + 127) + f) * (1 << 23);
}

std::vector<int> rankedQuotas(int nfeatures, const std::vector<Size>& regions,
                              const std::vector<float>& scales)
{
    const auto upTo = [&](size_t finest)  // the sum of the shares of a level and of the coarser ones
    {
        double sum = 0;
        for (size_t level = regions.size(); level-- > finest;)
            sum += (level == 0 ? 1.5 : 1.) * ((double)regions[level].width * regions[level].height) *
                   (scales[level] * std::sqrt(std::sqrt((double)scales[level])));
        return sum;
    };
    std::vector<int> result;
    for (size_t level = 0; level < regions.size(); level++)
        result.push_back(cvRound(nfeatures * (upTo(level) / upTo(0))) -
                         cvRound(nfeatures * (upTo(level + 1) / upTo(0))));
    return result;
}

double representativeDensity(double strengthWeight)
{
    return strengthWeight > 0.15 ? strengthWeight / 0.15 : 1;
}

//! The smallest depth, but at most `most`, at which the usable share of the trees has 9 * density leaves for each
//! feature.
static int depthForQuota(int quota, double usable, int most, int trees = 1, double density = 1)
{
    int depth = 0;
    while (depth < most && trees * std::pow(4., depth) * usable < 9. * density * quota)
        depth++;
    return depth;
}

LeafGrid rankedGrid(int quota, double usable, Size root, double density)
{
    const int shorter = std::min(root.width, root.height), longer = std::max(root.width, root.height);
    int depth = depthForQuota(quota, usable, 12, 1, density), trees = 1;
    if (depth > 0 && 2 << depth > shorter)
    {
        trees = std::max(longer / std::max(shorter, 2), 1);
        depth = depthForQuota(quota, usable, 12, trees, density);
        while (depth > 0 && (2 << depth > shorter || trees * std::pow(4., depth) > std::pow(4., 12)))
            depth--;
    }
    LeafGrid grid = {1 << depth, 1 << depth, 0};
    (root.width > root.height ? grid.columns : grid.rows) *= trees;
    grid.columnBits = cvCeil(std::log2((double)grid.columns));
    return grid;
}

float strength(int fastScore, float response, bool isHarris, int64 m10, int64 m01)
{
    const float f2 = (float)fastScore * (float)fastScore;
    const float M = (float)((uint64)(m10 * m10) + (uint64)(m01 * m01)) * std::ldexp(1.f, -32);
    return (isHarris ? f2 * f2 * std::max(response, 0.f) : f2 * f2) * (M * M);
}

// Higher first. NaN is lower than everything.
static bool isHigher(float a, float b)
{
    return cvIsNaN(a) ? false : cvIsNaN(b) ? true : a > b;
}

static bool isBetter(const LeafCorner& a, const LeafCorner& b)
{
    if (isHigher(a.key, b.key) || isHigher(b.key, a.key))
        return isHigher(a.key, b.key);
    if (a.y != b.y)
        return a.y < b.y;
    return a.x != b.x ? a.x < b.x : a.index < b.index;
}

int quadtreeDepth(int quota)
{
    int depth = 0;
    for (double leaves = 1; leaves < quota; leaves *= 4)
        depth++;
    return depth;
}

namespace
{

// A node of the paper's quadtree.
struct Node
{
    Size root;
    int d, column, row;  // the depth, and the place among the 2^d x 2^d nodes of this depth
    std::vector<LeafCorner> corners;

    std::vector<Node> split() const
    {
        std::vector<Node> children;
        for (int i = 0; i < 4; i++)
        {
            Node child = {root, d + 1, 2 * column + i % 2, 2 * row + i / 2, {}};
            for (const LeafCorner& corner : corners)
                if (child.has(corner))
                    child.corners.push_back(corner);
            if (!child.corners.empty())
                children.push_back(child);
        }
        return children;
    }
    bool has(const LeafCorner& corner) const
    {
        return int64(corner.x) * (1 << d) / root.width == column &&
               int64(corner.y) * (1 << d) / root.height == row;
    }
    const LeafCorner& best() const { return *std::min_element(corners.begin(), corners.end(), isBetter); }
    // Its column and row with their bits in turns.
    int64 mortonCode() const
    {
        int64 code = 0;
        for (int bit = 0; bit < d; bit++)
            code += (int64(column >> bit & 1) << 2 * bit) + (int64(row >> bit & 1) << (2 * bit + 1));
        return code;
    }
};

bool isFuller(const Node& a, const Node& b)
{
    return a.corners.size() != b.corners.size() ? a.corners.size() > b.corners.size()
                                                : a.mortonCode() < b.mortonCode();
}

}  // namespace

std::vector<int> quadtreeOrder(const std::vector<LeafCorner>& corners, Size root, int set_kp, int D_max)
{
    std::vector<Node> nodes = {{root, 0, 0, 0, corners}};  // Initialize Node
    for (int d = 0; d < D_max; d++)
    {
        std::sort(nodes.begin(), nodes.end(), isFuller);
        std::vector<Node> next;
        size_t Num_j = nodes.size();
        for (const Node& node : nodes)
        {
            // Split sub-node if Num_kp > 1, else Save sub-node.
            const size_t Num_kp = node.corners.size();
            const bool isSplit = node.d == d && Num_kp > 1 && Num_j < size_t(set_kp);
            const std::vector<Node> children = isSplit ? node.split() : std::vector<Node>(1, node);
            next.insert(next.end(), children.begin(), children.end());
            Num_j += children.size() - 1;
        }
        nodes = next;
    }
    // Calculate Harris score and filtrate.
    std::vector<LeafCorner> best, others(corners);
    for (const Node& node : nodes)
        if (!node.corners.empty())
            best.push_back(node.best());
    std::sort(best.begin(), best.end(), isBetter);
    std::sort(others.begin(), others.end(), isBetter);
    best.insert(best.end(), others.begin(), others.end());
    std::vector<int> order;
    std::set<int> listed;
    for (const LeafCorner& corner : best)
        if (listed.insert(corner.index).second)
            order.push_back(corner.index);
    return order;
}

namespace
{

// A representative with all that its place in the order depends on.
struct Representative
{
    LeafCorner corner;
    float strength;
    int64 key;
    float tie;  // the higher comes first
};

bool isStronger(const Representative& a, const Representative& b)
{
    if (isHigher(a.strength, b.strength) || isHigher(b.strength, a.strength))
        return isHigher(a.strength, b.strength);
    if (a.tie != b.tie)
        return a.tie > b.tie;
    return a.corner.row != b.corner.row ? a.corner.row < b.corner.row : a.corner.column < b.corner.column;
}

bool comesBefore(const Representative& a, const Representative& b)
{
    if ((a.strength > 0) != (b.strength > 0))
        return a.strength > 0;
    return a.key != b.key ? a.key < b.key : isStronger(a, b);
}

}  // namespace

std::vector<int> rankedOrder(const std::vector<LeafCorner>& corners, const RankRule& rule,
                             const std::function<bool(int column, int row)>& isUnmasked,
                             const std::function<float(const LeafCorner&)>& strengthOf, double density,
                             bool breaksTiesByKey)
{
    typedef std::map<std::pair<int, int>, LeafCorner> Leaves;
    Leaves leaves;
    for (const LeafCorner& corner : corners)
    {
        LeafCorner& best = leaves.insert({{corner.row, corner.column}, corner}).first->second;
        if (isBetter(corner, best))
            best = corner;
    }

    // The best of a leaf represents it, unless three or more of the 8 leaves around have a better one. In denser
    // trees it takes more.
    std::vector<Representative> representatives;
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
                const float key = leaf->second.key, otherKey = other->second.key;
                const bool isEqual = !isHigher(key, otherKey) && !isHigher(otherKey, key);
                better += isHigher(otherKey, key) || (isEqual && other->first < leaf->first);
            }
        if (better >= 3 * density)
            continue;
        const float tie = breaksTiesByKey ? leaf->second.key : 0;
        representatives.push_back({leaf->second, strengthOf(leaf->second), 0, tie});
        represented.insert(leaf->first);
    }

    // Leaves that are (dx, dy) away are in the disc if their centres are within the radius.
    const int columns = rule.grid.columns, rows = rule.grid.rows;
    const double W = (double)rule.region.width / columns, H = (double)rule.region.height / rows;
    const double area = rule.usable * rule.region.width * rule.region.height / rule.quota;  // of a feature
    // A disc, or as wide a part of a narrow region as has the area of the disc.
    const double disc = rule.radius * rule.radius * area,
                 inRow = CV_PI / 2 * rule.radius * rule.radius * area /
                         std::min(rule.region.width, rule.region.height),
                 reach = std::max(disc, inRow * inRow);
    const auto isInDisc = [&](double dx, double dy)
    { return dx * dx * (W * W) + dy * dy * (H * H) <= reach; };
    int most = 0, highest = 0;  // |dx|, |dy|
    while (most < columns - 1 && isInDisc(most + 1, 0))
        most++;
    while (highest < rows - 1 && isInDisc(0, highest + 1))
        highest++;
    const int64 total = ((int64)2 * most + 1) * (2 * highest + 1);  // leaves of the square around the disc
    for (size_t i = 0; i < representatives.size(); i++)
    {
        Representative& a = representatives[i];
        const int column = a.corner.column, row = a.corner.row;
        int64 stronger = 0, inside = 0;
        for (const Representative& b : representatives)
            stronger += isInDisc(b.corner.column - column, b.corner.row - row) && isStronger(b, a);
        for (int y = std::max(row - highest, 0); y <= std::min(row + highest, rows - 1); y++)
            for (int x = std::max(column - most, 0); x <= std::min(column + most, columns - 1); x++)
                inside += isUnmasked(x, y) || represented.count(std::make_pair(y, x)) != 0;
        double key = binaryLogarithm((float)(1 + stronger * ((double)total / inside)));
        if (a.strength > 0)
            key -= rule.exponent * binaryLogarithm(a.strength);
        a.key = (int64)(key * 65536);
    }

    std::sort(representatives.begin(), representatives.end(), comesBefore);
    std::vector<int> indices;
    for (const Representative& representative : representatives)
        indices.push_back(representative.corner.index);
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
    double highest = 0;
    for (const LeafCorner& corner : corners)
        if (!cvIsInf(corner.key) && corner.key > highest)
            highest = corner.key;
    const auto strengthOf = [&](const LeafCorner& corner)
    {
        const float response = keypoints[corner.index].response;
        if (!(response > 0) || cvIsInf(response))
            return response;
        const float ratio = (float)(response / highest * std::pow(2., 127));
        return ratio > 0 ? ratio : std::numeric_limits<float>::denorm_min();
    };
    // Equal responses come in the order of a hash of their places in raster order. The keys become places in this order.
    std::sort(corners.begin(), corners.end(),
              [](const LeafCorner& a, const LeafCorner& b)
              { return std::tie(a.y, a.x, a.index) < std::tie(b.y, b.x, b.index); });
    std::map<int, unsigned> hashes;
    for (size_t i = 0; i < corners.size(); i++)
        hashes[corners[i].index] = (unsigned)(i * 2654435769u);
    std::sort(corners.begin(), corners.end(),
              [&](const LeafCorner& a, const LeafCorner& b)
              {
                  const bool isEqual = !isHigher(a.key, b.key) && !isHigher(b.key, a.key);
                  return isEqual ? hashes[a.index] < hashes[b.index] : isHigher(a.key, b.key);
              });
    for (size_t i = 0; i < corners.size(); i++)
        corners[i].key = -(float)i;
    std::vector<int> order;
    if (npoints > 0)
        order = rankedOrder(
            corners, {imageSize, {1 << depth, 1 << depth, depth}, 1, npoints, 1, 0.15},
            [](int, int) { return true; }, strengthOf, 1, true);
    // The others follow by response.
    const std::set<int> representatives(order.begin(), order.end());
    for (const LeafCorner& corner : corners)
        if (representatives.count(corner.index) == 0)
            order.push_back(corner.index);
    order.resize(std::min(order.size(), (size_t)npoints));
    std::sort(order.begin(), order.end());
    KeyPoints kept;
    for (size_t i = 0; i < order.size(); i++)
        kept.push_back(keypoints[order[i]]);
    return kept;
}

}  // namespace reference
}  // namespace opencv_test
