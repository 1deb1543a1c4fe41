// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#ifndef AQORB_CLAIMS_SUBJECTS_HPP
#define AQORB_CLAIMS_SUBJECTS_HPP

#include "../../../test/matches.hpp"
#include "../dataset.hpp"
#include "../method.hpp"
#include "../stereo_odometry.hpp"
#include "measurements.hpp"

// What is measured of a method. Each function adds measurements of one subject.

/** Of each image (SET/1) the uniformity and the occupancy; of each pair (SET/1-2) distinct, places, precision and,
 with seeds, auc5, the area under the curve of homographies up to 5 pixels. */
void measureSet(const std::string& subject, const ImageSet& set, Method& method, int n, int seeds,
                Measurements& results);

//! Of each image only the uniformity and the occupancy.
void measureUniformity(const std::string& subject, const ImageSet& set, Method& method, int n,
                       Measurements& results);

/** Of an image rolled about its centre by these degrees (NAME/15): distinct, places, precision.
 @param scale of the image that is rolled; the other one stays as it is */
void measureRolled(const std::string& subject, const std::string& name, const cv::Mat& image,
                   const std::vector<int>& angles, double scale, Method& method, int n,
                   Measurements& results);

//! Of an image and itself at each scale: distinct, places, precision. The subject is that of subjectOfScale.
void measureScaled(const std::string& name, const cv::Mat& image, const std::vector<double>& scales,
                   Method& method, int n, Measurements& results);

//! Such as "scale 0.5".
std::string subjectOfScale(double scale);

//! Of an object in a scene: matches that pass the ratio test of 0.75, and inliers within 5 pixels of a homography.
void measureFindObject(const cv::Mat& object, const cv::Mat& scene, Method& method, int n,
                       Measurements& results);

//! Of each pair as of a set. With a fundamental matrix a match is right that agrees with it, and there is no auc5.
void measureHeldOut(const std::vector<ImagePair>& pairs, Method& method, int n, int seeds,
                    Measurements& results);

/** Of gaps of 1, 2 and 3 frames and each seed (GAP/SEED) the median errors of the motion, in metres and degrees; a
 step without motion counts as an infinite error. Also the same of steps drawn at random with replacement, the same
 ones for each method: their spread is what the choice of the frames adds. */
void measureStereo(const StereoSequence& sequence, Method& method, int n, int seeds, Measurements& results);

/** What a single camera starts from, of each frame with the one after it (1/FRAME) and with the one a second later
 (10/FRAME): the matches of the finest level, and how many of them are correct. */
void measureStart(const StereoSequence& sequence, Method& method, int n, Measurements& results);

//! The methods in turns on one thread; of each image the median milliseconds of a method's CPU time.
void measureCost(const std::vector<ImageSet>& sets, const std::vector<cv::Ptr<Method>>& methods, int n,
                 int runs, Measurements& results);

#endif
