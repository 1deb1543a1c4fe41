// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#ifndef OPENCV_AQORB_MATCH_INPUT_HPP
#define OPENCV_AQORB_MATCH_INPUT_HPP

#include <opencv2/core.hpp>

namespace cv
{
namespace aqorb
{

// The checks of what matchers are given. Each throws an exception that names what is wrong.

//! Accepts NORM_HAMMING and NORM_HAMMING2.
void checkHammingNorm(int normType);
//! Accepts a matrix of type CV_8UC1, also an empty one.
void checkDescriptors(const char* name, InputArray descriptors);
//! Accepts what checkDescriptors does if it is as wide as the queries.
void checkTrainDescriptors(const char* name, InputArray descriptors, const char* queryName,
                           InputArray queryDescriptors);
//! Accepts queryDescriptors and trainDescriptors of the same width, or of which one is empty, and a Hamming norm.
void checkMatchInput(InputArray queryDescriptors, InputArray trainDescriptors, int normType);

}  // namespace aqorb
}  // namespace cv

#endif
