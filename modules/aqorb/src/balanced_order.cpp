// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "precomp.hpp"

#include "balanced_order.hpp"

namespace cv
{
namespace aqorb
{

// Sorts points by their leaves, those of a group side by side. A better point has a lower key, which ends in its index.
static void groupPoints(const std::vector<LeafPoint>& points, int depth, BalancedScratch& scratch)
{
    const unsigned side = 1u << depth, groupsOfRow = (side + 3) / 4;
    std::vector<uint64>& keys = scratch.keys;
    std::vector<unsigned>&codes = scratch.codes, &starts = scratch.starts;
    codes.resize(points.size());
    for (size_t i = 0; i < points.size(); i++)
    {
        const unsigned column = points[i].leaf & (side - 1), row = points[i].leaf >> depth;
        codes[i] = (row / 4 * groupsOfRow + column / 4) * GROUP_LEAVES + row % 4 * 4 + column % 4;
    }
    const int MOST_DEPTH = 8;
    if (depth > MOST_DEPTH)
    {
        // There are far more groups than points, so those that have any are numbered anew.
        keys.assign(codes.begin(), codes.end());
        sortIndices(keys, scratch.sorting, starts);
        unsigned group = 0;
        for (size_t i = 0; i < starts.size(); i++)
        {
            group += i > 0 && keys[starts[i]] / GROUP_LEAVES != keys[starts[i - 1]] / GROUP_LEAVES;
            codes[starts[i]] = group * GROUP_LEAVES + codes[starts[i]] % GROUP_LEAVES;
        }
    }
    starts.assign(codes.empty() ? 1 : *std::max_element(codes.begin(), codes.end()) + size_t(2), 0u);
    for (unsigned code : codes)
        starts[code + 1]++;
    scratch.leaves.clear();
    scratch.groups.clear();
    for (unsigned code = 0, group = UINT_MAX; code + 1 < starts.size(); code++)
    {
        if (starts[code + 1] > 0)
        {
            if (code / GROUP_LEAVES != group)
                scratch.groups.push_back(LeafGroup(scratch.leaves.size()));
            group = code / GROUP_LEAVES;
            scratch.leaves.push_back(starts[code]);
            scratch.groups.back().end = scratch.leaves.size();
        }
        starts[code + 1] += starts[code];
    }
    scratch.leaves.push_back(unsigned(points.size()));
    keys.resize(points.size());
    for (size_t i = 0; i < points.size(); i++)
        keys[starts[codes[i]]++] = uint64(descendingKey(points[i].key)) << 32 | i;
}

// Fetches the best point of each leaf of a group, or the second best, and so on.
static void fetchOffers(LeafGroup& group, BalancedScratch& scratch)
{
    group.count = group.next = 0;
    for (size_t i = group.begin; i < group.end; i++)
    {
        uint64 *const first = &scratch.keys[scratch.leaves[i]], *const last = first + (scratch.leaves[i + 1] -
                                                                                       scratch.leaves[i]);
        if (first + group.place >= last)
            continue;
        // As a rule no more than the best one is asked for.
        if (group.place == 1)
            std::sort(first, last);
        uint64 best = first[group.place];
        for (uint64* key = first; key < last && group.place == 0; key++)
            best = std::min(best, *key);
        group.offers[group.count++] = best;
    }
    std::sort(group.offers, group.offers + group.count);
    group.place++;
}

void balancedOrder(const std::vector<LeafPoint>& points, int depth, size_t count, BalancedScratch& scratch,
                   std::vector<unsigned>& order)
{
    CV_TRACE_FUNCTION();
    groupPoints(points, depth, scratch);
    order.clear();
    for (std::vector<LeafGroup>& groups = scratch.groups; order.size() < std::min(count, points.size());)
    {
        scratch.offers.clear();
        for (LeafGroup& group : groups)
        {
            if (group.next == group.count)
                fetchOffers(group, scratch);
            if (group.next < group.count)
                scratch.offers.push_back(group.offers[group.next++]);
        }
        std::sort(scratch.offers.begin(), scratch.offers.end());
        order.insert(order.end(), scratch.offers.begin(), scratch.offers.end());
        const auto isExhausted = [](const LeafGroup& group) { return group.count == 0; };
        groups.erase(std::remove_if(groups.begin(), groups.end(), isExhausted), groups.end());
    }
}

}  // namespace aqorb
}  // namespace cv
