// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// FAST thresholds of an image, by equation (7) of the paper.

#ifndef OPENCV_AQORB_THRESHOLD_HPP
#define OPENCV_AQORB_THRESHOLD_HPP

#include "detector/types.hpp"

namespace cv
{
namespace aqorb
{

//! Equation (7) for a CV_8UC1 image: variance over mean of the unmasked pixels; 0 if the mean is 0. The threads share
//! the rows.
double varianceOverMean(const Mat& image, const Mat& mask, int threads);

//! Value of equation (7) at which iniT equals fastThreshold.
const double NEUTRAL_CONTRAST = 20;

//! iniT and minT from the contrast, the value of equation (7), which is not scaled at fastThreshold 20.
Thresholds fastThresholds(double contrast, int fastThreshold, double minRatio);

}  // namespace aqorb
}  // namespace cv

#endif
