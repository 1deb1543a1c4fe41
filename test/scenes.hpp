// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#ifndef OPENCV_AQORB_TEST_SCENES_HPP
#define OPENCV_AQORB_TEST_SCENES_HPP

#include <opencv2/core.hpp>

#include <cstdint>

// Drawn images, the same for the same seed. They need neither test framework, so that perf/, tools/ and samples/ use
// them, too.

namespace opencv_test
{

/** A grey scene with a few hundred corners of all strengths and sizes: filled polygons, discs, lines,
 texture, a smooth area and noise. */
cv::Mat makeScene(cv::Size size, int seed = 1);
/** Rectangles, texture on the left and noise, in integer arithmetic only: for hashes that are compared between versions
 and CPUs. Drawing and filtering by OpenCV might themselves depend on them. */
cv::Mat makeIntegerScene(cv::Size size, uint64_t seed, int channels = 1);
//! White noise over all grey levels.
cv::Mat makeNoise(cv::Size size, int seed = 1);
//! Dots of all greys on black: there are corners of all scores.
cv::Mat makeDots(cv::Size size, int seed = 1);

}  // namespace opencv_test

#endif
