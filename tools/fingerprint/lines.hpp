// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#ifndef AQORB_FINGERPRINT_LINES_HPP
#define AQORB_FINGERPRINT_LINES_HPP

#include <opencv2/aqorb.hpp>

#include <string>

/** Lines of aqorb_fingerprint, one for each scene or image and each set of parameters. Parameters are drawn at random
 in the order of the calls: first scenes, then image for each image. */
class FingerprintLines
{
public:
    explicit FingerprintLines(cv::aqorb::AdaptiveQuadtreeORB::SelectionType selection_)
        : rng(20191), selection(selection_)
    {
    }
    //! Lines of 60 drawn scenes.
    std::string scenes();
    //! Two lines of an image.
    std::string image(const std::string& name, const cv::Mat& image);

private:
    cv::RNG rng;
    cv::aqorb::AdaptiveQuadtreeORB::SelectionType selection;
};

#endif
