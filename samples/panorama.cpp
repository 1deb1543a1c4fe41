// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// A panorama by cv::Stitcher, which takes any Feature2D for its features.

#include "program.hpp"

#include <opencv2/aqorb.hpp>
#include <opencv2/stitching.hpp>

using namespace cv;

static const Program PROGRAM = {"panorama",
                                "Stitches two or more overlapping photographs to a panorama.",
                                "IMAGE IMAGE ...",
                                2,
                                1000,
                                {{"nfeatures", "1500", "number of keypoints to ask for"},
                                 {"scans", FLAG, "the images are views of a plane, not of a turning camera"},
                                 {"out", "panorama.jpg", "picture to write"}},
                                "panorama --out=hills.jpg left.jpg middle.jpg right.jpg"};

static void run(const Arguments& arguments)
{
    const int nfeatures = arguments.featureCount();
    std::vector<Mat> images;
    for (const String& file : arguments.files)
        images.push_back(readImage(file, IMREAD_COLOR));

    const Ptr<Stitcher> stitcher =
        Stitcher::create(arguments.has("scans") ? Stitcher::SCANS : Stitcher::PANORAMA);
    stitcher->setFeaturesFinder(aqorb::AdaptiveQuadtreeORB::create(nfeatures));
    Mat panorama;
    Stitcher::Status status = Stitcher::ERR_HOMOGRAPHY_EST_FAIL;
    try
    {
        status = stitcher->stitch(images, panorama);
    }
    catch (const cv::Exception&)  // an assertion, for example where hardly anything matches
    {
    }
    if (status == Stitcher::ERR_NEED_MORE_IMGS)
        throw Failure{FAILED, "the images do not overlap enough"};
    if (status != Stitcher::OK)
        throw Failure{FAILED, "the cameras could not be estimated"};
    std::printf("%d of %d images stitched, %dx%d\n", int(stitcher->component().size()), int(images.size()),
                panorama.cols, panorama.rows);
    writePicture(arguments.text("out"), panorama);
}

int main(int argc, char** argv)
{
    return runProgram(PROGRAM, run, argc, argv);
}
