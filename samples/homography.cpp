// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// Matches two images of a plane and draws where the first lies in the second.

#include "sample.hpp"

#include <opencv2/aqorb.hpp>
#if CV_VERSION_MAJOR >= 5
#include <opencv2/geometry.hpp>
#else
#include <opencv2/calib3d.hpp>
#endif

using namespace cv;

static const char* const ABOUT =
    "Matches two images of a plane, estimates the homography between them, and draws where the first image\n"
    "lies in the second.";

static const char* const KEYS =
    "{help      |                | print this text }"
    "{nfeatures | 1000           | number of keypoints to ask for }"
    "{out       | homography.jpg | picture to write }"
    "{@image1   | graf1.png      | file, or one of OpenCV's samples in OPENCV_SAMPLES_DATA_PATH }"
    "{@image2   | graf3.png      | the same plane from another side }";

static int homographySample(int argc, char** argv)
{
    const CommandLineParser parser = parseOptions(argc, argv, KEYS, ABOUT);
    const String out = pictureOption(parser);
    const Ptr<ORB> orb = aqorb::AdaptiveQuadtreeORB::create(option<int>(parser, "nfeatures"));
    const Mat image1 = readImage(option<String>(parser, "@image1"));
    const Mat image2 = readImage(option<String>(parser, "@image2"));

    std::vector<KeyPoint> keypoints1, keypoints2;
    Mat descriptors1, descriptors2;
    orb->detectAndCompute(image1, noArray(), keypoints1, descriptors1);
    orb->detectAndCompute(image2, noArray(), keypoints2, descriptors2);

    std::vector<DMatch> matches;  // mutual nearest neighbours, as BFMatcher(orb->defaultNorm(), true) gives
    if (!descriptors1.empty() && !descriptors2.empty())
        aqorb::HammingMatcher(orb->defaultNorm(), true).match(descriptors1, descriptors2, matches);

    const size_t all = matches.size();
    std::vector<Point2f> points1, points2;  // refined: they allow a threshold of one pixel
    aqorb::refineMatches(image1, keypoints1, image2, keypoints2, matches, points1, points2);
    Mat homography;
    std::vector<char> isInlier;
    if (matches.size() >= 4)
        homography = findHomography(points1, points2, USAC_MAGSAC, 1, isInlier, 10000, 0.9999);
    if (homography.empty())
        CV_Error_(Error::StsNoConv, ("no homography was found among %d matches", int(matches.size())));
    std::cout << "Keypoints: " << keypoints1.size() << ", " << keypoints2.size() << "\nMatches: " << all
              << ", of which can be refined: " << matches.size()
              << ", of which agree with the homography: " << countNonZero(isInlier) << "\nHomography:\n"
              << homography << std::endl;

    const float right = float(image1.cols - 1), bottom = float(image1.rows - 1);
    const std::vector<Point2f> corners = {{0, 0}, {right, 0}, {right, bottom}, {0, bottom}};
    std::vector<Point2f> mapped;
    perspectiveTransform(corners, mapped, homography);
    std::vector<Point> outline;
    for (const Point2f& corner : mapped)  // the second image stands right of the first
        outline.push_back(corner + Point2f(float(image1.cols), 0));
    Mat picture;
    drawMatches(image1, keypoints1, image2, keypoints2, matches, picture, Scalar(0, 255, 255),
                Scalar(0, 255, 255), isInlier, DrawMatchesFlags::NOT_DRAW_SINGLE_POINTS);
    polylines(picture, outline, true, Scalar(0, 255, 0), 2, LINE_AA);
    writePicture(out, picture);
    return 0;
}

int main(int argc, char** argv)
{
    return runSample(homographySample, argc, argv);
}
