// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#ifndef AQORB_EVALUATE_STEREO_ODOMETRY_HPP
#define AQORB_EVALUATE_STEREO_ODOMETRY_HPP

#include "../../test/features.hpp"

#include <string>

// What a detector's features are worth to visual odometry, measured from frame to frame.

//! Rectified image pairs and where they were taken.
struct StereoSequence
{
    std::vector<std::string> left, right;  // files
    std::vector<cv::Matx44d> poses;        // from the left camera to the world, one a pair
    cv::Matx33d camera;
    double baseline;  // in metres
};

/** Reads a folder laid out as KITTI's: calib.txt (P0 and P1, with or without these labels), poses.txt and the
 images in image_0 and image_1, or image_l and image_r. */
StereoSequence readStereoSequence(const std::string& folder);

//! The motion from one frame to the next.
struct OdometryStep
{
    int points = 0;   // features of the later left image that have a depth
    int matches = 0;  // of these with the points of the earlier frame
    int inliers = 0;  // matches that agree with the motion
    bool found = false;
    double metres = 0, degrees = 0;  // error of the motion that was found
};

/** Follows a sequence. The depth of a feature comes from its match along the row of the right image; the motion
 is that under which the points of one frame project onto their matches in the next (PnP). */
class StereoOdometry
{
public:
    //! @param norm that compares descriptors
    StereoOdometry(const StereoSequence& sequence, int norm);

    //! Takes the features of the next pair. The step is an empty one for the first pair.
    OdometryStep add(const opencv_test::Features& left, const opencv_test::Features& right);

private:
    //! Features of a left image and where they are, in coordinates of its camera and metres.
    struct Frame
    {
        opencv_test::Features features;
        std::vector<cv::Point3d> points;
    };

    Frame triangulate(const opencv_test::Features& left, const opencv_test::Features& right) const;
    bool estimateMotion(const Frame& later, OdometryStep& step, cv::Matx44d& motion) const;

    const StereoSequence& sequence;
    const int norm;
    Frame earlier;
    size_t count = 0;  // of pairs taken
};

#endif
