// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// Thins out the keypoints of other detectors: the best by response, and the best spread.

#include "drawing.hpp"
#include "program.hpp"

#include <opencv2/aqorb.hpp>

using namespace cv;

static const Program PROGRAM = {
    "retain_uniform",
    "Keeps some keypoints of SIFT and of FAST: by cv::KeyPointsFilter::retainBest, which goes by the\n"
    "response alone, and by cv::aqorb::retainUniform, which spreads them over the image. Without an\n"
    "image it takes graf1.png of OpenCV's samples.",
    "[IMAGE]",
    0,
    1,
    {{"npoints", "500", "number of keypoints to keep"}, {"out", "retain_uniform.jpg", "picture to write"}},
    "retain_uniform --npoints=300 graf1.png"};

static Mat drawn(const Mat& image, const std::vector<KeyPoint>& keypoints, const String& name)
{
    const double u = aqorb::distributionUniformity(keypoints, image.size());
    const double occupied = 100 * aqorb::distributionOccupancy(keypoints, image.size());
    std::printf("%-24s %9d %10.1f %9.0f %%\n", name.c_str(), int(keypoints.size()), u, occupied);
    return captioned(keypointPicture(image, keypoints), name);
}

static void run(const Arguments& arguments)
{
    const int npoints = arguments.featureCount("npoints");
    const Mat image = readImage(arguments.file(0, "graf1.png"));

    const struct
    {
        String name;
        Ptr<Feature2D> detector;
    } detectors[] = {{"SIFT", SIFT::create()}, {"FAST", FastFeatureDetector::create()}};

    std::printf("%-24s %9s %10s %11s\n", "", "keypoints", "uniformity", "occupied");
    Mat rows[2];
    for (int i = 0; i < 2; i++)
    {
        std::vector<KeyPoint> best, uniform;
        detectors[i].detector->detect(image, best);
        uniform = best;
        KeyPointsFilter::retainBest(best, npoints);
        aqorb::retainUniform(uniform, image.size(), npoints);
        const Mat left = drawn(image, best, detectors[i].name + ", retainBest");
        const Mat right = drawn(image, uniform, detectors[i].name + ", retainUniform");
        hconcat(left, right, rows[i]);
    }
    vconcat(rows[0], rows[1], rows[0]);
    writePicture(arguments.text("out"), rows[0]);
}

int main(int argc, char** argv)
{
    return runProgram(PROGRAM, run, argc, argv);
}
