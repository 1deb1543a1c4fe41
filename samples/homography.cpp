// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// Matches two images of a plane and draws where the first lies in the second.

#include "drawing.hpp"
#include "program.hpp"

#include <opencv2/aqorb.hpp>
#include <opencv2/aqorb/geometry.hpp>

#include <iostream>

using namespace cv;

static const Program PROGRAM = {
    "homography",
    "Matches two images of a plane, estimates the homography between them, and draws where the\n"
    "first image lies in the second. Without images it takes graf1.png and graf3.png of OpenCV's\n"
    "samples.",
    "[IMAGE1 IMAGE2]",
    0,
    2,
    {{"nfeatures", "1000", "number of keypoints to ask for"}, {"out", "homography.jpg", "picture to write"}},
    "homography --nfeatures=2000 graf1.png graf3.png"};

static void run(const Arguments& arguments)
{
    const int nfeatures = arguments.featureCount();
    if (arguments.files.size() == 1)
        throw Failure{BAD_ARGUMENTS, arguments.files[0] + ": a second image is needed"};
    const Mat image1 = readImage(arguments.file(0, "graf1.png"));
    const Mat image2 = readImage(arguments.file(1, "graf3.png"));

    const Ptr<ORB> orb = aqorb::AdaptiveQuadtreeORB::create(nfeatures);
    std::vector<KeyPoint> keypoints1, keypoints2;
    Mat descriptors1, descriptors2;
    orb->detectAndCompute(image1, noArray(), keypoints1, descriptors1);
    orb->detectAndCompute(image2, noArray(), keypoints2, descriptors2);

    std::vector<DMatch> matches;  // mutual nearest neighbours
    if (!descriptors1.empty() && !descriptors2.empty())
        BFMatcher(orb->defaultNorm(), true).match(descriptors1, descriptors2, matches);

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
        throw Failure{FAILED, format("no homography was found among %d matches", int(matches.size()))};
    std::vector<DMatch> inliers;
    for (size_t i = 0; i < matches.size(); i++)
        if (isInlier[i])
            inliers.push_back(matches[i]);
    std::cout << "Keypoints: " << keypoints1.size() << ", " << keypoints2.size()
              << "\nMatches: " << matches.size() << ", of which agree with the homography: " << inliers.size()
              << "\nHomography:\n"
              << homography << std::endl;

    const float right = float(image1.cols - 1), bottom = float(image1.rows - 1);
    const std::vector<Point2f> corners = {{0, 0}, {right, 0}, {right, bottom}, {0, bottom}};
    std::vector<Point2f> mapped;
    perspectiveTransform(corners, mapped, homography);
    writePicture(arguments.text("out"),
                 matchPicture(image1, keypoints1, image2, keypoints2, inliers, mapped));
}

int main(int argc, char** argv)
{
    return runProgram(PROGRAM, run, argc, argv);
}
