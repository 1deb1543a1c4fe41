// This file is part of the aqorb project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.

#include "measure.hpp"

#include "../../perf/perf_scene.hpp"

#include <opencv2/core/utility.hpp>
#include <opencv2/imgcodecs.hpp>

#include <algorithm>
#include <iostream>

using namespace cv;

static std::string pathOf(const std::string& photograph)
{
    const char* const data = std::getenv("OPENCV_TEST_DATA_PATH");
    const std::string names[] = {"bikes", "leuven", "bark", "trees", "ubc"};
    if (data && std::count(std::begin(names), std::end(names), photograph))
        return std::string(data) + "/cv/detectors_descriptors_evaluation/images_datasets/" + photograph +
               "/img1.png";
    if (data && (photograph == "640x512.png" || photograph == "1920x1080.png"))
        return std::string(data) + "/perf/" + photograph;
    return photograph;
}

Image::Image(const std::string& spec_) : spec(spec_)
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

const char* nameOf(Detector detector)
{
    return detector == AQORB ? "AQORB" : "CV_ORB";
}

Ptr<Feature2D> createDetector(Detector detector, int nfeatures)
{
    if (detector == AQORB)
        return aqorb::AdaptiveQuadtreeORB::create(nfeatures);
    return ORB::create(nfeatures);
}

double timeFrame(Feature2D& detector, const Mat& image, Features& features)
{
    const int64 start = getTickCount();
    detector.detectAndCompute(image, noArray(), features.keypoints, features.descriptors);
    return double(getTickCount() - start) / getTickFrequency();
}

std::string quoted(const std::string& text)
{
    std::string field = "\"";
    for (char c : text)
        field += c == '"' ? std::string("\"\"") : std::string(1, c);
    return field + '"';
}

void printSetting(const Settings& settings)
{
    std::cout << "name,value\n"
              << "OpenCV," << quoted(getVersionString()) << '\n'
              << "CPU features in use," << quoted(getCPUFeaturesLine()) << '\n'
              << "compiler of aqorb," << quoted(AQORB_COMPILER) << '\n'
              << "frames of the stages' medians," << settings.repeats << '\n';
}
