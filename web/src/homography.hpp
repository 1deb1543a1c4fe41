// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#ifndef AQORB_WEB_HOMOGRAPHY_HPP
#define AQORB_WEB_HOMOGRAPHY_HPP

#include <opencv2/core.hpp>

#include <vector>

//! Whether a homography maps `from` to within `distance` pixels of `to`.
bool agrees(const cv::Matx33d& homography, const cv::Point2f& from, const cv::Point2f& to, double distance);

/** The homography on which most pairs of points agree within 3 pixels, by RANSAC and then by least squares over those
 pairs. OpenCV's own is in its module calib3d, which the page does without.
 @param homography is set if true is returned
 @return false if fewer than 10 pairs agree: four always do, and a few more may by chance. */
bool findHomography(const std::vector<cv::Point2f>& from, const std::vector<cv::Point2f>& to,
                    cv::Matx33d& homography);

#endif
