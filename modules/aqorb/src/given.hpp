// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#ifndef OPENCV_AQORB_GIVEN_HPP
#define OPENCV_AQORB_GIVEN_HPP

#include "description.hpp"
#include "parameters.hpp"
#include "levels.hpp"

namespace cv
{
namespace aqorb
{

//! A keypoint that is given to be described.
struct GivenFeature
{
    FeaturePoint point;
    int octave;
    unsigned index;  //!< of the keypoint
};

//! Work space for given keypoints.
struct GivenScratch
{
    std::vector<KeyPoint> keypoints;     //!< those that are described
    std::vector<GivenFeature> features;  //!< by octave, then in raster order
};

/** Takes keypoints as cv::ORB::compute does: lays out the levels up to their highest octave, and finds the pixels at which
 they are described. Throws where an octave is negative or has no pixels, or an angle is not finite. */
void takeGiven(const std::vector<KeyPoint>& keypoints, const Parameters& parameters, Levels& levels,
               GivenScratch& scratch);

//! The features of one octave. They come in the output as they were given.
void listGiven(const GivenScratch& given, int octave, FeatureList& list);

}  // namespace aqorb
}  // namespace cv

#endif
