// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#ifndef OPENCV_AQORB_PLAN_HPP
#define OPENCV_AQORB_PLAN_HPP

#include "parameters.hpp"
#include "ranked_order.hpp"
#include "types.hpp"

namespace cv
{
namespace aqorb
{

//! The deepest quadtree has 2^15 leaves along a side.
const int MAX_QUADTREE_DEPTH = 15;

//! What a level is to contribute: how many features, where, and by which rule they are chosen.
struct LevelPlan
{
    Size size;          //!< of the level
    float scale;        //!< of the level
    int quota;          //!< number of features that the level is to have
    Rect root;          //!< of the quadtree: the keypointRegion
    int depth;          //!< of the quadtree
    bool isRanked;      //!< true: rankedOrder; false: balancedOrder
    RankRule rankRule;  //!< of rankedOrder
};

//! The shortest side of a level that can have a keypoint.
int shortestSide(const Parameters& parameters);

//! Where a level of this size may have keypoints: between the borders.
Rect keypointRegion(const Parameters& parameters, Size size);

//! The distance in pixels for which the property OctaveSuppression stands.
double suppressionRadius(const Parameters& parameters);

//! The number of features of each level by equation (8), rounded as by cv::ORB but at most nfeatures in all.
std::vector<int> levelQuotas(int nfeatures, double scaleFactor, int nlevels);

//! What the share of a level depends on.
struct LevelRegion
{
    Size size;    //!< of its keypointRegion
    float scale;  //!< of the level
};

/** The number of features of each level for RANKED_SELECTION, nfeatures in all: in proportion to
 area * scale^1.25, and half as much again for the finest level. */
void rankedQuotas(int nfeatures, const std::vector<LevelRegion>& regions, std::vector<int>& quotas);

//! Equation (9): the smallest depth D with 4^D >= quota, at most MAX_QUADTREE_DEPTH.
int quadtreeDepth(int quota);

//! The smallest depth with 9 usable leaves for each of `quota` points, at most maxRankedDepth.
//! @param usable the share of the region that no mask excludes
int rankedDepth(Size size, double usable, int quota);
//! The greatest depth, at most 12, at which leaves are at least 2 pixels a side.
int maxRankedDepth(Size size);

/** Plans a level as far as that is possible without its mask.
 @param quota of the level
 @param added quota of coarser levels that the pyramid does not have; as in version 0.1, it does not deepen the tree of
 balancedOrder */
LevelPlan planLevel(const Parameters& parameters, const Level& level, int quota, int added);

//! Completes the plan of a level when its mask is known.
void completePlan(const Parameters& parameters, const Mat& mask, LevelPlan& plan);

}  // namespace aqorb
}  // namespace cv

#endif
