// This file is part of the aqorb project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.

#ifndef OPENCV_AQORB_FUZZ_GENERATE_HPP
#define OPENCV_AQORB_FUZZ_GENERATE_HPP

#include <fuzzer/FuzzedDataProvider.h>
#include <opencv2/core.hpp>

#include <vector>

// What the fuzz targets make of the bytes that libFuzzer gives them.

namespace fuzz
{

//! Mostly within [low, high], at times any number or one of those where arithmetic breaks.
int number(FuzzedDataProvider& data, int low, int high);
double real(FuzzedDataProvider& data, double low, double high);

//! A matrix of one of several kinds of contents, at times a part of a larger one.
cv::Mat matrix(FuzzedDataProvider& data, cv::Size size, int type);

//! An image of at most maxSide pixels a side; where anyType is set it may be no image at all.
cv::Mat image(FuzzedDataProvider& data, int maxSide, bool anyType);

//! A mask of that size, or none; where anyType is set, of any size and type.
cv::Mat mask(FuzzedDataProvider& data, cv::Size size, bool anyType);

//! Keypoints in, around and far off an image of that size.
std::vector<cv::KeyPoint> keypoints(FuzzedDataProvider& data, cv::Size size);

}  // namespace fuzz

#endif
