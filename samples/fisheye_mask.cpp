// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// Masks the black corners of a fisheye lens's image, whose rim would otherwise attract keypoints.

#include "sample.hpp"

#include <opencv2/aqorb.hpp>

using namespace cv;

static const char* const ABOUT =
    "Finds keypoints inside the circle of a fisheye lens: without a mask, where the rim\n"
    "of the circle takes some, and with one.";

static const char* const KEYS =
    "{help      |                  | print this text }"
    "{radius    | -1               | radius of the lens's circle; -1: up to the nearest side of the image }"
    "{margin    | 8                | pixels to keep away from the circle's rim }"
    "{nfeatures | 1000             | number of keypoints to ask for }"
    "{out       | fisheye_mask.jpg | picture to write }"
    "{@image    |                  | picture of a fisheye lens; without: OpenCV's sample graf1.png, cut to a "
    "circle }";

static int fisheyeMask(int argc, char** argv)
{
    const CommandLineParser parser = parseOptions(argc, argv, KEYS, ABOUT);
    const String out = pictureOption(parser);
    const String name = option<String>(parser, "@image");
    Mat image = readImage(name.empty() ? "graf1.png" : name);
    const Point centre(image.cols / 2, image.rows / 2);
    int radius = option<int>(parser, "radius");
    if (radius < 0)
        radius = std::min(centre.x, centre.y);
    const int inner = std::max(radius - option<int>(parser, "margin"), 0);

    Mat isOutside(image.size(), CV_8UC1, Scalar(255));
    circle(isOutside, centre, radius, Scalar(0), FILLED);
    if (name.empty())
        image.setTo(0, isOutside);
    else if (mean(image, isOutside)[0] > 32)
        CV_Error(
            Error::StsBadArg,
            format("%s: no picture of a fisheye lens, as it is not black outside a circle with radius %d",
                   name.c_str(), radius));

    // Keypoints may lie where the mask is not zero. The detector scales the mask for its pyramid.
    Mat mask = Mat::zeros(image.size(), CV_8UC1);
    circle(mask, centre, inner, Scalar(255), FILLED);

    const Ptr<ORB> detector = aqorb::AdaptiveQuadtreeORB::create(option<int>(parser, "nfeatures"));
    Mat pictures[2];
    for (int masked = 0; masked < 2; masked++)
    {
        std::vector<KeyPoint> keypoints;
        detector->detect(image, keypoints, masked ? mask : Mat());
        int outside = 0;
        for (const KeyPoint& keypoint : keypoints)
            outside += norm(keypoint.pt - Point2f(centre)) > inner + 1;
        std::cout << (masked ? "With" : "Without") << " mask: " << keypoints.size() << " keypoints, "
                  << outside << " not inside the circle\n";
        drawKeypoints(image, keypoints, pictures[masked], Scalar(0, 255, 255));
        circle(pictures[masked], centre, inner, Scalar(0, 255, 0), 1, LINE_AA);
    }
    hconcat(pictures[0], pictures[1], pictures[0]);
    writePicture(out, pictures[0]);
    return 0;
}

int main(int argc, char** argv)
{
    return runSample(fisheyeMask, argc, argv);
}
