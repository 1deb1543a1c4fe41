// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#ifndef OPENCV_AQORB_REFERENCE_REFINEMENT_HPP
#define OPENCV_AQORB_REFERENCE_REFINEMENT_HPP

#include <opencv2/aqorb/features.hpp>
#include <opencv2/core.hpp>

namespace opencv_test
{

struct ReferenceAlignment
{
    bool isAligned;
    cv::Point2d position;  //!< in image 2; of the keypoint if the patches cannot be aligned
    double correlation;
};

//! The alignment of the patches of a match in grey images by the formulas, in double precision.
ReferenceAlignment referenceAlignment(const cv::Mat& image1, const cv::KeyPoint& keypoint1,
                                      const cv::Mat& image2, const cv::KeyPoint& keypoint2,
                                      double scaleFactor);

}  // namespace opencv_test

#endif
