// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#ifndef OPENCV_AQORB_PERF_PRECOMP_HPP
#define OPENCV_AQORB_PERF_PRECOMP_HPP

#include "opencv2/ts.hpp"
#include "opencv2/aqorb.hpp"

namespace opencv_test
{

//! Whether the tests measure OpenCV's own detector, matcher or tracker instead of this module's.
inline bool isOfOpenCV()
{
    return perf::TestBase::getSelectedImpl() == "opencv";
}

/** Loads an image, or with index 2 the second image of its pair. Without the file in OPENCV_TEST_DATA_PATH it throws
 SkipTestException.
 @param name scene_WIDTHxHEIGHT for makeScene, or a photograph of opencv_extra: a set such as bikes, or a file in
 perf */
Mat loadImage(const std::string& name, int index = 1);

}  // namespace opencv_test

#endif
