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

//! Features of a left image that have a depth, and where they are, in coordinates of its camera and metres.
struct StereoFrame
{
    opencv_test::Features features;
    std::vector<cv::Point3d> points;
};

/** The depth of a feature comes from its match along the row of the right image.
 @param norm that compares descriptors */
StereoFrame triangulate(const StereoSequence& sequence, const opencv_test::Features& left,
                        const opencv_test::Features& right, int norm);

//! Mutual nearest neighbours of the features of two frames.
std::vector<cv::DMatch> matchFrames(const StereoFrame& earlier, const StereoFrame& later, int norm);

/** The motion between two frames of a sequence: that under which the points of the earlier one project onto their
 matches in the later one (PnP).
 @param earlierIndex, laterIndex of the frames in the sequence
 @param matches by matchFrames
 @param seed that orders the matches, of which random ones are tried; 0 leaves them as they are */
OdometryStep estimateMotion(const StereoSequence& sequence, const StereoFrame& earlier, size_t earlierIndex,
                            const StereoFrame& later, size_t laterIndex, std::vector<cv::DMatch> matches,
                            int seed = 0);

#endif
