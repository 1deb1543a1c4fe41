// This file is part of the aqorb project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.

// Matches two images of a plane and draws where the first lies in the second.

#include <opencv2/aqorb.hpp>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include <algorithm>
#include <iostream>

using namespace cv;

static const char* const KEYS = "{help h usage ? |                | print this text }"
                                "{@image1        | graf1.png      | image of a plane }"
                                "{@image2        | graf3.png      | another view of it }"
                                "{nfeatures      | 1000           | number of keypoints to ask for }"
                                "{out            | homography.jpg | picture to write }";

int main(int argc, char** argv)
{
    CommandLineParser parser(argc, argv, KEYS);
    parser.about("Estimates the homography between two images from their features.");
    if (parser.has("help"))
    {
        parser.printMessage();
        return 0;
    }
    const Mat image1 = imread(samples::findFile(parser.get<String>("@image1"), false), IMREAD_GRAYSCALE);
    const Mat image2 = imread(samples::findFile(parser.get<String>("@image2"), false), IMREAD_GRAYSCALE);
    const int nfeatures = parser.get<int>("nfeatures");
    const String out = parser.get<String>("out");
    if (!parser.check())
    {
        parser.printErrors();
        return 1;
    }
    if (image1.empty() || image2.empty())
    {
        std::cerr << "An image cannot be read" << std::endl;
        return 1;
    }

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
    std::vector<char> inliers;
    if (matches.size() >= 4)
        homography = findHomography(points1, points2, USAC_MAGSAC, 3, inliers, 10000, 0.9999);
    if (homography.empty())
    {
        std::cerr << "No homography found among " << matches.size() << " matches" << std::endl;
        return 1;
    }
    std::cout << "Keypoints: " << keypoints1.size() << ", " << keypoints2.size()
              << "\nMatches: " << matches.size() << ", of which agree with the homography: "
              << std::count_if(inliers.begin(), inliers.end(), [](char inlier) { return inlier != 0; })
              << "\nHomography:\n"
              << homography << std::endl;

    Mat picture;
    drawMatches(image1, keypoints1, image2, keypoints2, matches, picture, Scalar(0, 255, 255),
                Scalar::all(-1), inliers, DrawMatchesFlags::NOT_DRAW_SINGLE_POINTS);
    const float right = float(image1.cols - 1), bottom = float(image1.rows - 1);
    const std::vector<Point2f> corners = {{0, 0}, {right, 0}, {right, bottom}, {0, bottom}};
    std::vector<Point2f> mapped;
    perspectiveTransform(corners, mapped, homography);
    std::vector<Point> outline;
    for (const Point2f& corner : mapped)
        outline.push_back(Point(corner) + Point(image1.cols, 0));  // the second image is to the right
    polylines(picture, outline, true, Scalar(0, 255, 0), 2, LINE_AA);
    if (!imwrite(out, picture))
    {
        std::cerr << out << ": cannot be written" << std::endl;
        return 1;
    }
    std::cout << "Picture: " << out << std::endl;
    return 0;
}
