// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#ifndef OPENCV_AQORB_PERF_SCENE_HPP
#define OPENCV_AQORB_PERF_SCENE_HPP

#include <opencv2/core.hpp>

namespace opencv_test
{

/** Draws a synthetic photograph, the same in every run: a smooth sky, houses with windows, textured ground, plain
 walls, blur of a lens and noise of a sensor. Objects grow with the image, texture does not. It has about as many FAST
 corners as a photograph of a street of the same size, spread as unevenly. */
cv::Mat makeStreetScene(const cv::Size& size);

}  // namespace opencv_test

#endif
