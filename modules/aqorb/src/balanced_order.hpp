// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#ifndef OPENCV_AQORB_BALANCED_ORDER_HPP
#define OPENCV_AQORB_BALANCED_ORDER_HPP

#include "index_sort.hpp"
#include "quadtree.hpp"

namespace cv
{
namespace aqorb
{

const int GROUP_LEAVES = 16;

//! Leaves with the same ancestor two levels up.
struct LeafGroup
{
    explicit LeafGroup(size_t begin_) : begin(begin_), end(begin_), place(0), next(0), count(0) {}

    size_t begin, end;            // in the list of leaves
    ptrdiff_t place;              // in the leaves, of the points to be fetched next
    int next, count;              // of the offers
    uint64 offers[GROUP_LEAVES];  // the points of a place in order
};

//! Work space of balancedOrder.
struct BalancedScratch
{
    std::vector<uint64> keys, offers;
    std::vector<unsigned> codes, starts, leaves;
    std::vector<LeafGroup> groups;
    SortScratch sorting;
};

/** The paper's order: its first n points are the best selection of n points, for every n. It is balanced over the tree
 first, and then takes the highest responses. Leaves are grouped by their ancestor two levels up. A group offers the best
 point of each of its leaves, then the second best of each, and so on, each time by response. The order takes the first
 offer of every group by response, then the second of every group, and so on.
 @param depth of the quadtree
 @param count of points that are wanted
 @param order gets the indices of so many points or more, as far as there are any */
void balancedOrder(const std::vector<LeafPoint>& points, int depth, size_t count, BalancedScratch& scratch,
                   std::vector<unsigned>& order);

}  // namespace aqorb
}  // namespace cv

#endif
