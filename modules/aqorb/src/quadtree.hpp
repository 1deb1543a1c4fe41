// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#ifndef OPENCV_AQORB_QUADTREE_HPP
#define OPENCV_AQORB_QUADTREE_HPP

#include "types.hpp"

namespace cv
{
namespace aqorb
{
namespace stages
{

//! Equation (9): the smallest depth D with 4^D >= quota, at most MAX_QUADTREE_DEPTH.
int quadtreeDepth(int quota);

//! Morton code of the leaf of a quadtree at (column, row).
unsigned leafCode(unsigned column, unsigned row);

//! Work space of leafPoints.
struct LeafScratch
{
    std::vector<unsigned> columns, rows;
};

//! Assigns corners, all of them inside the root, to the leaves of a quadtree.
void leafPoints(const std::vector<RankedCorner>& corners, const Rect& root, int depth, LeafScratch& scratch,
                std::vector<LeafPoint>& points);

//! Decides which points a BalancedSequence leaves out.
class PointFilter
{
public:
    virtual ~PointFilter() {}
    virtual bool accepts(const LeafPoint& point) const = 0;
};

//! Points in the order in which they are to be chosen.
class PointSequence
{
public:
    virtual ~PointSequence() {}
    //! The next point; false if there is none. Points that the filter rejects are passed over. The filter must always
    //! give the same answer for a point.
    virtual bool next(LeafPoint& point, const PointFilter* filter = 0) = 0;
};

//! The order of points that nothing else tells apart.
struct TieBefore
{
    bool operator()(const LeafPoint& a, const LeafPoint& b) const
    {
        if (a.y != b.y)
            return a.y < b.y;
        return a.x != b.x ? a.x < b.x : a.index < b.index;
    }
};

//! Whether points are sorted by TieBefore, as corners are. If a coordinate is negative, the answer is no.
bool areSortedByTies(const std::vector<LeafPoint>& points);

/** Gives points in an order in which the first n points are the best selection of n points, for every n. The selection
 is balanced over the tree first, and then takes the highest responses. Leaves are grouped by their ancestor two levels
 up. A group offers the best point of each of its leaves, then the second best of each, and so on; each round is ordered
 by response. The sequence takes the first offer of every group by response, then the second of every group, and so on.
 An object can be used again, and then needs no new memory. */
class BalancedSequence : public PointSequence
{
public:
    BalancedSequence() : given(0) {}
    //! Starts a sequence. It swaps the points in, so the caller's vector has any content afterwards. It is fastest for
    //! points in raster order.
    void begin(std::vector<LeafPoint>& points, int depth);
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
