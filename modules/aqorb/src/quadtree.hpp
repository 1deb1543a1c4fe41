// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// The paper's selection (QUADTREE_SELECTION), in the paper's words: equations (8) and (9), and Figure 2.

#ifndef OPENCV_AQORB_QUADTREE_HPP
#define OPENCV_AQORB_QUADTREE_HPP

#include "types.hpp"

namespace cv
{
namespace aqorb
{

//! Equation (8): the number of features of each level, nfeatures in all. They are cv::ORB's.
std::vector<int> quadtreeQuotas(int nfeatures, double scaleFactor, int nlevels);
//! Equation (9): the smallest D with 4^D >= quota.
int quadtreeDepth(int quota);

//! A node of the tree: the corners from begin to end in the order of their Morton codes.
struct QuadtreeNode
{
    size_t begin, end;
};
/** Figure 2. The root is split into four children, these into theirs, and so on, the fullest of a depth first and
 equally full ones by their Morton codes. Empty nodes are dropped. A node of one corner is saved. No node is split at the
 greatest depth, nor when there are as many nodes as the quota.
 @param codes Morton codes of the corners at the greatest depth, at most 15, in ascending order
 @return the nodes that no split replaced */
std::vector<QuadtreeNode> splitQuadtree(const std::vector<uint64>& codes, int maxDepth, int quota);

/** The corners of a level in the order in which they become keypoints: the best of each node of the tree, the highest
 response first, and then all others in the same way. Ties go to the first in the list.
 @param corners in raster order */
std::vector<CornerResponse> quadtreeOrder(const std::vector<CornerResponse>& corners, const Rect& region,
                                          int maxDepth, int quota);

}  // namespace aqorb
}  // namespace cv

#endif
