// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// Shows where the memory of AdaptiveQuadtreeORB goes, and how long a frame takes in a program that does other work, too;
// frames.py measures stages and instructions of the frames that it runs. Prints CSV; tools/report/report.py makes the
// tables of doc/performance.md of it, and scripts/performance.sh runs all. How fast AdaptiveQuadtreeORB is beside cv::ORB
// if nothing else runs is measured by perf/.

#include "measure.hpp"

#include "../common/program.hpp"

#include <opencv2/core/utility.hpp>

#include <algorithm>
#include <cstdlib>
#include <iostream>

using namespace cv;
using tools::splitList;

namespace
{

const char* const ABOUT =
    "Shows the time and the memory that AdaptiveQuadtreeORB with default parameters takes, "
    "as CSV. One of --setting, --program, --memory and --frames chooses what.\n"
    "Exit codes: 0 done, 1 bad arguments, 2 other.\n";

const char* const KEYS =
    "{help h usage ? |      | print this text }"
    "{setting        |      | print the versions and the CPU features in use }"
    "{program        |      | print the times of cv::ORB and AdaptiveQuadtreeORB in a program that does "
    "other work, too; in ms }"
    "{memory         |      | print the heap at its peak and what is kept between frames, in bytes; of "
    "cv::ORB, too }"
    "{frames         | 0    | only run so many frames of the first image, for a profiler; three warm up }"
    "{detector       | aqorb | of --frames: aqorb or orb }"
    "{images         |      | names separated by commas: WIDTHxHEIGHT draws a scene, others are photographs "
    "in OPENCV_TEST_DATA_PATH (bikes, leuven, bark, trees, ubc, 640x512.png, 1920x1080.png) or files }"
    "{n              | 1000 | number of features }"
    "{beside         |      | of --program and --memory: libaqorb.so of another build, which is measured, "
    "too }"
    "{cases          | turns,cold,warm,stream,avx2 | of --program. turns: the detectors are called in turns; "
    "cold: 64 MB of other memory are touched before each call; warm: calls of one detector after the other; "
    "stream: different frames with other work between; avx2: turns without AVX-512 }"
    "{numbers        | 500,1000,2000 | of --program: numbers of features }"
    "{threads        | 1,2  | of --program: numbers of threads }"
    "{passes         | 3    | of --program: passes over all images }"
    "{calls          | 7    | of --program: calls of a detector in a pass }"
    "{quick          |      | of --program: leuven, bark and 640x512.png, 1000 features, one pass of 5 calls "
    "}"
    "{smoke          |      | one small image, to show that it runs }";

//! The photographs that the aims of doc/performance.md are set for; none without opencv_extra.
std::vector<std::string> photographs()
{
    return splitList(
        std::getenv("OPENCV_TEST_DATA_PATH") ? "bikes,leuven,bark,trees,ubc,640x512.png,1920x1080.png" : "");
}

std::vector<std::string> defaultImages()
{
    std::vector<std::string> images = splitList("640x480,1920x1080");
    for (const std::string& image : photographs())
        images.push_back(image);
    return images;
}

ProgramSettings programSettings(const CommandLineParser& parser, const Settings& common,
                                const std::vector<std::string>& arguments)
{
    ProgramSettings settings;
    static_cast<Settings&>(settings) = common;
    settings.numbers = tools::splitNumbers(parser.get<String>("numbers"));
    settings.threads = tools::splitNumbers(parser.get<String>("threads"));
    settings.cases = splitList(parser.get<String>("cases"));
    settings.passes = parser.get<int>("passes");
    settings.calls = parser.get<int>("calls");
    for (const std::string& argument : arguments)
        if (argument.compare(0, 7, "--cases") != 0)
            settings.arguments.push_back(argument);
    if (parser.has("quick"))
    {
        settings.numbers = {1000};
        settings.passes = 1;
        settings.calls = 5;
        if (settings.images.empty() && !photographs().empty())
            settings.images = splitList("leuven,bark,640x512.png");
    }
    if (parser.has("smoke"))
    {
        settings.numbers = {500};
        settings.passes = settings.calls = 1;
        if (settings.images.empty())
            settings.images = splitList("320x240");
    }
    if (settings.images.empty())
        settings.images = photographs().empty() ? defaultImages() : photographs();
    return settings;
}

void runFrames(const Image& image, const Contender& contender, int nfeatures, int frames)
{
    const int WARM_UP = 3;
    std::cout << image.name << std::endl;
    setNumThreads(1);
    const Ptr<Feature2D> detector = contender.create(nfeatures);
    Features features;
    for (int i = 0; i < WARM_UP; i++)  // a profiler tells these by the function
        detector->detectAndCompute(image.pixels, noArray(), features.keypoints, features.descriptors);
    for (int i = 0; i < frames; i++)
        timeFrame(*detector, image.pixels, features);
}

tools::CsvTable settingTable()
{
    tools::CsvTable table({"name", "value"});
    table.add({"OpenCV", getVersionString()});
    table.add({"CPU features in use", getCPUFeaturesLine()});
    table.add({"compiler of aqorb", AQORB_COMPILER});
    return table;
}

//! Throws where a value is not accepted.
void check(const Settings& settings, const ProgramSettings& program)
{
    const auto isPositive = [](int number) { return number > 0; };
    if (settings.nfeatures < 1 || program.passes < 1 || program.calls < 1)
        throw tools::BadArguments{"--n, --passes, --calls: at least 1"};
    for (const std::vector<int>* numbers : {&program.numbers, &program.threads})
        if (numbers->empty() || !std::all_of(numbers->begin(), numbers->end(), isPositive))
            throw tools::BadArguments{"--numbers, --threads: numbers above 0, separated by commas"};
    const std::vector<std::string> cases = splitList("turns,cold,warm,stream,avx2");
    for (const std::string& each : program.cases)
        if (std::find(cases.begin(), cases.end(), each) == cases.end())
            throw tools::BadArguments{"--cases: " + each + " is none of turns, cold, warm, stream, avx2"};
}

int run(const CommandLineParser& parser, const std::vector<std::string>& arguments)
{
    const bool smoke = parser.has("smoke");
    Settings settings;
    settings.images = splitList(parser.get<String>("images"));
    settings.nfeatures = parser.get<int>("n");
    settings.beside = parser.get<String>("beside");
    const ProgramSettings program = programSettings(parser, settings, arguments);
    const int frames = parser.get<int>("frames");
    const std::string detector = parser.get<String>("detector");
    tools::checkRead(parser);
    check(settings, program);
    if (frames < 0 || (detector != "aqorb" && detector != "orb"))
        throw tools::BadArguments{"--frames: at least 0; --detector: aqorb or orb"};
    if (parser.has("setting") + parser.has("program") + parser.has("memory") + (frames > 0) != 1)
        throw tools::BadArguments{"one of --setting, --program, --memory and --frames; see --help"};
    if (settings.images.empty())
        settings.images = smoke ? splitList("320x240") : defaultImages();

    if (frames > 0)
    {
        runFrames(Image(settings.images[0]), makeContenders("")[detector == "aqorb"], settings.nfeatures,
                  frames);
        return 0;
    }
    const tools::CsvTable table = parser.has("setting")   ? settingTable()
                                  : parser.has("program") ? measureProgram(program)
                                                          : measureMemory(settings);
    std::cout << table.text();
    return 0;
}

}  // namespace

int main(int argc, char** argv)
{
    return tools::runProgram("aqorb_profile", ABOUT, KEYS, argc, argv,
                             [argc, argv](const CommandLineParser& parser)
                             { return run(parser, std::vector<std::string>(argv, argv + argc)); });
}
