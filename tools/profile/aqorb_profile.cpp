// This file is part of the aqorb project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.

// Where the time, the memory and the instructions of AdaptiveQuadtreeORB go, and how they grow, beside cv::ORB.
// scripts/performance.sh makes the tables of doc/performance.md with it.

#include "benchmark.hpp"

#include <iostream>
#include <sstream>

using namespace cv;

namespace
{

const char* const ABOUT = "Measures AdaptiveQuadtreeORB and cv::ORB, default parameters on both sides, and "
                          "prints tables of ratios.\n"
                          "Exit codes: 0 done, 1 bad arguments, 2 other.\n";

const char* const KEYS =
    "{help h usage ? |      | print this text }"
    "{setting        |      | print what is measured with }"
    "{stages         |      | share of each stage and level in a frame, and the critical path, by OpenCV's "
    "trace }"
    "{scaling        |      | growth with the image and with n, one thread }"
    "{memory         |      | heap at its peak, and what is kept between frames }"
    "{frames         | 0    | only run so many frames of the first image, for a profiler }"
    "{detector       | aqorb | of --frames: aqorb or orb }"
    "{images         |      | of --stages, --memory and --frames: WIDTHxHEIGHT draws a scene, others are "
    "photographs "
    "in OPENCV_TEST_DATA_PATH (bikes, leuven, bark, trees, ubc, 640x512.png, 1920x1080.png) or files }"
    "{n              | 1000 | number of features, except of --scaling }"
    "{repeats        | 31   | frames to take medians of }"
    "{smoke          |      | shows that everything runs, measures nothing }";

std::vector<std::string> split(const std::string& list)
{
    std::vector<std::string> parts;
    std::stringstream stream(list);
    for (std::string part; std::getline(stream, part, ',');)
        parts.push_back(part);
    return parts;
}

std::vector<std::string> defaultImages()
{
    std::vector<std::string> images = split("640x480,1920x1080");
    if (std::getenv("OPENCV_TEST_DATA_PATH"))
    {
        const std::vector<std::string> photographs = split("leuven,bark,trees,640x512.png,1920x1080.png");
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
    settings.images = split(parser.get<String>("images"));
    settings.nfeatures = parser.get<int>("n");
    settings.repeats = smoke ? 3 : parser.get<int>("repeats");
    const int frames = parser.get<int>("frames");
    const std::string detector = parser.get<String>("detector");
    if (!parser.check())
    {
        parser.printErrors();
        return 1;
    }
    if (settings.nfeatures < 1 || settings.repeats < 1 || (detector != "aqorb" && detector != "orb"))
    {
        std::cerr << "n, repeats: at least 1 is accepted; detector: aqorb or orb\n";
        return 1;
    }
    if (settings.images.empty())
        settings.images = smoke ? split("320x240") : defaultImages();

    if (frames > 0)
    {
        runFrames(settings.images[0], detector == "orb" ? CV_ORB : AQORB, settings.nfeatures, frames);
        return 0;
    }
    if (smoke)
        std::cout << "SMOKE RUN: shows that everything runs. Do not quote these numbers.\n\n";
    if (parser.has("setting"))
        printSetting(settings);
    if (parser.has("stages"))
        printStages(settings);
    if (parser.has("scaling"))
    {
        if (smoke)
            printScaling(settings, {{320, 240}, {640, 480}}, {250, 500, 1000});
        else
            printScaling(settings,
                         {{320, 240}, {640, 480}, {1280, 720}, {1920, 1080}, {2560, 1440}, {3840, 2160}},
                         {250, 500, 1000, 2000, 4000, 8000});
    }
    if (parser.has("memory"))
        printMemory(settings);
    return 0;
}

}  // namespace

int main(int argc, char** argv)
{
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
