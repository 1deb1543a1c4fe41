// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#ifndef AQORB_BENCHMARK_HPP
#define AQORB_BENCHMARK_HPP

#include <opencv2/features2d.hpp>

#include <functional>
#include <string>
#include <vector>

//! What detectAndCompute gives for one image.
struct Features
{
    std::vector<cv::KeyPoint> keypoints;
    cv::Mat descriptors;
};

struct Image
{
    //! @param spec WIDTHxHEIGHT draws a scene; others are a photograph of opencv_extra by its short name, or a file.
    explicit Image(const std::string& spec);

    std::string name;  //!< with the size
    cv::Mat pixels;
};

//! Path of an image of a set of opencv_extra, such as bikes; OPENCV_TEST_DATA_PATH names its folder.
std::string imageOfSet(const std::string& set, int index);

//! A kind of detector that is measured beside others.
struct Contender
{
    std::string name;
    std::function<cv::Ptr<cv::Feature2D>(int nfeatures)> create;  //!< with default parameters otherwise
};

Contender orb();
Contender aqorbHere();
/** AdaptiveQuadtreeORB of another build.
 @param library file of that build's shared library. It is never unloaded.
 Throws cv::Exception where this is not such a library. */
Contender aqorbOf(const std::string& library);

//! What the subcommands have in common.
struct Settings
{
    std::vector<std::string> images;
    std::vector<int> numbers;  //!< of features or descriptors
    std::vector<int> threads;  //!< numbers of them
    int turns;                 //!< how often each is measured
    bool cold;                 //!< touch other memory before each call
};

//! Milliseconds that detectAndCompute takes. Outputs are kept from frame to frame, as programs do.
double timeFrame(cv::Feature2D& detector, const cv::Mat& image, Features& features);

//! Milliseconds that some work takes.
double milliseconds(const std::function<void()>& work);

//! Reads and writes 64 MB, which drives what is measured out of the caches.
void touchOtherMemory();

//! The best instructions that OpenCV and this module use here.
std::string cpuName();

//! Of an even number of values the mean of the middle two.
double median(std::vector<double> values);

double geometricMean(const std::vector<double>& ratios);

/** The median ratio of the times of two works, measured in turns of which every other one begins with the second.
 @param medians the median times of both, if wanted */
double medianRatio(const std::function<double()>& first, const std::function<double()>& second, int turns,
                   double* medians = NULL);

// Each prints its tables.
void measureSpeed(const Settings& settings, const Contender& other);
void measurePairs(const Settings& settings);
void measureMatching(const Settings& settings);
void measureRefinement(const Settings& settings);
void measureProgram(const Settings& settings);

#endif
