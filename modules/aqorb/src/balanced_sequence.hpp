// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#ifndef OPENCV_AQORB_BALANCED_SEQUENCE_HPP
#define OPENCV_AQORB_BALANCED_SEQUENCE_HPP

#include "point_sequence.hpp"

namespace cv
{
namespace aqorb
{
namespace stages
{

/** Gives points in an order in which the first n points are the best selection of n points, for every n. The selection
 is balanced over the tree first, and then takes the highest responses. Leaves are grouped by their ancestor two levels
 up. A group offers the best point of each of its leaves, then the second best of each, and so on; each round is ordered
 by response. The sequence takes the first offer of every group by response, then the second of every group, and so on.
 An object can be used again, and then needs no new memory. */
class BalancedSequence : public PointSequence
{
public:
    BalancedSequence() : given(0) {}
    //! Starts a sequence. It is fastest for points in raster order.
    void begin(const std::vector<LeafPoint>& points, int depth);
    //! Points that the filter rejects are treated as if they did not exist. The filter is asked about few more points
    //! than are given.
    bool next(LeafPoint& point, const PointFilter* filter = 0) CV_OVERRIDE;

private:
    struct Leaf
    {
        Leaf(unsigned begin_, unsigned end_) : next(0), begin(begin_), end(end_), taken(0) {}
        uint64 next;                 // keys below it are taken
        unsigned begin, end, taken;  // in keys
    };
    struct Group
    {
        unsigned code;        // of the leaves' ancestor
        unsigned begin, end;  // in leaves: those that are not exhausted
    };
    void addLeaf(unsigned code, unsigned begin, unsigned end);
    uint64 takeBest(Leaf& leaf);
    uint64 takeNext(Group& group, const PointFilter* filter);

    std::vector<LeafPoint> points;  // in raster order
    std::vector<uint64> keys;       // of the points, by leaf; a better point has a lower key
    std::vector<Leaf> leaves;
    std::vector<uint64> candidates;  // by leaf: what its group may take next
    std::vector<Group> groups;       // those that have more to offer
    std::vector<uint64> offers;      // of this round, the best first
    size_t given;                    // of the offers
};

}  // namespace stages
}  // namespace aqorb
}  // namespace cv

#endif
