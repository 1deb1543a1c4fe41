// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#ifndef AQORB_EVALUATE_STEREO_ODOMETRY_HPP
#define AQORB_EVALUATE_STEREO_ODOMETRY_HPP

#include "../../samples/stereo_odometry.hpp"
#include "../../test/features.hpp"

// What a detector's features are worth to visual odometry, measured from frame to frame by the means of the sample.

//! A sequence whose poses are known.
StereoSequence readPosedSequence(const std::string& folder);

//! The motion from one frame to the next.
struct OdometryStep
{
    int points = 0;   // features of the later left image that have a depth
    int matches = 0;  // of these with the points of the earlier frame
    int inliers = 0;  // matches that agree with the motion
    bool found = false;
    double metres = 0, degrees = 0;  // error of the motion that was found
};

//! The features of a left image that have a depth, by those of the right one.
StereoFrame triangulate(const StereoSequence& sequence, const opencv_test::Features& left,
                        const opencv_test::Features& right, int norm);

/** The motion between two frames of a sequence and its error.
 @param earlierIndex, laterIndex of the frames in the sequence
 @param matches by matchFrames
 @param seed that orders the matches, of which random ones are tried; 0 leaves them as they are */
OdometryStep estimateMotion(const StereoSequence& sequence, const StereoFrame& earlier, size_t earlierIndex,
                            const StereoFrame& later, size_t laterIndex, std::vector<cv::DMatch> matches,
                            int seed = 0);

#endif
