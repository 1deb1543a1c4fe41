// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#ifndef AQORB_PROFILE_CONTENDERS_HPP
#define AQORB_PROFILE_CONTENDERS_HPP

#include <opencv2/features2d.hpp>

#include <functional>
#include <string>
#include <vector>

//! A kind of detector that is measured beside others.
struct Contender
{
    std::string name;
    std::function<cv::Ptr<cv::Feature2D>(int nfeatures)> create;  //!< with default parameters otherwise
};

/** cv::ORB as CV_ORB, AdaptiveQuadtreeORB as AQORB, and that of another build of the library as BESIDE and its file's
 name.
 @param beside file of the other build's shared library; empty: none. It is never unloaded.
 Throws cv::Exception where this is not such a library. */
std::vector<Contender> makeContenders(const std::string& beside);

#endif
