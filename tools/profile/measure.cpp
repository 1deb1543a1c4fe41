// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "measure.hpp"

#include "../../perf/perf_scene.hpp"
#include "../../test/data_files.hpp"

#include <opencv2/core/utility.hpp>
#include <opencv2/imgcodecs.hpp>

#include <algorithm>
#include <iterator>

using namespace cv;

//! The path of a photograph of opencv_extra; of others, the name itself.
static std::string pathOf(const std::string& photograph)
{
    const std::string sets[] = {"bikes", "leuven", "bark", "trees", "ubc"};
    std::string path;
    if (std::count(std::begin(sets), std::end(sets), photograph))
        path = opencv_test::oxfordImage(photograph, 1);
    else if (photograph == "640x512.png" || photograph == "1920x1080.png")
        path = opencv_test::dataFile("perf/" + photograph);
    return path.empty() ? photograph : path;
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

tools::CsvTable measureSetting(const Settings& settings)
{
    tools::CsvTable table({"name", "value"});
    table.add({"OpenCV", getVersionString()});
    table.add({"CPU features in use", getCPUFeaturesLine()});
    table.add({"compiler of aqorb", AQORB_COMPILER});
    table.add({"frames of the stages' medians", std::to_string(settings.repeats)});
    return table;
}
