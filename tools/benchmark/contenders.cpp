// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "benchmark.hpp"

#include "../../perf/perf_scene.hpp"

#include <opencv2/aqorb.hpp>
#include <opencv2/core/utility.hpp>
#include <opencv2/imgcodecs.hpp>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <iterator>

#include <dlfcn.h>

using namespace cv;
using aqorb::AdaptiveQuadtreeORB;

static std::string testData()
{
    const char* const folder = std::getenv("OPENCV_TEST_DATA_PATH");
    return folder ? folder : "";
}

std::string imageOfSet(const std::string& set, int index)
{
    return testData() + "/cv/detectors_descriptors_evaluation/images_datasets/" + set + "/img" +
           std::to_string(index) + ".png";
}

//! The path of a photograph of opencv_extra; of others, the name itself.
static std::string pathOf(const std::string& photograph)
{
    const std::string sets[] = {"bikes", "leuven", "bark", "trees", "ubc"};
    if (testData().empty())
        return photograph;
    if (std::count(std::begin(sets), std::end(sets), photograph))
        return imageOfSet(photograph, 1);
    if (photograph == "640x512.png" || photograph == "1920x1080.png")
        return testData() + "/perf/" + photograph;
    return photograph;
}

Image::Image(const std::string& spec)
{
    Size size;
    char more;
    if (std::sscanf(spec.c_str(), "%dx%d%c", &size.width, &size.height, &more) == 2)
    {
        name = "scene";
        pixels = opencv_test::makeStreetScene(size);
    }
    else
    {
        name = spec.substr(spec.rfind('/') + 1);
        pixels = imread(pathOf(spec), IMREAD_GRAYSCALE);
        if (pixels.empty())
            CV_Error(Error::StsObjectNotFound, spec + ": no such image");
    }
    const std::string sizeText = format("%dx%d", pixels.cols, pixels.rows);
    if (name.compare(0, sizeText.size(), sizeText) == 0)
        name = "photograph";
    name += " " + sizeText;
}

Contender orb()
{
    return {"cv::ORB", [](int n) { return ORB::create(n); }};
}

Contender aqorbHere()
{
    return {"aqorb", [](int n) { return AdaptiveQuadtreeORB::create(n); }};
}

Contender aqorbOf(const std::string& library)
{
    typedef Ptr<AdaptiveQuadtreeORB> (*CreateFunction)(
        int nfeatures, float scaleFactor, int nlevels, int edgeThreshold, int firstLevel, int WTA_K,
        ORB::ScoreType scoreType, int patchSize, int fastThreshold);
    const char* const SYMBOL = "_ZN2cv5aqorb19AdaptiveQuadtreeORB6createEifiiiiNS_3ORB9ScoreTypeEii";
    int flags = RTLD_NOW | RTLD_LOCAL;
#ifdef RTLD_DEEPBIND
    flags |= RTLD_DEEPBIND;  // or the functions of this build would stand in for its own
#endif
    // A plain file name would be looked for in the system's folders.
    void* const handle =
        dlopen((library.find('/') == std::string::npos ? "./" + library : library).c_str(), flags);
    void* const symbol = handle ? dlsym(handle, SYMBOL) : NULL;
    if (!symbol)
        CV_Error(Error::StsBadArg, library + " is not a shared library of aqorb: " + dlerror());
    const CreateFunction create = reinterpret_cast<CreateFunction>(symbol);
    if (create == static_cast<CreateFunction>(&AdaptiveQuadtreeORB::create))
        CV_Error(Error::StsBadArg, library + " is the library that is measured already");
    return {library.substr(library.rfind('/') + 1),
            [create](int n) -> Ptr<Feature2D>
            {
                // No symbol has the default values, so those of this build are taken.
                const Ptr<ORB> here = AdaptiveQuadtreeORB::create(n);
                return create(n, float(here->getScaleFactor()), here->getNLevels(), here->getEdgeThreshold(),
                              here->getFirstLevel(), here->getWTA_K(), here->getScoreType(),
                              here->getPatchSize(), here->getFastThreshold());
            }};
}

double milliseconds(const std::function<void()>& work)
{
    const int64 start = getTickCount();
    work();
    return 1e3 * double(getTickCount() - start) / getTickFrequency();
}

double timeFrame(Feature2D& detector, const Mat& image, Features& features)
{
    const int64 start = getTickCount();
    detector.detectAndCompute(image, noArray(), features.keypoints, features.descriptors);
    return 1e3 * double(getTickCount() - start) / getTickFrequency();
}

std::string cpuName()
{
#ifdef CV_CPU_AVX512_ICL
    if (checkHardwareSupport(CV_CPU_AVX512_ICL) && checkHardwareSupport(CV_CPU_AVX512_SKX))
        return "AVX-512 with VPOPCNTDQ";
#endif
    if (checkHardwareSupport(CV_CPU_AVX512_SKX))
        return "AVX-512 without VPOPCNTDQ";
    if (checkHardwareSupport(CV_CPU_AVX2))
        return "AVX2";
    if (checkHardwareSupport(CV_CPU_SSE4_1))
        return "SSE4.1";
    return checkHardwareSupport(CV_CPU_NEON) ? "NEON" : "baseline";
}

double median(std::vector<double> values)
{
    std::sort(values.begin(), values.end());
    const size_t half = values.size() / 2;
    return values.size() % 2 ? values[half] : (values[half - 1] + values[half]) / 2;
}

double geometricMean(const std::vector<double>& ratios)
{
    double sum = 0;
    for (const double ratio : ratios)
        sum += std::log(ratio);
    return std::exp(sum / double(ratios.size()));
}

double medianRatio(const std::function<double()>& first, const std::function<double()>& second, int turns,
                   double* medians)
{
    std::vector<double> times[2], ratios;
    for (int turn = -1; turn < turns; turn++)
    {
        const bool secondBegins = turn % 2 != 0;
        const double before = secondBegins ? second() : first();
        const double after = secondBegins ? first() : second();
        if (turn < 0)
            continue;  // it fills caches, and allocates
        times[0].push_back(secondBegins ? after : before);
        times[1].push_back(secondBegins ? before : after);
        ratios.push_back(times[0].back() / times[1].back());
    }
    for (int i = 0; medians && i < 2; i++)
        medians[i] = median(times[i]);
    return median(ratios);
}
