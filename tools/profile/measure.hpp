// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#ifndef AQORB_PROFILE_MEASURE_HPP
#define AQORB_PROFILE_MEASURE_HPP

#include "../../test/features.hpp"
#include "../common/csv.hpp"

#include <opencv2/features2d.hpp>

#include <functional>
#include <string>
#include <vector>

using opencv_test::Features;

struct Image
{
    //! @param spec WIDTHxHEIGHT draws a scene; others are a photograph of opencv_extra by its short name, or a file.
    explicit Image(const std::string& spec);

    std::string name;  //!< with the size
    cv::Mat pixels;
};

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

struct Settings
{
    std::vector<std::string> images;
    int nfeatures;
    std::string beside;  //!< library of another build that is measured, too; empty: none
};

//! Of measureProgram.
struct ProgramSettings : Settings
{
    std::vector<int> numbers;            //!< of features
    std::vector<int> threads;            //!< numbers of them
    std::vector<std::string> cases;      //!< turns, cold, warm, stream, avx2
    int passes;                          //!< over all images and numbers
    int calls;                           //!< of a detector in a pass
    std::vector<std::string> arguments;  //!< of this program, without the cases
};

//! Seconds that detectAndCompute takes. Outputs are kept from frame to frame, as programs do.
double timeFrame(cv::Feature2D& detector, const cv::Mat& image, Features& features);

tools::CsvTable measureMemory(const Settings& settings);
//! Times of frames in a program that does other work, too.
tools::CsvTable measureProgram(const ProgramSettings& settings);

#endif
