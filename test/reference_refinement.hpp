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

//! Where the alignment starts: the position in image 2, and the map from image 1 to image 2 around it.
struct ReferenceStart
{
    cv::Point2d position;
    cv::Matx22d map;
};

struct ReferenceAlignment
{
    bool isAligned;
    cv::Point2d position;  //!< in image 2; that of the start if the patches cannot be aligned
    cv::Matx22d map;       //!< from image 1 to image 2
    double correlation;
    double deviation;
};

//! The start of a match, from the sizes and the angles of its keypoints.
ReferenceStart referenceStart(const cv::KeyPoint& keypoint1, const cv::KeyPoint& keypoint2);

//! The alignment of patches in grey images by the formulas, in double precision.
ReferenceAlignment referenceAlignment(const cv::Mat& image1, const cv::KeyPoint& keypoint1,
                                      const cv::Mat& image2, const ReferenceStart& start, double scaleFactor);

}  // namespace opencv_test

#endif
