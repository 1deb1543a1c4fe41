// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#ifndef AQORB_EVALUATE_DATASET_HPP
#define AQORB_EVALUATE_DATASET_HPP

#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

#include <string>
#include <vector>

//! A set of the Oxford affine covariant regions data: images of one scene and the homographies between them.
struct ImageSet
{
    std::string name;
    std::vector<cv::Mat> images;        // in colour as the paper read them, unless asked for in grey
    std::vector<cv::Mat> homographies;  // from the first image to each; [0] is the identity
};

/** Reads FOLDER/NAME/img1..6.{png,ppm,pgm,jpg} and H1to2p..6p (text) or H1to2p.xml...
 @param flags cv::IMREAD_COLOR or cv::IMREAD_GRAYSCALE: the two give other counts */
ImageSet readSet(const std::string& folder, const std::string& name, int flags = cv::IMREAD_COLOR);

//! An image at another scale, by cv::INTER_AREA below 1 and by cv::INTER_CUBIC above, and where its points went.
struct ScaledImage
{
    cv::Mat image, homography;
};

ScaledImage scaleImage(const cv::Mat& image, double scale);

//! Two grey images of a scene, and the one or the other matrix between them; the other is empty.
struct ImagePair
{
    std::string name;
    cv::Mat first, second, homography, fundamental;
};

//! Reads FOLDER/NAME/img1, img2 and H1to2p or F1to2p of all names, in alphabetical order: see scripts/held_out.sh.
std::vector<ImagePair> readPairs(const std::string& folder);

//! The names of the ways in which images are made worse: dark, gamma, noise, blur, shrunk, enlarged.
std::vector<std::string> degradations();

//! The set with each image made worse; shrunk and enlarged leave the first one as it is. The name of the result is NAME/DEGRADATION.
ImageSet degrade(const ImageSet& set, const std::string& degradation);

#endif
