// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "precomp.hpp"

#include "balanced_sequence.hpp"

namespace cv
{
namespace aqorb
{
namespace stages
{

namespace
{

// Keys of points that are sorted by TieBefore: the better point has the lower key. No two keys are equal, so the
// result does not depend on the order in which the caller gives the points.
uint64 keyOf(float response, size_t position)
{
    return uint64(~unsignedOrderOf(response)) << 32 | position;
}
size_t positionOf(uint64 key)
{
    return size_t(key & 0xffffffffu);
}
const uint64 NO_KEY = ~uint64(0);

// Orders keys by the leaf of their points.
struct ByLeaf
{
    bool operator()(uint64 a, uint64 b) const
    {
        return points[positionOf(a)].leaf < points[positionOf(b)].leaf;
    }
    const LeafPoint* points;
};

}  // namespace

// The best point of each leaf is found by begin, which several threads run at once for different levels. Whatever else
// is needed is done by next, which one thread calls. As a rule that is little, because a level has many more corners
// than it needs.

void BalancedSequence::begin(const std::vector<LeafPoint>& points_, int depth)
{
    CV_TRACE_FUNCTION();
    points = points_;
    groups.clear();
    leaves.clear();
    offers.clear();
    given = 0;
    if (!areSortedByTies(points))
        std::sort(points.begin(), points.end(), TieBefore());

    // The keys are put into buckets. A bucket is a leaf or, in a tree too deep for an array of leaves, an ancestor.
    const int BUCKET_DEPTH = 6, shift = 2 * std::max(depth - BUCKET_DEPTH, 0);
    const size_t buckets = size_t(1) << (2 * depth - shift);
    unsigned ends[(1 << (2 * BUCKET_DEPTH)) + 1];
    std::fill(ends, ends + buckets + 1, 0u);
    for (size_t i = 0; i < points.size(); i++)
        ends[(points[i].leaf >> shift) + 1]++;
    for (size_t i = 0; i < buckets; i++)
        ends[i + 1] += ends[i];
    keys.resize(points.size());
    for (size_t i = 0; i < points.size(); i++)
        keys[ends[points[i].leaf >> shift]++] = keyOf(points[i].response, i);

    unsigned begin = 0;
    for (size_t i = 0; i < buckets; i++)
    {
        const unsigned end = ends[i];
        const ByLeaf byLeaf = {points.data()};
        if (shift > 0)
            std::sort(keys.begin() + begin, keys.begin() + end, byLeaf);
        while (begin < end)
        {
            unsigned next = end;
            if (shift > 0)
                next =
                    unsigned(std::upper_bound(keys.begin() + begin, keys.begin() + end, keys[begin], byLeaf) -
                             keys.begin());
            addLeaf(points[positionOf(keys[begin])].leaf, begin, next);
            begin = next;
        }
    }
    candidates.resize(leaves.size());
    for (size_t i = 0; i < leaves.size(); i++)
        candidates[i] = takeBest(leaves[i]);
}

void BalancedSequence::addLeaf(unsigned code, unsigned begin, unsigned end)
{
    const unsigned LEAVES = 16, slot = unsigned(leaves.size());
    if (groups.empty() || groups.back().code != code / LEAVES)
    {
        const Group group = {code / LEAVES, slot, slot};
        groups.push_back(group);
    }
    groups.back().end++;
    leaves.emplace_back(begin, end);
}

// Removes the best point from a leaf and returns its key, or NO_KEY if there is none.
uint64 BalancedSequence::takeBest(Leaf& leaf)
{
    const unsigned size = leaf.end - leaf.begin;
    if (leaf.taken == size)
        return NO_KEY;
    // For the first few points it is cheaper to search for the best one. If more are asked for, the leaf is sorted.
    const unsigned SELECTED = 4;
    uint64* const ofLeaf = keys.data() + leaf.begin;
    if (leaf.taken < SELECTED)
    {
        uint64 ahead =
            NO_KEY;  // the least distance from leaf.next; by overflow, keys that are taken come last
        for (unsigned i = 0; i < size; i++)
            ahead = std::min(ahead, ofLeaf[i] - leaf.next);
        const uint64 key = leaf.next + ahead;
        leaf.taken++;
        leaf.next = key + 1;
        return key;
    }
    if (leaf.taken == SELECTED)
        std::sort(ofLeaf, ofLeaf + size);
    return ofLeaf[leaf.taken++];
}

// Removes the next point that the filter accepts from a group and returns its key, or NO_KEY if there is none.
uint64 BalancedSequence::takeNext(Group& group, const PointFilter* filter)
{
    for (;;)
    {
        uint64 key = NO_KEY;
        unsigned best = group.begin;
        for (unsigned i = group.begin; i < group.end; i++)
        {
            best += (i - best) &
                    (0u - unsigned(candidates[i] < key));  // without a branch, which would be hard to predict
            key = std::min(key, candidates[i]);
        }
        if (key == NO_KEY)
        {
            // Every leaf has had its turn. Those that are not exhausted get another one.
            const unsigned end = group.end;
            group.end = group.begin;
            for (unsigned i = group.begin; i < end; i++)
            {
                const uint64 candidate = takeBest(leaves[i]);
                if (candidate == NO_KEY)
                    continue;
                candidates[group.end] = candidate;
                leaves[group.end++] = leaves[i];
            }
            if (group.begin == group.end)
                return NO_KEY;
        }
        else if (!filter || filter->accepts(points[positionOf(key)]))
        {
            candidates[best] = NO_KEY;
            return key;
        }
        else
        {
            candidates[best] = takeBest(leaves[best]);
        }
    }
}

bool BalancedSequence::next(LeafPoint& point, const PointFilter* filter)
{
    if (given == offers.size())
    {
        offers.clear();
        given = 0;
        size_t left = 0;  // groups that are not exhausted
        for (size_t i = 0; i < groups.size(); i++)
        {
            const uint64 key = takeNext(groups[i], filter);
            if (key == NO_KEY)
                continue;
            offers.push_back(key);
            groups[left++] = groups[i];
        }
        groups.resize(left);
        if (offers.empty())
            return false;
        std::sort(offers.begin(), offers.end());
    }
    point = points[positionOf(offers[given++])];
    return true;
}

}  // namespace stages
}  // namespace aqorb
}  // namespace cv
