// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// Measures what OpenCV's performance harness cannot: two detectors in turns, with cold memory or on a busy machine. See
// doc/performance.md.

#include "../test/scenes.hpp"

#include <opencv2/aqorb.hpp>
#include <opencv2/core/utility.hpp>
#include <opencv2/imgcodecs.hpp>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <iostream>
#include <thread>

#include <dlfcn.h>

using namespace cv;
using aqorb::AdaptiveQuadtreeORB;

namespace
{

const char* const ABOUT =
    "Measures speed with default parameters, in turns, and prints Markdown.\n"
    "  frames [IMAGE ...]          beside cv::ORB\n"
    "  beside LIBRARY [IMAGE ...]  frames beside another build, named by the path of its libaqorb.so\n"
    "An IMAGE is a file, WIDTHxHEIGHT for a drawn scene, or a photograph of opencv_extra, as "
    "bikes/img1.png:\n"
    "its folder testdata is OPENCV_TEST_DATA_PATH. OPENCV_CPU_DISABLE=AVX512-SKX leaves AVX-512 out.\n";

const char* const KEYS = "{help     | | print this text }"
                         "{n        | 0 | number of features; 500, 1000 and 2000 unless named }"
                         "{threads  | 1 | number of threads }"
                         "{turns    | 31 | how often each is measured }"
                         "{cold     | | touch 64 MB of other memory before each frame }"
                         "{busy     | 0 | threads that keep processors busy meanwhile }"
                         "{@command | | what to measure }";

const std::vector<std::string> FRAMES = {"bikes/img1.png",    "leuven/img1.png", "bark/img1.png",
                                         "trees/img1.png",    "ubc/img1.png",    "perf/640x512.png",
                                         "perf/1920x1080.png"};

typedef std::function<Ptr<Feature2D>(int nfeatures)> Creator;

//! Loads a drawn scene, a file, or a photograph of opencv_extra such as bikes/img1.png.
Mat loadImage(const std::string& name)
{
    Size size;
    char more;
    if (std::sscanf(name.c_str(), "%dx%d%c", &size.width, &size.height, &more) == 2)
        return opencv_test::makeScene(size);
    const char* const data = std::getenv("OPENCV_TEST_DATA_PATH");
    std::string folder;
    if (data && !std::ifstream(name))
        folder = data + std::string(name.find("perf/") == 0
                                        ? "/"
                                        : "/cv/detectors_descriptors_evaluation/images_datasets/");
    const Mat image = imread(folder + name, IMREAD_GRAYSCALE);
    if (image.empty())
        CV_Error(Error::StsObjectNotFound, name + ": no such image");
    return image;
}

//! AdaptiveQuadtreeORB::create of another build's shared library, which stays loaded.
Creator creatorOf(const std::string& library)
{
    typedef Ptr<AdaptiveQuadtreeORB> (*Create)(int, float, int, int, int, int, ORB::ScoreType, int, int);
    // Without RTLD_DEEPBIND the library would call this build's functions.
    void* const handle = dlopen(library.c_str(), RTLD_NOW | RTLD_LOCAL | RTLD_DEEPBIND);
    void* const symbol =
        handle ? dlsym(handle, "_ZN2cv5aqorb19AdaptiveQuadtreeORB6createEifiiiiNS_3ORB9ScoreTypeEii") : NULL;
    if (!symbol)
        CV_Error(Error::StsBadArg, library + " is not a shared library of aqorb: " + dlerror());
    const Create create = reinterpret_cast<Create>(symbol);
    // The defaults, which no symbol holds.
    return [create](int n) { return create(n, 1.2f, 8, 16, 0, 2, ORB::HARRIS_SCORE, 31, 20); };
}

void keepBusy()
{
    for (volatile bool isBusy = true; isBusy;)
        continue;
}

void touchOtherMemory()
{
    static std::vector<uint64> words((64 << 20) / sizeof(uint64));
    for (size_t i = 0; i < words.size(); i += 8)  // each cache line
        words[i]++;
}

//! Prints a row with the times of two detectors, measured in turns: A B, B A, A B. Returns the ratio of the medians.
double measureRow(const CommandLineParser& options, const std::string& name, int n, Feature2D& theirs,
                  Feature2D& ours)
{
    const Mat image = loadImage(name);
    const int turns = std::max(options.get<int>("turns"), 1);
    std::vector<KeyPoint> keypoints[2];
    Mat descriptors[2];
    std::vector<double> times[2], quotients;
    for (int turn = 0; turn <= turns; turn++)
    {
        double ms[2];
        for (int i = 0; i < 2; i++)
        {
            const bool isOurs = i == turn % 2;
            if (options.has("cold"))
                touchOtherMemory();
            const int64 start = getTickCount();
            (isOurs ? ours : theirs)
                .detectAndCompute(image, noArray(), keypoints[isOurs], descriptors[isOurs]);
            ms[isOurs] = 1e3 * double(getTickCount() - start) / getTickFrequency();
        }
        if (turn == 0)
            continue;  // the first turn fills caches and allocates
        times[0].push_back(ms[0]);
        times[1].push_back(ms[1]);
        quotients.push_back(ms[0] / ms[1]);
    }
    for (std::vector<double>* values : {&times[0], &times[1], &quotients})
        std::sort(values->begin(), values->end());
    const size_t middle = quotients.size() / 2, late = quotients.size() * 9 / 10;
    std::cout << format("| %s | %d | %d | %.2f | %.2f | %.2f | %.2f, %.2f |\n", name.c_str(), n,
                        getNumThreads(), times[0][middle], times[1][middle], quotients[middle],
                        times[0][late], times[1][late])
              << std::flush;
    return quotients[middle];
}

void measureFrames(const CommandLineParser& options, const Creator& create,
                   const std::vector<std::string>& images)
{
    std::cout << "| image | n | threads | " << (create ? "other build" : "cv::ORB")
              << ", ms | aqorb, ms | ratio | 90th percentiles |\n|---|---:|---:|---:|---:|---:|---:|\n";
    const int only = options.get<int>("n");
    const std::vector<int> numbers = only > 0 ? std::vector<int>{only} : std::vector<int>{500, 1000, 2000};
    std::vector<double> logarithms;  // of the ratios
    for (const std::string& name : images)
        for (const int n : numbers)
        {
            const Ptr<Feature2D> theirs = create ? create(n) : Ptr<Feature2D>(ORB::create(n));
            const double ratio = measureRow(options, name, n, *theirs, *AdaptiveQuadtreeORB::create(n));
            logarithms.push_back(std::log(ratio));
        }
    std::cout << format("\nRatio: geometric mean %.3f, lowest %.2f\n\n", std::exp(mean(logarithms)[0]),
                        std::exp(*std::min_element(logarithms.begin(), logarithms.end())));
}

}  // namespace

int main(int argc, char** argv)
try
{
    CommandLineParser parser(argc, argv, KEYS);
    parser.about(ABOUT);
    const String command = parser.get<String>("@command");
    const bool isBeside = command == "beside";
    std::vector<std::string> images;
    std::copy_if(argv + 1, argv + argc, std::back_inserter(images),
                 [](const char* a) { return a[0] != '-'; });
    if (images.size() <= size_t(isBeside) || (!isBeside && command != "frames"))
        return parser.printMessage(), !parser.has("help");
    const Creator create = isBeside ? creatorOf(images[1]) : Creator();
    images.erase(images.begin(), images.begin() + 1 + isBeside);
    if (images.empty())
        images = FRAMES;
    for (int i = 0; i < parser.get<int>("busy"); i++)
        std::thread(keepBusy).detach();
    setNumThreads(parser.get<int>("threads"));
    measureFrames(parser, create, images);
    return 0;
}
catch (const std::exception& error)
{
    std::cerr << "aqorb_benchmark: " << error.what() << std::endl;
    return 2;
}
