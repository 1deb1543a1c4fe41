// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// Masks the black corners of a fisheye lens's image, whose rim would otherwise take keypoints.

#include <opencv2/aqorb.hpp>
#include <opencv2/core/utility.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include <iostream>

using namespace cv;

static const char* const KEYS =
    "{help      |                  | print this text }"
    "{x         | -1               | centre of the lens's circle, in pixels; -1: centre of the image }"
    "{y         | -1               | the same, from the top }"
    "{radius    | -1               | radius of the circle; -1: up to the nearest side of the image }"
    "{margin    | 8                | pixels to keep away from the circle's rim }"
    "{nfeatures | 1000             | number of keypoints to ask for }"
    "{out       | fisheye_mask.jpg | picture to write }"
    "{@image    | graf1.png        | file, or one of OpenCV's samples in OPENCV_SAMPLES_DATA_PATH }";

int main(int argc, char** argv)
{
    CommandLineParser parser(argc, argv, KEYS);
    parser.about("Finds keypoints inside the circle of a fisheye lens: without a mask, where the rim of the\n"
                 "circle takes some, and with one.");
    const String file = parser.get<String>("@image"), out = parser.get<String>("out");
    Point centre(parser.get<int>("x"), parser.get<int>("y"));
    int radius = parser.get<int>("radius");
    const int margin = parser.get<int>("margin"), nfeatures = parser.get<int>("nfeatures");
    if (parser.has("help") || !parser.check())
    {
        parser.printErrors();
        parser.printMessage();
        return !parser.check();
    }
    const Mat image = imread(samples::findFile(file, false), IMREAD_GRAYSCALE);
    if (image.empty())
    {
        std::cerr << file
                  << ": cannot be read as an image (OpenCV's: export "
                     "OPENCV_SAMPLES_DATA_PATH=$(scripts/demo.sh --images))\n";
        return 1;
    }
    if (centre.x < 0)
        centre.x = image.cols / 2;
    if (centre.y < 0)
        centre.y = image.rows / 2;
    if (radius < 0)
        radius =
            std::min(std::min(centre.x, image.cols - centre.x), std::min(centre.y, image.rows - centre.y));
    const int inner = std::max(radius - margin, 0);

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
        std::cout << (masked ? "With" : "Without") << " mask: " << keypoints.size() << " keypoints, "
                  << outside << " not inside the circle\n";
        drawKeypoints(image, keypoints, pictures[masked], Scalar(0, 255, 255));
        circle(pictures[masked], centre, inner, Scalar(0, 255, 0), 1, LINE_AA);
    }
    hconcat(pictures[0], pictures[1], pictures[0]);
    if (!imwrite(out, pictures[0]))
        return 1;
    std::cout << "Picture: " << out << '\n';
    return 0;
}
