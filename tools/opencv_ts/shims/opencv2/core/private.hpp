// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// Replaces OpenCV's private header of this name: declares the functions that opencv_ts calls and libopencv_core
// exports.

#ifndef OPENCV_CORE_PRIVATE_HPP
#define OPENCV_CORE_PRIVATE_HPP

#include <opencv2/core.hpp>

namespace cv
{

CV_EXPORTS const char* currentParallelFramework();
CV_EXPORTS void scalarToRawData(const Scalar& s, void* buf, int type, int unroll_to = 0);

}  // namespace cv

#endif
