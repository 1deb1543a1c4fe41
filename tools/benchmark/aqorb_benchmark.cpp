// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// Measures AdaptiveQuadtreeORB and HammingMatcher in turns with others, and prints Markdown: see doc/performance.md.

#include "benchmark.hpp"

#include "../common/program.hpp"

#include <opencv2/core/utility.hpp>

#include <algorithm>
#include <cstdlib>

using tools::splitList;

namespace
{

const char* const ABOUT =
    "Measures speed and memory with default parameters, in turns with others, and prints Markdown.\n"
    "  speed [IMAGE ...]          frames beside cv::ORB\n"
    "  beside LIBRARY [IMAGE ...] frames beside another build, named by its libaqorb.so\n"
    "  frames [IMAGE ...]         median and 90th percentile, with idle processors and with one of them "
    "busy\n"
    "  memory [IMAGE ...]         the heap in use during a frame and between frames, in bytes for each "
    "pixel\n"
    "  pair [IMAGE1 IMAGE2]       from two images to a homography, beside cv::ORB with cv::BFMatcher\n"
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
                         "named, frames and memory "
                         "1000, matching also 5000 }"
                         "{threads        | 1,2  | numbers of threads }"
                         "{turns          | 31   | how often each is measured; frames ten times as often }"
                         "{cold           |      | touch 64 MB of other memory before each frame }"
                         "{with           |      | libaqorb.so of another build for frames and memory, too }"
                         "{@command       |      | what to measure }"
                         "{@rest          |      | images }";

//! The arguments that are no options, from the second on.
std::vector<std::string> positional(int argc, const char* const* argv)
{
    std::vector<std::string> found;
    for (int i = 1; i < argc; i++)
        if (argv[i][0] != '-')
            found.push_back(argv[i]);
    if (!found.empty())
        found.erase(found.begin());
    return found;
}

int run(const cv::CommandLineParser& parser, std::vector<std::string> images)
{
    const std::string command = parser.get<cv::String>("@command"), numbers = parser.get<cv::String>("n");
    const bool isSingle = command == "frames" || command == "memory";
    Settings settings;
    settings.numbers = tools::splitNumbers(!numbers.empty()        ? numbers
                                           : isSingle              ? "1000"
                                           : command == "matching" ? "500,1000,2000,5000"
                                                                   : "500,1000,2000");
    settings.threads = tools::splitNumbers(parser.get<cv::String>("threads"));
    settings.turns = parser.get<int>("turns");
    settings.cold = parser.has("cold");
    settings.beside = parser.get<cv::String>("with");
    tools::checkRead(parser);
    for (const std::vector<int>& values : {settings.numbers, settings.threads, {settings.turns}})
        if (values.empty() || *std::min_element(values.begin(), values.end()) < 1)
            throw tools::BadArguments{"--n, --threads, --turns: numbers above 0"};
    if (command == "beside")
    {
        if (images.empty())
            throw tools::BadArguments{"beside which LIBRARY? see --help"};
        settings.beside = images[0];
        images.erase(images.begin());
    }
    if (images.empty() && command != "pair")
        images = splitList(std::getenv("OPENCV_TEST_DATA_PATH")
                               ? "bikes,leuven,bark,trees,ubc,640x512.png,1920x1080.png"
                               : "640x480,1920x1080");
    settings.images = images;
    std::vector<Contender> contenders = {orb(), aqorbHere()};
    if (!settings.beside.empty())
        contenders.push_back(aqorbOf(settings.beside));

    if (command == "speed")
        measureSpeed(settings, contenders[0]);
    else if (command == "beside")
        measureSpeed(settings, contenders[2]);
    else if (command == "frames")
    {
        settings.turns *= 10;
        measureFrames(settings, contenders);
    }
    else if (command == "memory")
        measureMemory(settings, contenders);
    else if (command == "pair" &&
             (images.size() == 2 || (images.empty() && std::getenv("OPENCV_TEST_DATA_PATH"))))
        measurePairs(settings);
    else if (command == "pair")
        throw tools::BadArguments{"pair: name two images, or set OPENCV_TEST_DATA_PATH"};
    else if (command == "matching")
        measureMatching(settings);
    else if (command == "program")
        measureProgram(settings);
    else
        throw tools::BadArguments{"'" + command +
                                  "': speed, beside, frames, memory, pair, matching or program; see "
                                  "--help"};
    return 0;
}

}  // namespace

int main(int argc, char** argv)
{
    return tools::runProgram("aqorb_benchmark", ABOUT, KEYS, argc, argv,
                             [argc, argv](const cv::CommandLineParser& parser)
                             { return run(parser, positional(argc, argv)); });
}
