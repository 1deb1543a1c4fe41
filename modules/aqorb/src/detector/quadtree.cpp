// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// A linear quadtree: corners are sorted by the Morton codes of their leaves, and a node is a range.

#include "precomp.hpp"

#include "detector/index_sort.hpp"
#include "detector/quadtree.hpp"

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

std::vector<int> quadtreeQuotas(int nfeatures, double scaleFactor, int nlevels)
{
    const float factor = float(1.0 / scaleFactor);
    float desired = factor == 1  // as a float, for a scaleFactor hardly above 1
                        ? float(nfeatures) / nlevels
                        : nfeatures * (1 - factor) / (1 - float(std::pow(double(factor), double(nlevels))));
    const float LARGEST_INT = 2147483520.f;  // the largest int among the floats
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

int quadtreeDepth(int quota)
{
    int depth = 0;
    while (int64(1) << (2 * depth) < quota)
        depth++;
    return depth;
}

std::vector<QuadtreeNode> splitQuadtree(const std::vector<uint64>& codes, int maxDepth, int quota)
{
    CV_TRACE_FUNCTION();
    const auto isFuller = [](const QuadtreeNode& a, const QuadtreeNode& b)
    {
        const size_t sizeA = a.end - a.begin, sizeB = b.end - b.begin;
        return sizeA != sizeB ? sizeA > sizeB : a.begin < b.begin;
    };
    std::vector<QuadtreeNode> saved, nodes(codes.empty() ? 0 : 1, {0, codes.size()}), children;  // the root
    for (int depth = 0; depth < maxDepth && saved.size() + nodes.size() < size_t(quota); depth++)
    {
        // Bits of a code below a child's.
        const uint64 inChild = (uint64(1) << (2 * (maxDepth - depth - 1))) - 1;
        std::sort(nodes.begin(), nodes.end(), isFuller);
        children.clear();
        for (size_t i = 0; i < nodes.size(); i++)
        {
            const QuadtreeNode& node = nodes[i];
            const bool isFull = saved.size() + children.size() + nodes.size() - i >= size_t(quota);
            if (node.end - node.begin == 1 || isFull)
            {
                saved.push_back(node);
                continue;
            }
            for (size_t begin = node.begin, end; begin < node.end; begin = end)  // split
            {
                end = size_t(std::upper_bound(codes.begin() + begin, codes.begin() + node.end,
                                              codes[begin] | inChild) -
                             codes.begin());
                children.push_back({begin, end});
            }
        }
        nodes.swap(children);
    }
    saved.insert(saved.end(), nodes.begin(), nodes.end());
    return saved;
}

// Spreads 16 bits, with a zero above each bit.
static unsigned spreadBits(unsigned v)
{
    v = (v | v << 8) & 0x00ff00ff;
    v = (v | v << 4) & 0x0f0f0f0f;
    v = (v | v << 2) & 0x33333333;
    return (v | v << 1) & 0x55555555;
}

std::vector<CornerResponse> quadtreeOrder(const std::vector<CornerResponse>& corners, const Rect& region,
                                          int maxDepth, int quota)
{
    CV_TRACE_FUNCTION();
    std::vector<uint64> keys, codes;
    for (const CornerResponse& corner : corners)
    {
        const auto leaf = [=](int offset, int side) { return unsigned((int64(offset) << maxDepth) / side); };
        keys.push_back(spreadBits(leaf(corner.x - region.x, region.width)) |
                       spreadBits(leaf(corner.y - region.y, region.height)) << 1);
    }
    const std::vector<unsigned> codeOrder = sortIndices(keys);
    for (unsigned index : codeOrder)
        codes.push_back(keys[index]);
    const uint64 OTHERS = uint64(1) << 32;  // sorts other corners after the best corners of nodes
    for (size_t i = 0; i < corners.size(); i++)
        keys[i] = OTHERS | descendingKey(sortKey(corners[i].response));
    const auto isBetter = [&](unsigned a, unsigned b)
    { return keys[a] != keys[b] ? keys[a] < keys[b] : a < b; };
    for (const QuadtreeNode& node : splitQuadtree(codes, maxDepth, quota))
        keys[*std::min_element(codeOrder.begin() + node.begin, codeOrder.begin() + node.end, isBetter)] &=
            ~OTHERS;
    std::vector<CornerResponse> ordered;
    for (unsigned index : sortIndices(keys))
        ordered.push_back(corners[index]);
    return ordered;
}

}  // namespace aqorb
}  // namespace cv
