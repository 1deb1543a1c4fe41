// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#ifndef OPENCV_AQORB_TEST_FEATURES_HPP
#define OPENCV_AQORB_TEST_FEATURES_HPP

#include <opencv2/core.hpp>

#include <vector>

namespace opencv_test
{

//! What detectAndCompute gives for one image.
struct Features
{
    std::vector<cv::KeyPoint> keypoints;
    cv::Mat descriptors;
};

}  // namespace opencv_test

#endif
