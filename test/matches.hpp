// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#ifndef OPENCV_AQORB_TEST_MATCHES_HPP
#define OPENCV_AQORB_TEST_MATCHES_HPP

#include "features.hpp"

#include <opencv2/aqorb/features.hpp>

// How well the features of two images of a plane match. This needs OpenCV's module calib3d, or geometry in OpenCV
// 5, but no test framework, so that programs can include it, too.

namespace opencv_test
{

//! The positions of matches in both images, the best match first.
struct Matches
{
    std::vector<cv::Point2f> from, to;
};

//! The fastest matcher of a norm. All of them find the same matches.
cv::Ptr<cv::BFMatcher> makeMatcher(int norm, bool crossCheck);

//! Mutual nearest neighbours by the norm of the descriptors.
Matches matchFeatures(const Features& a, const Features& b, int norm = cv::NORM_HAMMING);

//! Indices of the matches within 3 pixels of the homography, in pixels of the second image.
std::vector<size_t> correctMatches(const Matches& matches, const cv::Mat& homography);

/** Indices of the matches that agree with a fundamental matrix: each point is within 3 pixels of the epipolar line
 of the other. Chance alone lets some per cent of wrong matches agree. */
std::vector<size_t> matchesOnEpipolarLines(const Matches& matches, const cv::Mat& fundamental);

/** Those of the correct matches, given by their indices in ascending order, that are at least 4 pixels away from
 every better one in both images: two keypoints on one corner of the scene say no more about it than one. */
std::vector<size_t> distinctMatches(const Matches& matches, const std::vector<size_t>& correct);

//! distinctMatches of correctMatches.
std::vector<size_t> distinctCorrectMatches(const Matches& matches, const cv::Mat& homography);

//! What homographyError gives where the matches yield no homography.
const double NO_HOMOGRAPHY = 1e6;

/** Estimates the homography from the matches. Gives the mean distance in pixels between the corners of the
 first image mapped by it and by the known one, at most NO_HOMOGRAPHY.
 @param seed of the random samples */
double homographyError(const Matches& matches, const cv::Mat& homography, cv::Size size, int seed);

}  // namespace opencv_test

#endif
