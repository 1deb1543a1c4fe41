// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// Each test measures this module, or with --perf_impl=opencv its counterpart in OpenCV: cv::ORB, cv::BFMatcher or
// cv::calcOpticalFlowPyrLK. modules/ts/misc/summary.py of OpenCV's source compares the two XML files.

#include "perf_precomp.hpp"
#include "../test/scenes.cpp"  // draws the same images as the tests

namespace opencv_test
{

Mat loadImage(const std::string& name, int index)
{
    Size size;
    if (sscanf(name.c_str(), "scene_%dx%d", &size.width, &size.height) == 2)
    {
        Mat scene = makeScene(size);
        if (index != 1)  // moved by a pixel
            cv::copyMakeBorder(scene(Rect(1, 1, size.width - 1, size.height - 1)).clone(), scene, 0, 1, 0, 1,
                               BORDER_REPLICATE);
        return scene;
    }
    const std::string path =
        name.find('.') != std::string::npos
            ? "perf/" + name
            : cv::format("cv/detectors_descriptors_evaluation/images_datasets/%s/img%d.png", name.c_str(),
                         index);
    const Mat image = imread(cvtest::findDataFile(path, false), IMREAD_GRAYSCALE);
    CV_Assert(!image.empty());
    return image;
}

}  // namespace opencv_test

static const char* const IMPLEMENTATIONS[] = {"plain", "opencv"};

CV_PERF_TEST_MAIN_WITH_IMPLS(aqorb, IMPLEMENTATIONS)
