// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// Finds a known flat object, such as a book or a label, in a photograph, and draws its outline.

#include "sample.hpp"

#include <opencv2/aqorb.hpp>

using namespace cv;

static const char* const ABOUT = "Finds a known flat object in a scene, and draws its outline and the "
                                 "matches. Exit code 1 if it is not there.";

static const char* const KEYS =
    "{help      |                  | print this text }"
    "{nfeatures | 1000             | number of keypoints to ask for, in each picture }"
    "{places    | 10               | number of places from which the object counts as found }"
    "{out       | found.jpg        | picture to write }"
    "{@object   | box.png          | picture of the object alone, or one of OpenCV's samples }"
    "{@scene    | box_in_scene.png | photograph to search, or one of OpenCV's samples }";

static int findObject(int argc, char** argv)
{
    const CommandLineParser parser = parseOptions(argc, argv, KEYS, ABOUT);
    const String out = pictureOption(parser);
    const int enough = option<int>(parser, "places");
    const Ptr<ORB> orb = aqorb::AdaptiveQuadtreeORB::create(option<int>(parser, "nfeatures"));
    const Mat object = readImage(option<String>(parser, "@object"));
    const Mat scene = readImage(option<String>(parser, "@scene"));

    std::vector<KeyPoint> keypoints1, keypoints2;
    Mat descriptors1, descriptors2;
    orb->detectAndCompute(object, noArray(), keypoints1, descriptors1);  // once for each object

    TickMeter time;
    time.start();
    orb->detectAndCompute(scene, noArray(), keypoints2, descriptors2);
    std::vector<DMatch> matches;
    if (!descriptors1.empty() && !descriptors2.empty())
        aqorb::HammingMatcher(orb->defaultNorm(), true).match(descriptors1, descriptors2, matches);
    std::vector<Point2f> points1, points2;
    std::vector<float> deviations;
    aqorb::growMatches(object, keypoints1, scene, keypoints2, matches, keypoints1, keypoints2, points1,
                       points2, deviations);
    Mat homography;
    std::vector<uchar> isInlier;
    if (matches.size() >= 4)
        homography = findHomography(points1, points2, USAC_MAGSAC, 1.5, isInlier);
    time.stop();

    const int places = countPlaces(flagged(points1, isInlier), flagged(points2, isInlier));
    const bool isFound = !homography.empty() && places >= enough;
    std::cout << (isFound ? "found: " : "not found: ") << places << " places, "
              << format("%.1f", time.getTimeMilli()) << " ms" << std::endl;
    if (!isFound)
        return 1;

    Mat picture;
    for (size_t i = 0; i < matches.size(); i++)
    {
        keypoints1[size_t(matches[i].queryIdx)].pt = points1[i];
        keypoints2[size_t(matches[i].trainIdx)].pt = points2[i];
    }
    drawMatches(object, keypoints1, scene, keypoints2, matches, picture, Scalar::all(-1), Scalar::all(-1),
                std::vector<char>(isInlier.begin(), isInlier.end()),
                DrawMatchesFlags::NOT_DRAW_SINGLE_POINTS);
    const float right = float(object.cols - 1), bottom = float(object.rows - 1);
    std::vector<Point2f> corners = {{0, 0}, {right, 0}, {right, bottom}, {0, bottom}};
    perspectiveTransform(corners, corners, homography);
    std::vector<Point> outline(corners.begin(), corners.end());
    const Mat sceneInPicture = picture(Rect(object.cols, 0, scene.cols, scene.rows));
    polylines(sceneInPicture, outline, true, Scalar(0, 255, 0), 2, LINE_AA);
    writePicture(out, picture);
    return 0;
}

int main(int argc, char** argv)
{
    return runSample(findObject, argc, argv);
}
