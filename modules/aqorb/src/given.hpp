// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#ifndef OPENCV_AQORB_GIVEN_HPP
#define OPENCV_AQORB_GIVEN_HPP

#include "description.hpp"
#include "parameters.hpp"

namespace cv
{
namespace aqorb
{

/** The keypoints that cv::ORB::compute describes of those that are given to it, and the pixels at which it does so: a list
 for each level, up to their highest octave. Throws where an octave is negative or has no pixels, or an angle is not
 finite. */
std::vector<FeatureList> takeGiven(const std::vector<KeyPoint>& keypoints, const Parameters& parameters,
                                   Size imageSize);

}  // namespace aqorb
}  // namespace cv

#endif
