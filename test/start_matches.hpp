// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#ifndef OPENCV_AQORB_TEST_START_MATCHES_HPP
#define OPENCV_AQORB_TEST_START_MATCHES_HPP

#include "features.hpp"

// How a SLAM system with one camera matches frames before it knows anything of the scene. Written from the description
// in the paper of ORB-SLAM. Programs can include it, too.

namespace opencv_test
{

struct PointPair
{
    cv::Point2f from, to;
};

//! The features of the finest level: a start needs no other ones.
Features finestLevel(const Features& features);

/** Matches between keypoints of the finest level of two frames: the nearest descriptor within 100 pixels along x and y,
 if it is clearly nearer than the second, and if the turn from one keypoint to the other is one that many matches have.
 A keypoint of the later frame is in one match only, the nearer one. */
std::vector<PointPair> matchToStart(const Features& reference, const Features& later);

//! The fundamental matrix between two frames of a camera.
//! @param motion from coordinates of the first frame to those of the second
cv::Matx33d fundamentalMatrix(const cv::Matx33d& camera, const cv::Matx44d& motion);

//! Whether a match lies within 2 pixels of the epipolar line of its first point.
bool isOnEpipolarLine(const PointPair& match, const cv::Matx33d& fundamental);

}  // namespace opencv_test

#endif
