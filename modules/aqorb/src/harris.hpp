// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#ifndef OPENCV_AQORB_HARRIS_HPP
#define OPENCV_AQORB_HARRIS_HPP

#include "types.hpp"

namespace cv
{
namespace aqorb
{

/** Computes the Harris response of cv::ORB, but over a block of 5x5 instead of 7x7 pixels: det - 0.04 trace^2
 of the sums over the block of the products of the Sobel derivatives. */
void harrisResponses(const Mat& image, const Corner* corners, size_t count, CornerResponse* responses);

}  // namespace aqorb
}  // namespace cv

#endif
