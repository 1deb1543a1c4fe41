// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// Measures AdaptiveQuadtreeORB and HammingMatcher in turns with others, and prints Markdown: see doc/performance.md.

#include "benchmark.hpp"

#include <opencv2/core/utility.hpp>

#include <algorithm>
#include <cstdlib>
#include <iostream>
#include <sstream>
#include <stdexcept>

namespace
{

const char* const ABOUT =
    "Measures speed with default parameters, in turns with others, and prints Markdown.\n"
    "  speed [IMAGE ...]          frames beside cv::ORB\n"
    "  beside LIBRARY [IMAGE ...] frames beside another build, named by its libaqorb.so\n"
    "  pair [IMAGE1 IMAGE2]       from two images to a homography, beside cv::ORB with cv::BFMatcher\n"
    "  refinement [IMAGE1 IMAGE2] refineMatches beside cv::calcOpticalFlowPyrLK with the same window\n"
    "  matching                   HammingMatcher beside cv::BFMatcher, descriptors of 32 bytes\n"
    "  program                    cv::BFMatcher alone, for LD_PRELOAD\n"
    "An IMAGE is a file, WIDTHxHEIGHT for a drawn scene, or a photograph of opencv_extra whose folder "
    "testdata\n"
    "OPENCV_TEST_DATA_PATH names: bikes, leuven, bark, trees, ubc, 640x512.png, 1920x1080.png, which are "
    "measured\n"
    "unless others are named. OPENCV_CPU_DISABLE=AVX512-SKX leaves AVX-512 out, for all.\n"
    "Exit codes: 0 done, 1 bad arguments, 2 other.\n";

const char* const KEYS = "{help h usage ? |      | print this text }"
                         "{n              |      | numbers of features or descriptors; 500,1000,2000 unless "
                         "named, matching also 5000 }"
                         "{threads        | 1,2  | numbers of threads }"
                         "{turns          | 31   | how often each is measured }"
                         "{cold           |      | touch 64 MB of other memory before each frame }"
                         "{@command       |      | what to measure }"
                         "{@rest          |      | images }";

//! Thrown where arguments are not accepted.
struct BadArguments : std::runtime_error
{
    explicit BadArguments(const std::string& message) : std::runtime_error(message + "; see --help") {}
};

std::vector<std::string> splitList(const std::string& list)
{
    std::vector<std::string> parts;
    std::istringstream stream(list);
    for (std::string part; std::getline(stream, part, ',');)
        parts.push_back(part);
    return parts;
}

//! Whole numbers above 0.
std::vector<int> splitNumbers(const std::string& list)
{
    std::vector<int> numbers;
    for (const std::string& number : splitList(list))
    {
        numbers.push_back(std::atoi(number.c_str()));
        if (numbers.back() < 1)
            throw BadArguments("'" + number + "': a number above 0 is accepted");
    }
    return numbers;
}

//! The arguments that are no options. cv::CommandLineParser passes over options that it does not know.
std::vector<std::string> positional(int argc, const char* const* argv)
{
    std::vector<std::string> found;
    for (int i = 1; i < argc; i++)
    {
        const std::string argument = argv[i], name = argument.substr(0, argument.find('='));
        if (argument[0] != '-')
            found.push_back(argument);
        else if (name != "--n" && name != "--threads" && name != "--turns" && name != "--cold")
            throw BadArguments(argument + ": unknown option");
    }
    return found;
}

void run(const cv::CommandLineParser& parser, std::vector<std::string> images)
{
    const std::string command = images.empty() ? "" : images[0], numbers = parser.get<cv::String>("n");
    images.erase(images.begin(), images.begin() + !images.empty());
    Settings settings;
    settings.numbers = splitNumbers(!numbers.empty()        ? numbers
                                    : command == "matching" ? "500,1000,2000,5000"
                                                            : "500,1000,2000");
    settings.threads = splitNumbers(parser.get<cv::String>("threads"));
    settings.turns = splitNumbers(parser.get<cv::String>("turns")).at(0);
    settings.cold = parser.has("cold");
    Contender other = orb();
    if (command == "beside")
    {
        if (images.empty())
            throw BadArguments("beside which LIBRARY?");
        other = aqorbOf(images[0]);
        images.erase(images.begin());
    }
    const bool isOfPairs = command == "pair" || command == "refinement";
    if (images.empty() && !isOfPairs)
        images = splitList(std::getenv("OPENCV_TEST_DATA_PATH")
                               ? "bikes,leuven,bark,trees,ubc,640x512.png,1920x1080.png"
                               : "640x480,1920x1080");
    settings.images = images;

    if (command == "speed" || command == "beside")
        measureSpeed(settings, other);
    else if (isOfPairs && images.size() != 2 && (!images.empty() || !std::getenv("OPENCV_TEST_DATA_PATH")))
        throw BadArguments(command + ": name two images, or set OPENCV_TEST_DATA_PATH");
    else if (command == "pair")
        measurePairs(settings);
    else if (command == "refinement")
        measureRefinement(settings);
    else if (command == "matching")
        measureMatching(settings);
    else if (command == "program")
        measureProgram(settings);
    else
        throw BadArguments("'" + command + "': speed, beside, pair, refinement, matching or program");
}

}  // namespace

int main(int argc, char** argv)
{
    try
    {
        cv::CommandLineParser parser(argc, argv, KEYS);
        parser.about(ABOUT);
        if (parser.has("help"))
            parser.printMessage();
        else
            run(parser, positional(argc, argv));
        return 0;
    }
    catch (const BadArguments& bad)
    {
        std::cerr << "aqorb_benchmark: " << bad.what() << std::endl;
        return 1;
    }
    catch (const cv::Exception& error)
    {
        std::cerr << "aqorb_benchmark: " << error.err << std::endl;
    }
    catch (const std::exception& error)
    {
        std::cerr << "aqorb_benchmark: " << error.what() << std::endl;
    }
    return 2;
}
