// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// What the samples share: arguments, files, and a sentence for each that is wrong.

#ifndef AQORB_SAMPLES_SAMPLE_HPP
#define AQORB_SAMPLES_SAMPLE_HPP

#include <opencv2/core/utility.hpp>
#include <opencv2/core/utils/filesystem.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#if CV_VERSION_MAJOR >= 5
#include <opencv2/geometry.hpp>
#else
#include <opencv2/calib3d.hpp>
#endif

#include <algorithm>
#include <cstdlib>
#include <iostream>
#include <set>
#include <vector>

//! Parses the options. Where they ask for help or are wrong, the program says so and ends.
inline cv::CommandLineParser parseOptions(int argc, char** argv, const cv::String& keys,
                                          const cv::String& about)
{
    cv::CommandLineParser parser(argc, argv, keys);
    parser.about(about);
    if (parser.has("help"))
    {
        parser.printMessage();
        std::exit(0);
    }
    for (int i = 1; i < argc; i++)  // CommandLineParser ignores unknown options
    {
        const cv::String argument = argv[i];
        cv::String name = argument.substr(0, argument.find('='));
        name.erase(0, name.find_first_not_of('-'));
        if (argument[0] == '-' && keys.find("{" + name + " ") == cv::String::npos)
        {
            std::cerr << argument << ": there is no such option; --help lists those that there are\n";
            std::exit(1);
        }
    }
    return parser;
}

//! Value of an option. An invalid value ends the program with a message.
template <typename T> T option(const cv::CommandLineParser& parser, const char* name)
{
    const T value = parser.get<T>(name);
    if (!parser.check())
    {
        parser.printErrors();
        std::exit(1);
    }
    return value;
}

//! Arguments that are not options.
inline std::vector<cv::String> fileArguments(int argc, char** argv)
{
    std::vector<cv::String> files;
    for (int i = 1; i < argc; i++)
        if (argv[i][0] != '-')
            files.push_back(argv[i]);
    return files;
}

//! Reads a file, or one of OpenCV's samples in the folder that OPENCV_SAMPLES_DATA_PATH names.
inline cv::Mat readImage(const cv::String& name, int flags = cv::IMREAD_GRAYSCALE)
{
    const cv::String file = cv::samples::findFile(name, false, true);
    if (file.empty())
        CV_Error(cv::Error::StsObjectNotFound,
                 name + ": there is no such file (OpenCV's sample images: "
                        "export OPENCV_SAMPLES_DATA_PATH=$(scripts/demo.sh --images))");
    const cv::Mat image = cv::imread(file, flags);
    if (image.empty())
        CV_Error(cv::Error::StsParseError, name + ": cannot be read as an image");
    return image;
}

inline void checkWritable(const cv::String& file, bool isWritable)
{
    if (!isWritable)
        CV_Error(cv::Error::StsError,
                 file + ": cannot be written; a name such as picture.jpg in an existing folder is accepted");
}

//! Picture to write: the option "out". Throws for a name that cannot be written, before the program does any work.
inline cv::String pictureOption(const cv::CommandLineParser& parser)
{
    const cv::String file = option<cv::String>(parser, "out");
    const size_t nameAt = file.find_last_of("/\\") + 1;  // npos + 1 is 0
    checkWritable(file, cv::haveImageWriter(file) &&
                            (nameAt == 0 || cv::utils::fs::isDirectory(file.substr(0, nameAt))));
    return file;
}

//! Two images whose grown matches agree with a homography in fewer places probably show different things.
const int MIN_PLACES = 10;

//! Elements whose flag is set.
template <typename T> std::vector<T> flagged(const std::vector<T>& values, const std::vector<uchar>& flags)
{
    std::vector<T> chosen;
    for (size_t i = 0; i < flags.size(); i++)
        if (flags[i])
            chosen.push_back(values[i]);
    return chosen;
}

//! Number of places of matches: cells of 16 x 16 pixels with a match, in the image that has fewer of them. Growth
//! multiplies wrong matches, too, but these crowd in few places.
inline int countPlaces(const std::vector<cv::Point2f>& points1, const std::vector<cv::Point2f>& points2)
{
    std::set<std::pair<int, int>> cells1, cells2;
    for (const cv::Point2f& point : points1)
        cells1.emplace(cvFloor(point.x / 16), cvFloor(point.y / 16));
    for (const cv::Point2f& point : points2)
        cells2.emplace(cvFloor(point.x / 16), cvFloor(point.y / 16));
    return int(std::min(cells1.size(), cells2.size()));
}

//! Adds a line of text above a picture.
inline cv::Mat captioned(const cv::Mat& picture, const cv::String& text,
                         const cv::Scalar& colour = cv::Scalar::all(0))
{
    cv::Mat result;
    cv::copyMakeBorder(picture, result, 34, 0, 0, 8, cv::BORDER_CONSTANT, cv::Scalar::all(255));
    cv::putText(result, text, cv::Point(8, 23), cv::FONT_HERSHEY_SIMPLEX, 0.65, colour, 1, cv::LINE_AA);
    return result;
}

//! Prints a table by columns. The first column holds the labels of the rows.
inline void printTable(const std::vector<std::vector<cv::String>>& columns)
{
    for (size_t row = 0; row < columns[0].size(); row++)
    {
        std::cout << cv::format("%-45s", columns[0][row].c_str());
        for (size_t i = 1; i < columns.size(); i++)
            std::cout << cv::format(" %19s", columns[i][row].c_str());
        std::cout << std::endl;
    }
}

inline void writePicture(const cv::String& file, const cv::Mat& picture)
{
    checkWritable(file, cv::imwrite(file, picture));
    std::cout << "Picture: " << file << std::endl;
}

//! Runs a sample. An exception becomes a sentence and the exit code 1.
inline int runSample(int (*sample)(int argc, char** argv), int argc, char** argv)
{
    try
    {
        return sample(argc, argv);
    }
    catch (const cv::Exception& exception)
    {
        std::cerr << exception.err << std::endl;
        return 1;
    }
}

#endif
