// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// Masks the black corners of a fisheye lens's image, whose rim would otherwise take keypoints.

#include "drawing.hpp"
#include "program.hpp"

#include <opencv2/aqorb.hpp>

using namespace cv;

static const Program PROGRAM = {
    "fisheye_mask",
    "Finds keypoints inside the circle of a fisheye lens: without a mask, where the rim of the\n"
    "circle takes some, and with one. Without an image it takes graf1.png of OpenCV's samples.",
    "[IMAGE]",
    0,
    1,
    {{"x", "-1", "centre of the lens's circle, in pixels; -1: centre of the image"},
     {"y", "-1", "the same, from the top"},
     {"radius", "-1", "radius of the circle; -1: up to the nearest side of the image"},
     {"margin", "8", "pixels to keep away from the circle's rim"},
     {"nfeatures", "1000", "number of keypoints to ask for"},
     {"out", "fisheye_mask.jpg", "picture to write"}},
    "fisheye_mask --radius=290 --margin=10 fisheye.png"};

static void run(const Arguments& arguments)
{
    const int LARGEST = 1000000;
    Point centre(arguments.wholeNumber("x", -1, LARGEST), arguments.wholeNumber("y", -1, LARGEST));
    int radius = arguments.wholeNumber("radius", -1, LARGEST);
    const int margin = arguments.wholeNumber("margin", 0, LARGEST), nfeatures = arguments.featureCount();
    const Mat image = readImage(arguments.file(0, "graf1.png"));
    if (centre.x < 0)
        centre.x = image.cols / 2;
    if (centre.y < 0)
        centre.y = image.rows / 2;
    if (!Rect(Point(), image.size()).contains(centre))
        throw Failure{BAD_ARGUMENTS, format("--x=%d --y=%d: a centre inside the image of %dx%d pixels is "
                                            "accepted",
                                            centre.x, centre.y, image.cols, image.rows)};
    if (radius < 0)
        radius =
            std::min(std::min(centre.x, image.cols - centre.x), std::min(centre.y, image.rows - centre.y));
    const int inner = radius - margin;
    if (inner < 0)
        throw Failure{BAD_ARGUMENTS,
                      format("--margin=%d: at most the radius of %d pixels is accepted", margin, radius)};

    // Keypoints may lie where the mask is not zero. The detector scales the mask for its pyramid.
    Mat mask = Mat::zeros(image.size(), CV_8UC1);
    circle(mask, centre, inner, Scalar(255), FILLED);

    const Ptr<ORB> detector = aqorb::AdaptiveQuadtreeORB::create(nfeatures);
    Mat pictures[2];
    for (int masked = 0; masked < 2; masked++)
    {
        std::vector<KeyPoint> keypoints;
        detector->detect(image, keypoints, masked ? mask : Mat());
        int outside = 0;
        for (const KeyPoint& keypoint : keypoints)
            outside += norm(keypoint.pt - Point2f(centre)) > inner + 1;
        const String text = format("%s mask: %d keypoints, %d not inside the circle",
                                   masked ? "With" : "Without", int(keypoints.size()), outside);
        std::printf("%s\n", text.c_str());
        Mat picture = keypointPicture(image, keypoints);
        const int factor = picture.cols / image.cols;
        circle(picture, enlarged(centre, factor), inner * factor, GREEN, lineWidth(picture.size()), LINE_AA);
        pictures[masked] = captioned(picture, text);
    }
    hconcat(pictures[0], pictures[1], pictures[0]);
    writePicture(arguments.text("out"), pictures[0]);
}

int main(int argc, char** argv)
{
    return runProgram(PROGRAM, run, argc, argv);
}
