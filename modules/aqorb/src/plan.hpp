// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#ifndef OPENCV_AQORB_PLAN_HPP
#define OPENCV_AQORB_PLAN_HPP

#include "parameters.hpp"
#include "selection.hpp"

namespace cv
{
namespace aqorb
{

//! The shortest side of a level that can have a keypoint.
int shortestSide(const Parameters& parameters);

/** Plans what a level is to contribute: where it may have keypoints, how many, and in which order they are chosen.
 @param quota of the level
 @param added quota of coarser levels that the pyramid does not have */
stages::SelectionLevel planLevel(const Parameters& parameters, const stages::Level& level, int quota,
                                 int added);

//! Completes the plan of a level when its mask is known.
void planOrder(const Parameters& parameters, const Mat& mask, stages::SelectionLevel& planned);

}  // namespace aqorb
}  // namespace cv

#endif
