// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#ifndef OPENCV_AQORB_TEST_SCENES_HPP
#define OPENCV_AQORB_TEST_SCENES_HPP

#include <opencv2/core.hpp>

// Drawn images, the same for the same seed. They need neither test framework, so that tools/ uses them, too.

namespace opencv_test
{

/** A grey scene with a few hundred corners of all strengths and sizes: filled polygons, discs, lines,
 texture, a smooth area and noise. */
cv::Mat makeScene(cv::Size size, int seed = 1);
//! White noise over all grey levels.
cv::Mat makeNoise(cv::Size size, int seed = 1);
//! Dots of all greys on black: there are corners of all scores.
cv::Mat makeDots(cv::Size size, int seed = 1);

}  // namespace opencv_test

#endif
