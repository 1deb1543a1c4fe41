// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#ifndef AQORB_PROFILE_MEASURE_HPP
#define AQORB_PROFILE_MEASURE_HPP

#include "../common/csv.hpp"

#include <opencv2/aqorb.hpp>

#include <algorithm>
#include <string>
#include <vector>

struct Image
{
    //! @param spec WIDTHxHEIGHT draws a scene; others are a photograph of opencv_extra by its short name, or a file.
    explicit Image(const std::string& spec);

    std::string spec;
    std::string name;  //!< with the size
    cv::Mat pixels;
};

struct Settings
{
    std::vector<std::string> images;
    int nfeatures;
    int repeats;         //!< frames to measure
    std::string beside;  //!< library of another build that is measured, too; empty: none
};

//! Of measureProgram.
struct ProgramSettings : Settings
{
    std::vector<int> numbers;            //!< of features
    std::vector<int> threads;            //!< numbers of them
    std::vector<std::string> cases;      //!< turns, cold, warm, stream, avx2
    int passes;                          //!< over all images and numbers
    std::vector<std::string> arguments;  //!< of this program, without the cases

    bool has(const std::string& name) const
    {
        return std::find(cases.begin(), cases.end(), name) != cases.end();
    }
};

enum Detector
{
    CV_ORB,
    AQORB
};

//! As the harness of perf/ names it.
const char* nameOf(Detector detector);

cv::Ptr<cv::Feature2D> createDetector(Detector detector, int nfeatures);

//! Features of a frame; outputs are kept from frame to frame, as programs do.
struct Features
{
    std::vector<cv::KeyPoint> keypoints;
    cv::Mat descriptors;
};

const int WARM_UP = 3;  //!< frames that --frames runs before those that count

//! Seconds that detectAndCompute takes.
double timeFrame(cv::Feature2D& detector, const cv::Mat& image, Features& features);

tools::CsvTable measureSetting(const Settings& settings);
tools::CsvTable measureStages(const Settings& settings);
tools::CsvTable measureMemory(const Settings& settings);
//! Times of frames in a program that does other work, too.
tools::CsvTable measureProgram(const ProgramSettings& settings);

#endif
