// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// Figure 2 of the paper, with its names and the words of its boxes as comments. The quadtree is linear: corners are
// sorted by the Morton codes of their leaves, and a node is a range. test/reference_selection.cpp has the figure with
// nodes as objects.

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

std::vector<QuadtreeNode> splitQuadtree(const std::vector<uint64>& codes, int D_max, int set_kp)
{
    CV_TRACE_FUNCTION();
    const auto isFuller = [](const QuadtreeNode& a, const QuadtreeNode& b)
    { return a.Num_kp() != b.Num_kp() ? a.Num_kp() > b.Num_kp() : a.begin < b.begin; };
    // Initialize Node: the root.
    std::vector<QuadtreeNode> saved, nodes(codes.empty() ? 0 : 1, {0, codes.size()}), children;
    size_t Num_j = nodes.size();  // the saved nodes, and those that are still to be split or saved
    for (int d = 0; d < D_max && Num_j < size_t(set_kp); d++)  // d < D_max
    {
        // Bits of a code below a child's.
        const uint64 inChild = (uint64(1) << (2 * (D_max - d - 1))) - 1;
        std::sort(nodes.begin(), nodes.end(), isFuller);
        children.clear();
        for (const QuadtreeNode& node : nodes)
        {
            // Num_kp > 0: no node without a corner is made.
            if (node.Num_kp() > 1 && Num_j < size_t(set_kp))
            {
                // Num_kp > 1: Split sub-node.
                Num_j--;
                for (size_t begin = node.begin, end; begin < node.end; begin = end, Num_j++)
                {
                    end = size_t(std::upper_bound(codes.begin() + begin, codes.begin() + node.end,
                                                  codes[begin] | inChild) -
                                 codes.begin());
                    children.push_back({begin, end});
                }
            }
            else
            {
                // Save sub-node, Num_j++: it is counted already.
                saved.push_back(node);
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

// Calculate Harris score and filtrate: each saved node keeps its best corner. The best of these come first, so a level
// that takes set_kp corners leaves out the weakest ones if Num_j > set_kp.
static std::vector<unsigned> filtrate(const std::vector<QuadtreeNode>& saved,
                                      const std::vector<unsigned>& codeOrder,
                                      const std::vector<CornerResponse>& corners)
{
    const uint64 NOT_KEPT = uint64(1) << 32;  // sorts corners that their node does not keep after all others
    std::vector<uint64> keys;
    for (const CornerResponse& corner : corners)
        keys.push_back(NOT_KEPT | descendingKey(sortKey(corner.response)));
    const auto isBetter = [&](unsigned a, unsigned b)
    { return keys[a] != keys[b] ? keys[a] < keys[b] : a < b; };
    for (const QuadtreeNode& node : saved)
        keys[*std::min_element(codeOrder.begin() + node.begin, codeOrder.begin() + node.end, isBetter)] &=
            ~NOT_KEPT;
    return sortIndices(keys);
}

std::vector<CornerResponse> quadtreeOrder(const std::vector<CornerResponse>& corners, const Rect& region,
                                          int D_max, int set_kp)
{
    CV_TRACE_FUNCTION();
    std::vector<uint64> mortonCodes, codes;
    for (const CornerResponse& corner : corners)
    {
        const auto leaf = [=](int offset, int side) { return unsigned((int64(offset) << D_max) / side); };
        mortonCodes.push_back(spreadBits(leaf(corner.x - region.x, region.width)) |
                              spreadBits(leaf(corner.y - region.y, region.height)) << 1);
    }
    const std::vector<unsigned> codeOrder = sortIndices(mortonCodes);
    for (unsigned index : codeOrder)
        codes.push_back(mortonCodes[index]);
    std::vector<CornerResponse> ordered;
    for (unsigned index : filtrate(splitQuadtree(codes, D_max, set_kp), codeOrder, corners))
        ordered.push_back(corners[index]);
    return ordered;
}

}  // namespace aqorb
}  // namespace cv
