// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#ifndef OPENCV_AQORB_SELECTION_HPP
#define OPENCV_AQORB_SELECTION_HPP

#include "balanced_sequence.hpp"
#include "quadtree.hpp"
#include "ranked_sequence.hpp"
#include "types.hpp"

namespace cv
{
namespace aqorb
{
namespace stages
{

//! What selection must know of a level.
struct SelectionLevel
{
    Size size;        //!< of the level
    float scale;      //!< of the level
    int quota;        //!< number of features that the level is to have
    OrderRule order;  //!< of corners that are not in the level's sequence
};

//! The corners of a level that selection asks for.
struct CornerRequest
{
    int level;
    CornerSet set;
};

/** Chooses the features of all levels. It takes from the sequence of each level, from coarse to fine, as many
 corners as the quota of the level and what coarser levels left over. It passes over corners that are nearer than
 octaveSuppression pixels of their level to a keypoint of another level within reach. If features are still missing then, it
 goes through the levels from fine to coarse: first it continues their sequences, and then it fills up with the corners
 that the rules have passed over.

 Selection does not call other stages. It says which corners it needs next, and is then given them:
 @code
    selector.begin(imageSize, octaveSuppression, reach);
    // addLevel for each level
    for (int level = levels - 1; level >= 0; level--)
        if (selector.wantsOf(level) > 0)
            selector.offer(sequence);
    CornerRequest request;
    while (selector.wants(request))
        // offer what it wants
 @endcode
 An object can be used again, and then needs no new memory. */
class FeatureSelector
{
public:
    FeatureSelector();
    //! Starts with an image.
    //! @param suppressionReach a corner is not near keypoints of levels that are further away than so many levels
    void begin(Size imageSize, double octaveSuppression, int suppressionReach);
    //! Adds the next level, in the order of the pyramid.
    void addLevel(const SelectionLevel& level);
    //! Goes on to a level, from coarse to fine, and returns how many of its corners are wanted. If there are any, its
    //! sequence must be offered next.
    int wantsOf(int level);
    //! After the finest level: which corners must be offered next; false when the selection is complete.
    bool wants(CornerRequest& request);
    //! Answers wantsOf, or a request for SEQUENCE_CORNERS. The sequence must be as the previous request left it.
    void offer(PointSequence& sequence);
    //! Answers any other request. The corners come in raster order.
    void offer(const std::vector<RankedCorner>& corners);
    //! How many corners of a level have been chosen.
    size_t count(int level) const;
    //! Gives the chosen corners of a level, but the first ones, in raster order.
    void chosen(int level, size_t first, std::vector<RankedCorner>& corners);

private:
    class Impl;
    Ptr<Impl> impl;
};

}  // namespace stages
}  // namespace aqorb
}  // namespace cv

#endif
