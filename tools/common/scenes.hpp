// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#ifndef AQORB_TOOLS_SCENES_HPP
#define AQORB_TOOLS_SCENES_HPP

// The drawn images of all tools:
//
//   opencv_test::makeStreetScene  resembles a photograph: for anything that is timed
//   opencv_test::makeScene        has corners of all strengths everywhere: for tests of results
//   tools::makeIntegerScene       is the same on every CPU: for hashes that are compared between them

#include "../../perf/perf_scene.hpp"
#include "../../test/scenes.hpp"

namespace tools
{

/** Rectangles, texture on the left and noise, in integer arithmetic only: drawing and filtering by OpenCV might
 themselves depend on the CPU. */
cv::Mat makeIntegerScene(cv::Size size, int channels, uint64 seed);

}  // namespace tools

#endif
