// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#ifndef AQORB_EVALUATE_MEASURES_HPP
#define AQORB_EVALUATE_MEASURES_HPP

#include "../../test/features.hpp"
#include "../../test/matches.hpp"

//! How the features of two images of a plane match. Distances are in pixels of the second image.
struct Matching
{
    int matches;                 //!< mutual nearest neighbours
    int correct;                 //!< of these within 3 pixels of the homography
    int distinct;                //!< of these the ones that are 4 pixels away from every better one
    int places;                  //!< cells of a 16x12 grid over the first image that hold a correct match
    double repeatability;        //!< share found again within 3 pixels, of keypoints in the common part
    std::vector<double> errors;  //!< of the corners under the estimated homography, for each seed

    double precision() const { return matches ? double(correct) / matches : 0; }
};

//! The counts of matches whose correct ones are known; repeatability and errors stay empty.
Matching countMatches(const opencv_test::Matches& matches, const std::vector<size_t>& correct,
                      cv::Size sizeA);

/** The errors in pixels of the corners of an image under the homographies estimated from the matches, one for
 each seed. */
std::vector<double> homographyErrors(const opencv_test::Matches& matches, const cv::Mat& homography,
                                     cv::Size sizeA, int seeds);

/** Area under the curve of the share of homographies whose error is below a limit, for limits from 0 to this one;
 1 is perfect. */
double areaUnderCurve(const std::vector<double>& errors, double limit);

Matching measureMatching(const opencv_test::Features& a, const opencv_test::Features& b, int norm,
                         const cv::Mat& homography, cv::Size sizeA, cv::Size sizeB, int seeds);

#endif
