// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#ifndef OPENCV_AQORB_SELECTION_HPP
#define OPENCV_AQORB_SELECTION_HPP

#include "balanced_order.hpp"
#include "plan.hpp"
#include "ranked_order.hpp"
#include "types.hpp"

namespace cv
{
namespace aqorb
{

/** Chooses the features of all levels. Level by level, from coarse to fine, it takes as many corners as the quota of the
 level and what coarser levels left over. It passes over corners that are nearer than octaveSuppression pixels of their
 level to a keypoint of another level within reach. An object can be used again, and then needs no new memory. */
class FeatureSelector
{
public:
    //! Starts with an image.
    //! @param reach a corner is not near keypoints of levels that are further away than so many levels
    void reset(Size imageSize, int levelCount, double octaveSuppression, int reach);
    //! Goes on to a level, whose plan is complete, and asks for its quota.
    void addLevel(int level, const LevelPlan& plan);
    //! How many of the features that were asked for are missing.
    int missing() const { return wanted; }
    /** Takes corners of a level in the order in which they are to be chosen, from the first one that was neither taken nor
     passed over before.
     @param corners in this order or, for balancedOrder, in raster order: only here it is known which of them octave
     suppression passes over, and for the paper's order these do not exist */
    void take(int level, const std::vector<CornerResponse>& corners);
    //! Fills up with corners of a level that a rule passed over, given in raster order.
    void fill(int level, const std::vector<CornerResponse>& corners);
    //! Gives the chosen corners of a level, but the first ones, in raster order.
    void chosen(int level, size_t first, std::vector<CornerResponse>& corners);

private:
    //! A keypoint of another level, and the next one in a block.
    struct ListedKeypoint
    {
        Point2d position;
        int next;
    };
    struct LevelState
    {
        LevelPlan plan;
        size_t next;       // in the order
        bool hasBegun;     // whether corners were taken
        bool isExhausted;  // whether balancedOrder has no more of them
        std::vector<CornerResponse> chosen;
    };
    void listKeypoints(int level, int first, int last);
    bool isNearKeypoint(int level, const CornerResponse& corner) const;
    Point2d position(int level, const CornerResponse& corner) const;
    void orderByRule(int level, const std::vector<CornerResponse>& corners, size_t count,
                     bool withSuppression);

    Size imageSize;
    double octaveSuppression = 0;
    int reach = 0;                   // of octave suppression, in levels
    std::vector<LevelState> levels;  // it never shrinks, so that levels keep their memory
    int levelCount = 0;              // of this image
    int wanted = 0;                  // features that are still missing
    std::vector<ListedKeypoint> keypoints;
    std::vector<int> heads;  // by block of a level: the first one that is near its pixels, or -1
    int blockShift = 0, blockColumns = 0;  // blocks have 2^blockShift columns and rows
    LeafGrid leaves;
    BalancedScratch balancedScratch;
    RankedScratch rankedScratch;
    std::vector<LeafPoint> points;
    std::vector<unsigned> order, unsuppressed;
    std::vector<CornerResponse> filling, taken;
    std::vector<uint64> rasterKeys;
    SortScratch sorting;
};

}  // namespace aqorb
}  // namespace cv

#endif
