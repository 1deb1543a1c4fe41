// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// Thins out keypoints of other detectors: by response alone, and uniformly.

#include "sample.hpp"

#include <opencv2/aqorb.hpp>

using namespace cv;

static const char* const ABOUT =
    "Keeps some keypoints of SIFT and of FAST: by cv::KeyPointsFilter::retainBest, which goes by the\n"
    "response alone (left), and by cv::aqorb::retainUniform, which spreads them over the image.";

static const char* const KEYS =
    "{help    |                    | print this text }"
    "{npoints | 500                | number of keypoints to keep }"
    "{out     | retain_uniform.jpg | picture to write }"
    "{@image  | graf1.png          | file, or one of OpenCV's samples in OPENCV_SAMPLES_DATA_PATH }";

static Mat drawn(const Mat& image, const std::vector<KeyPoint>& keypoints, const String& name)
{
    std::cout << format("%-24s %9d %10.1f %9.0f %%\n", name.c_str(), int(keypoints.size()),
                        aqorb::distributionUniformity(keypoints, image.size()),
                        100 * aqorb::distributionOccupancy(keypoints, image.size()));
    Mat picture;
    drawKeypoints(image, keypoints, picture, Scalar(0, 255, 255));
    return captioned(picture, name);
}

static int retainUniformSample(int argc, char** argv)
{
    const CommandLineParser parser = parseOptions(argc, argv, KEYS, ABOUT);
    const String out = pictureOption(parser);
    const int npoints = option<int>(parser, "npoints");
    const Mat image = readImage(option<String>(parser, "@image"));

    const std::pair<String, Ptr<Feature2D>> detectors[] = {{"SIFT", SIFT::create()},
                                                           {"FAST", FastFeatureDetector::create()}};
    std::cout << format("%-24s %9s %10s %11s\n", "", "keypoints", "uniformity", "occupied");
    Mat rows[2];
    for (int i = 0; i < 2; i++)
    {
        std::vector<KeyPoint> best, uniform;
        detectors[i].second->detect(image, best);
        uniform = best;
        KeyPointsFilter::retainBest(best, npoints);
        aqorb::retainUniform(uniform, image.size(), npoints);
        const Mat left = drawn(image, best, detectors[i].first + ", retainBest");
        const Mat right = drawn(image, uniform, detectors[i].first + ", retainUniform");
        hconcat(left, right, rows[i]);
    }
    vconcat(rows[0], rows[1], rows[0]);
    writePicture(out, rows[0]);
    return 0;
}

int main(int argc, char** argv)
{
    return runSample(retainUniformSample, argc, argv);
}
