// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// Replaces OpenCV's private header of this name: declares the functions that opencv_ts calls and libopencv_core
// exports.

#ifndef OPENCV_CONFIGURATION_PRIVATE_HPP
#define OPENCV_CONFIGURATION_PRIVATE_HPP

#include <opencv2/core/cvdef.h>

#include <cstddef>

namespace cv
{
namespace utils
{

CV_EXPORTS bool getConfigurationParameterBool(const char* name, bool defaultValue);
CV_EXPORTS size_t getConfigurationParameterSizeT(const char* name, size_t defaultValue);

}  // namespace utils
}  // namespace cv

#endif
