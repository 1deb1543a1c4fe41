// This file is part of the aqorb project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.

// How aqorb_demo.cpp and stereo_odometry.cpp take their arguments and end.

#ifndef AQORB_SAMPLES_PROGRAM_HPP
#define AQORB_SAMPLES_PROGRAM_HPP

#include <opencv2/core.hpp>
#include <opencv2/core/utility.hpp>
#include <opencv2/imgcodecs.hpp>

#include <cstdio>

//! What ends a program: 1 bad arguments, 2 an input cannot be read, 3 a picture cannot be written.
struct Failure
{
    int exitCode;
    cv::String message;
};

//! Runs a program; gives its exit code, 4 for any other exception. Prints what it fails by.
inline int runProgram(const char* name, void (*run)(int, char**), int argc, char** argv)
{
    try
    {
        run(argc, argv);
        return 0;
    }
    catch (const Failure& failure)
    {
        std::fprintf(stderr, "%s: %s\n", name, failure.message.c_str());
        return failure.exitCode;
    }
    catch (const std::exception& exception)
    {
        std::fprintf(stderr, "%s: %s\n", name, exception.what());
        return 4;
    }
}

//! The option nfeatures.
inline int featureCount(const cv::CommandLineParser& parser)
{
    const cv::String text = parser.get<cv::String>("nfeatures");
    const int count = parser.get<int>("nfeatures");  // would read 12abc as 12
    if (!parser.check() || count < 1 || text.find_first_not_of("0123456789") != cv::String::npos)
        throw Failure{1, "--nfeatures=" + text + ": a whole number >= 1 is accepted"};
    return count;
}

inline cv::Mat readGrayImage(const cv::String& path)
{
    const cv::Mat image = cv::imread(path, cv::IMREAD_GRAYSCALE);
    if (image.empty())
        throw Failure{2, path + ": not an image that OpenCV can read"};
    return image;
}

#endif
