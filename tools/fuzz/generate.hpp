// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#ifndef OPENCV_AQORB_FUZZ_GENERATE_HPP
#define OPENCV_AQORB_FUZZ_GENERATE_HPP

#include <fuzzer/FuzzedDataProvider.h>
#include <opencv2/core.hpp>

#include <string>
#include <vector>

// The arguments that the fuzz targets make of libFuzzer's bytes.

namespace fuzz
{

//! Ends the program with a find unless the condition holds.
void require(bool condition, const std::string& what);

//! A number, mostly within [low, high]; at times any number, or one at which arithmetic is prone to fail.
int number(FuzzedDataProvider& data, int low, int high);
double real(FuzzedDataProvider& data, double low, double high);

//! A matrix with one of several kinds of contents; at times it is a part of a larger one.
cv::Mat matrix(FuzzedDataProvider& data, cv::Size size, int type);

//! An image of at most maxSide pixels a side. With anyType its type and dimensions may be wrong for an image.
cv::Mat image(FuzzedDataProvider& data, int maxSide, bool anyType);

//! A mask of this size, or an empty one. With anyType its size and type may be wrong for a mask.
cv::Mat mask(FuzzedDataProvider& data, cv::Size size, bool anyType);

//! Keypoints inside, around and far off an image of this size.
std::vector<cv::KeyPoint> keypoints(FuzzedDataProvider& data, cv::Size size);

}  // namespace fuzz

#endif
