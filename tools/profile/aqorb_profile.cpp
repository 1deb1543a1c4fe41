// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// Shows where the time and the memory of AdaptiveQuadtreeORB go. Prints CSV; tools/report/report.py makes the tables of
// doc/performance.md of it, and scripts/performance.sh runs both. How fast AdaptiveQuadtreeORB is beside cv::ORB is
// measured by perf/ alone.

#include "measure.hpp"

#include "../common/options.hpp"

#include <iostream>

using namespace cv;
using tools::splitList;

namespace
{

const char* const ABOUT =
    "Shows where the time and the memory of AdaptiveQuadtreeORB with default parameters go, "
    "as CSV. One of --setting, --stages, --memory and --frames chooses what.\n"
    "Exit codes: 0 done, 1 bad arguments, 2 other.\n";

const char* const KEYS =
    "{help h usage ? |      | print this text }"
    "{setting        |      | print the versions and the CPU features in use }"
    "{stages         |      | print the time of each stage, and the least time of a frame by numbers of "
    "threads, by OpenCV's trace of one thread; in ns }"
    "{memory         |      | print the heap at its peak and what is kept between frames, in bytes; of "
    "cv::ORB, too }"
    "{frames         | 0    | only run so many frames of the first image, for a profiler }"
    "{detector       | aqorb | of --frames: aqorb or orb }"
    "{images         |      | names separated by commas: WIDTHxHEIGHT draws a scene, others are photographs "
    "in OPENCV_TEST_DATA_PATH (bikes, leuven, bark, trees, ubc, 640x512.png, 1920x1080.png) or files }"
    "{n              | 1000 | number of features }"
    "{repeats        | 31   | number of frames of --stages }"
    "{smoke          |      | one small image and three frames, to show that it runs }";

std::vector<std::string> defaultImages()
{
    std::vector<std::string> images = splitList("640x480,1920x1080");
    if (std::getenv("OPENCV_TEST_DATA_PATH"))
    {
        const std::vector<std::string> photographs = splitList("leuven,bark,trees,640x512.png,1920x1080.png");
        images.insert(images.end(), photographs.begin(), photographs.end());
    }
    return images;
}

void runFrames(const std::string& spec, Detector id, int nfeatures, int frames)
{
    setNumThreads(1);
    const Image image(spec);
    const Ptr<Feature2D> detector = createDetector(id, nfeatures);
    Features features;
    for (int i = 0; i < WARM_UP; i++)  // a profiler tells these by the function
        detector->detectAndCompute(image.pixels, noArray(), features.keypoints, features.descriptors);
    for (int i = 0; i < frames; i++)
        timeFrame(*detector, image.pixels, features);
}

int run(const CommandLineParser& parser)
{
    const bool smoke = parser.has("smoke");
    Settings settings;
    settings.images = splitList(parser.get<String>("images"));
    settings.nfeatures = parser.get<int>("n");
    settings.repeats = smoke ? 3 : parser.get<int>("repeats");
    const int frames = parser.get<int>("frames");
    const std::string detector = parser.get<String>("detector");
    if (!parser.check())
    {
        parser.printErrors();
        return 1;
    }
    if (settings.nfeatures < 1 || settings.repeats < 1 || frames < 0 ||
        (detector != "aqorb" && detector != "orb"))
    {
        std::cerr << "n, repeats: at least 1 is accepted; frames: at least 0; detector: aqorb or orb\n";
        return 1;
    }
    if (parser.has("setting") + parser.has("stages") + parser.has("memory") + (frames > 0) != 1)
    {
        std::cerr << "One of --setting, --stages, --memory and --frames is accepted\n";
        return 1;
    }
    if (settings.images.empty())
        settings.images = smoke ? splitList("320x240") : defaultImages();

    if (frames > 0)
    {
        runFrames(settings.images[0], detector == "orb" ? CV_ORB : AQORB, settings.nfeatures, frames);
        return 0;
    }
    const tools::CsvTable table = parser.has("setting")  ? measureSetting(settings)
                                  : parser.has("stages") ? measureStages(settings)
                                                         : measureMemory(settings);
    std::cout << table.text();
    return 0;
}

}  // namespace

int main(int argc, char** argv)
{
    const std::string unknown = tools::unknownOption(argc, argv, KEYS);
    if (!unknown.empty())
    {
        std::cerr << "There is no option " << unknown << "; --help lists them\n";
        return 1;
    }
    CommandLineParser parser(argc, argv, KEYS);
    parser.about(ABOUT);
    if (parser.has("help") || argc == 1)
    {
        parser.printMessage();
        return parser.has("help") ? 0 : 1;
    }
    try
    {
        return run(parser);
    }
    catch (const std::exception& error)
    {
        std::cerr << error.what() << '\n';
        return 2;
    }
}
