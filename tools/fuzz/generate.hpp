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

// Generators of arguments from libFuzzer's bytes.

extern "C" int LLVMFuzzerInitialize(int*, char***);
extern "C" int LLVMFuzzerTestOneInput(const uint8_t* bytes, size_t size);

namespace fuzz
{

//! Reports a finding to libFuzzer unless the condition holds.
void require(bool condition, const std::string& what);

//! Whether a call gives a result. Otherwise its exception must state the accepted values.
template <typename Call, typename... Arguments> bool isCalled(const Call& call, Arguments&&... arguments)
{
    try
    {
        call(arguments...);
    }
    catch (const cv::Exception& e)
    {
        require(e.err.find(" must ") != std::string::npos, e.what());
        return false;
    }
    return true;
}

//! A number, mostly within [low, high]; at times any number, or a number at the limits of arithmetic.
int number(FuzzedDataProvider& data, int low, int high);
double real(FuzzedDataProvider& data, double low, double high);

//! A matrix with one of several kinds of contents; at times a part of a larger matrix.
cv::Mat matrix(FuzzedDataProvider& data, cv::Size size, int type);

//! An image of at most maxSide pixels a side. With anyType its type and dimensions may be invalid for an image.
cv::Mat image(FuzzedDataProvider& data, int maxSide, bool anyType);

//! A mask of this size, or an empty mask. With anyType its size and type may be invalid for a mask.
cv::Mat mask(FuzzedDataProvider& data, cv::Size size, bool anyType);

//! Keypoints inside, around and far from an image of this size.
std::vector<cv::KeyPoint> keypoints(FuzzedDataProvider& data, cv::Size size);

}  // namespace fuzz

#endif
