// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// Matches two images of a plane and draws where the first lies in the second.

#include <opencv2/aqorb.hpp>
#include <opencv2/core/utility.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#if CV_VERSION_MAJOR >= 5
#include <opencv2/geometry.hpp>
#else
#include <opencv2/calib3d.hpp>
#endif

#include <iostream>

using namespace cv;

static const char* const KEYS =
    "{help      |                | print this text }"
    "{nfeatures | 1000           | number of keypoints to ask for }"
    "{out       | homography.jpg | picture to write }"
    "{@image1   | graf1.png      | file, or one of OpenCV's samples in OPENCV_SAMPLES_DATA_PATH }"
    "{@image2   | graf3.png      | the same plane from another side }";

int main(int argc, char** argv)
{
    CommandLineParser parser(argc, argv, KEYS);
    parser.about("Matches two images of a plane, estimates the homography between them, and draws where the\n"
                 "first image lies in the second.");
    const String file1 = parser.get<String>("@image1"), file2 = parser.get<String>("@image2");
    const String out = parser.get<String>("out");
    const Ptr<ORB> orb = aqorb::AdaptiveQuadtreeORB::create(parser.get<int>("nfeatures"));
    if (parser.has("help") || !parser.check())
    {
        parser.printErrors();
        parser.printMessage();
        return !parser.check();
    }
    const Mat image1 = imread(samples::findFile(file1, false), IMREAD_GRAYSCALE);
    const Mat image2 = imread(samples::findFile(file2, false), IMREAD_GRAYSCALE);
    if (image1.empty() || image2.empty())
    {
        std::cerr << (image1.empty() ? file1 : file2)
                  << ": cannot be read as an image (OpenCV's: export "
                     "OPENCV_SAMPLES_DATA_PATH=$(scripts/demo.sh --images))\n";
        return 1;
    }

    std::vector<KeyPoint> keypoints1, keypoints2;
    Mat descriptors1, descriptors2;
    orb->detectAndCompute(image1, noArray(), keypoints1, descriptors1);
    orb->detectAndCompute(image2, noArray(), keypoints2, descriptors2);

    std::vector<DMatch> matches;  // mutual nearest neighbours, those of BFMatcher(orb->defaultNorm(), true)
    if (!descriptors1.empty() && !descriptors2.empty())
        aqorb::HammingMatcher(orb->defaultNorm(), true).match(descriptors1, descriptors2, matches);

    std::vector<Point2f> points1, points2;
    for (const DMatch& match : matches)
    {
        points1.push_back(keypoints1[match.queryIdx].pt);
        points2.push_back(keypoints2[match.trainIdx].pt);
    }
    Mat homography;
    std::vector<char> isInlier;
    if (matches.size() >= 4)
        homography = findHomography(points1, points2, USAC_MAGSAC, 3, isInlier, 10000, 0.9999);
    if (homography.empty())
    {
        std::cerr << "no homography was found among " << matches.size() << " matches\n";
        return 1;
    }
    std::cout << "Keypoints: " << keypoints1.size() << ", " << keypoints2.size()
              << "\nMatches: " << matches.size()
              << ", of which agree with the homography: " << countNonZero(isInlier) << "\nHomography:\n"
              << homography << std::endl;

    const float right = float(image1.cols - 1), bottom = float(image1.rows - 1);
    const std::vector<Point2f> corners = {{0, 0}, {right, 0}, {right, bottom}, {0, bottom}};
    std::vector<Point2f> mapped;
    perspectiveTransform(corners, mapped, homography);
    std::vector<Point> outline;
    for (const Point2f& corner : mapped)
        outline.push_back(corner +
                          Point2f(float(image1.cols), 0));  // the second image stands right of the first
    Mat picture;
    drawMatches(image1, keypoints1, image2, keypoints2, matches, picture, Scalar(0, 255, 255),
                Scalar(0, 255, 255), isInlier, DrawMatchesFlags::NOT_DRAW_SINGLE_POINTS);
    polylines(picture, outline, true, Scalar(0, 255, 0), 2, LINE_AA);
    if (!imwrite(out, picture))
        return 1;
    std::cout << "Picture: " << out << '\n';
    return 0;
}
