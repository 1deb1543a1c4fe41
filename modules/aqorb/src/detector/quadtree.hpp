// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// The paper's selection (QUADTREE_SELECTION): equations (8) and (9), and Figure 2.

#ifndef OPENCV_AQORB_QUADTREE_HPP
#define OPENCV_AQORB_QUADTREE_HPP

#include "detector/types.hpp"

namespace cv
{
namespace aqorb
{

//! Equation (8): number of features for each level, nfeatures in all, as in cv::ORB.
std::vector<int> quadtreeQuotas(int nfeatures, double scaleFactor, int nlevels);
//! Equation (9): the smallest D with 4^D >= quota.
int quadtreeDepth(int quota);

//! Node of the tree: a range of corners in the order of their Morton codes.
struct QuadtreeNode
{
    size_t begin, end;
    size_t Num_kp() const { return end - begin; }  //!< number of corners
};
/** Figure 2: splits the root into four children and goes on depth by depth, the fullest node first. Ties go to the
 lower Morton code. It drops empty nodes and does not split nodes of one corner. Splitting ends at the depth D_max
 or with set_kp nodes, the quota of the level.
 @param codes Morton codes of the corners at the greatest depth, at most 16, in ascending order
 @return the nodes left unsplit */
std::vector<QuadtreeNode> splitQuadtree(const std::vector<uint64>& codes, int D_max, int set_kp);

/** Orders the corners of a level: the best corner of each node by response, the highest first, then all other corners
 in the same way. Ties go to the first corner of the list.
 @param corners in raster order */
std::vector<CornerResponse> quadtreeOrder(const std::vector<CornerResponse>& corners, const Rect& region,
                                          int D_max, int set_kp);

}  // namespace aqorb
}  // namespace cv

#endif
