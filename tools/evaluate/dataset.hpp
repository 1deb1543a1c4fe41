// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#ifndef AQORB_EVALUATE_DATASET_HPP
#define AQORB_EVALUATE_DATASET_HPP

#include <opencv2/core.hpp>

#include <string>
#include <vector>

//! A set of the Oxford affine covariant regions data: images of one scene and the homographies between them.
struct ImageSet
{
    std::string name;
    std::vector<cv::Mat> images;        // in colour, as the paper read them: grey ones give other counts
    std::vector<cv::Mat> homographies;  // from the first image to each; [0] is the identity
};

//! Reads FOLDER/NAME/img1..6.{png,ppm,pgm} and H1to2p..6p (text) or H1to2p.xml...
ImageSet readSet(const std::string& folder, const std::string& name);

//! The names of the ways in which images are made worse: dark, gamma, noise.
std::vector<std::string> degradations();

//! The set with each image made worse. The name of the result is NAME/DEGRADATION.
ImageSet degrade(const ImageSet& set, const std::string& degradation);

#endif
