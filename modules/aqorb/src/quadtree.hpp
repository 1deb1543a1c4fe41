// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#ifndef OPENCV_AQORB_QUADTREE_HPP
#define OPENCV_AQORB_QUADTREE_HPP

#include "point_sequence.hpp"

namespace cv
{
namespace aqorb
{
namespace stages
{

//! Equation (9): the smallest depth D with 4^D >= quota, at most MAX_QUADTREE_DEPTH.
int quadtreeDepth(int quota);

//! The smallest depth with 12 leaves for each point that the region is to have, but not so deep that leaves become
//! shorter than 2 pixels.
int rankedDepth(Size size, double usable, int quota);
//! The greatest depth that rankedDepth returns for a region.
int maxRankedDepth(Size size);

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

}  // namespace stages
}  // namespace aqorb
}  // namespace cv

#endif
