// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// Compares AdaptiveQuadtreeORB with cv::ORB: positions of keypoints, matches, and times.

#include "sample.hpp"

#include <opencv2/aqorb.hpp>
#if CV_VERSION_MAJOR >= 5
#include <opencv2/geometry.hpp>
#else
#include <opencv2/calib3d.hpp>
#endif

#include <algorithm>
#include <set>

using namespace cv;

namespace
{

const char* const ABOUT =
    "Compares cv::aqorb::AdaptiveQuadtreeORB with cv::ORB on two images, by a table and a picture,\n"
    "aqorb_demo.jpg:\n"
    "  aqorb_demo --nfeatures=500 --out=pictures photograph1.jpg photograph2.jpg\n"
    "Without images it takes three pairs of OpenCV's samples and, if the variable AQORB_STRECHA names\n"
    "Strecha's photographs, two of a fountain.\n"
    "Matches are mutual nearest neighbours. The last column adds growMatches, which refines them and finds\n"
    "more nearby. A match agrees if it lies within 3 pixels of the homography or, in a scene in depth, of "
    "the\n"
    "epipolar line; 1.5 pixels after growMatches. Places are cells of 16 x 16 pixels with such a match, in "
    "the\n"
    "image that has fewer. A frame is image 1 to keypoints and descriptors, a pair is both images to their\n"
    "geometry by USAC_MAGSAC. Times are medians on one thread.\n";

const char* const KEYS = "{help      |      | print this text }"
                         "{nfeatures | 1000 | number of keypoints to ask for }"
                         "{out       | .    | existing folder for the pictures }";

const int MIN_PLACES = 15;  // two images with fewer places probably show different things

struct Method
{
    String name;
    Ptr<ORB> detector;
    Ptr<DescriptorMatcher> matcher;  // with cross check
    bool grows;                      // whether growMatches refines and adds matches
};

//! Result of a method.
struct Found
{
    std::vector<KeyPoint> keypoints1, keypoints2;
    std::vector<Point2f> points1, points2;  // matches that agree with the geometry
    int matches, places;
    double frame, pair;  // milliseconds
};

//! Number of cells of 16 x 16 pixels that hold a point.
int countCells(const std::vector<Point2f>& points)
{
    std::set<std::pair<int, int>> cells;
    for (const Point2f& point : points)
        cells.insert(std::make_pair(cvFloor(point.x / 16), cvFloor(point.y / 16)));
    return int(cells.size());
}

//! Finds keypoints and matches, and selects the matches that agree with a homography or an epipolar geometry.
Found find(const Method& method, const Mat& image1, const Mat& image2, bool isEpipolar)
{
    Found found;
    Mat descriptors1, descriptors2;
    std::vector<DMatch> matches;
    std::vector<Point2f> points1, points2;
    TickMeter time;
    time.start();
    method.detector->detectAndCompute(image1, noArray(), found.keypoints1, descriptors1);
    time.stop();
    found.frame = time.getTimeMilli();
    time.start();
    method.detector->detectAndCompute(image2, noArray(), found.keypoints2, descriptors2);
    if (!descriptors1.empty() && !descriptors2.empty())
        method.matcher->match(descriptors1, descriptors2, matches);
    if (method.grows)
    {
        std::vector<KeyPoint> grown1, grown2;
        std::vector<float> deviations;
        aqorb::growMatches(image1, found.keypoints1, image2, found.keypoints2, matches, grown1, grown2,
                           points1, points2, deviations);
    }
    else
        for (const DMatch& match : matches)
        {
            points1.push_back(found.keypoints1[match.queryIdx].pt);
            points2.push_back(found.keypoints2[match.trainIdx].pt);
        }
    std::vector<uchar> agrees;
    const double threshold = method.grows ? 1.5 : 3;
    if (points1.size() >= 8 && isEpipolar)
        findFundamentalMat(points1, points2, USAC_MAGSAC, threshold, 0.9999, 10000, agrees);
    else if (points1.size() >= 8)
        findHomography(points1, points2, USAC_MAGSAC, threshold, agrees, 10000, 0.9999);
    time.stop();
    found.pair = time.getTimeMilli();

    found.matches = int(points1.size());
    for (size_t i = 0; i < agrees.size(); i++)
        if (agrees[i])
        {
            found.points1.push_back(points1[i]);
            found.points2.push_back(points2[i]);
        }
    found.places = std::min(countCells(found.points1), countCells(found.points2));
    return found;
}

//! Prints a time of each method in milliseconds, and how many times as fast as the first method each one is.
void printTimes(const String& label, const std::vector<std::vector<Found>>& runs, double Found::*time)
{
    std::vector<double> medians;
    for (size_t i = 0; i < runs[0].size(); i++)
    {
        std::vector<double> times;
        for (const std::vector<Found>& run : runs)
            times.push_back(run[i].*time);
        std::nth_element(times.begin(), times.begin() + times.size() / 2, times.end());
        medians.push_back(times[times.size() / 2]);
    }
    printRow(label + " in ms", medians, [](double median) { return format("%.1f", median); });
    printRow("  times as fast", medians, [&](double median) { return format("%.1f", medians[0] / median); });
}

const int WIDTH = 800;  // of each image in the pictures, in pixels

//! Position in an image of the pictures.
Point scaled(const Point2f& position, double scale)
{
    const Point2d half(0.5, 0.5);
    return (Point2d(position) + half) * scale - half;
}

//! An image with circles at its points.
Mat drawPoints(const Mat& image, const std::vector<Point2f>& points)
{
    const double scale = double(WIDTH) / image.cols;
    Mat picture;
    resize(image, picture, Size(WIDTH, cvCeil(image.rows * scale)), 0, 0,
           scale < 1 ? INTER_AREA : INTER_LINEAR);
    cvtColor(picture, picture, COLOR_GRAY2BGR);
    for (const Point2f& point : points)
        circle(picture, scaled(point, scale), 3, Scalar(0, 255, 255), 1, LINE_AA);
    return picture;
}

Mat sideBySide(const Mat& left, const Mat& right)
{
    Mat picture(std::max(left.rows, right.rows), 2 * WIDTH, CV_8UC3, Scalar::all(255));
    left.copyTo(picture(Rect(Point(), left.size())));
    right.copyTo(picture(Rect(Point(WIDTH, 0), right.size())));
    return picture;
}

//! Both images with the matches that agree. At most 100 have a line: more would hide the images.
Mat drawAgreeing(const Mat& image1, const Mat& image2, const Found& found)
{
    Mat picture = sideBySide(drawPoints(image1, found.points1), drawPoints(image2, found.points2));
    for (size_t i = 0; i < found.points1.size(); i += found.points1.size() / 100 + 1)
        line(picture, scaled(found.points1[i], double(WIDTH) / image1.cols),
             scaled(found.points2[i], double(WIDTH) / image2.cols) + Point(WIDTH, 0), Scalar(0, 255, 255), 1,
             LINE_AA);
    return picture;
}

//! Compares the methods on two images, and writes a picture.
void compare(const Mat& image1, const Mat& image2, int nfeatures, const String& file)
{
    for (const Mat& image : {image1, image2})
        if (std::min(image.cols, image.rows) < 32)
            CV_Error(Error::StsBadSize,
                     format("an image of %dx%d pixels; 32x32 or more are accepted", image.cols, image.rows));
    const Ptr<ORB> ours = aqorb::AdaptiveQuadtreeORB::create(nfeatures);
    const Ptr<DescriptorMatcher> matcher = makePtr<aqorb::HammingMatcher>(NORM_HAMMING, true);
    const std::vector<Method> methods = {
        {"cv::ORB", ORB::create(nfeatures), makePtr<BFMatcher>(NORM_HAMMING, true), false},
        {"AdaptiveQuadtreeORB", ours, matcher, false},
        {"with growMatches", ours, matcher, true}};
    // A scene in depth: the epipolar geometry explains half as many matches again as a homography.
    const bool isEpipolar = double(find(methods[2], image1, image2, true).points1.size()) >
                            1.5 * double(find(methods[2], image1, image2, false).points1.size());
    std::vector<std::vector<Found>>
        runs;  // the methods take turns, so that other programs slow all of them equally
    TickMeter time;
    while (runs.size() < 5 || (runs.size() < 51 && time.getTimeSec() < 3))
    {
        time.start();
        runs.emplace_back();
        for (const Method& method : methods)
            runs.back().push_back(find(method, image1, image2, isEpipolar));
        time.stop();
    }
    const std::vector<Found>& found = runs[0];

    printRow(isEpipolar ? "by epipolar lines" : "by a homography", methods,
             [](const Method& method) { return method.name; });
    printRow("keypoints of image 1", found,
             [](const Found& one) { return format("%d", int(one.keypoints1.size())); });
    const auto occupancy = [&](const Found& one)
    { return 100 * aqorb::distributionOccupancy(one.keypoints1, image1.size(), Size(16, 12)); };
    printRow("  cells of a 16 x 12 grid that hold one", found,
             [&](const Found& one) { return format("%.0f %%", occupancy(one)); });
    printRow("matches that agree, of all", found,
             [](const Found& one) { return format("%d of %d", int(one.points1.size()), one.matches); });
    printRow("  their places", found, [](const Found& one) { return format("%d", one.places); });
    printTimes("frame", runs, &Found::frame);
    printTimes("pair", runs, &Found::pair);
    if (found[2].places < MIN_PLACES)
        std::cout << "Fewer than " << MIN_PLACES << " places: the images probably show different things.\n";

    std::vector<Mat> keypoints, rows;
    for (const Found& one : found)
    {
        std::vector<Point2f> positions;
        KeyPoint::convert(one.keypoints1, positions);
        keypoints.push_back(drawPoints(image1, positions));
    }
    rows.push_back(captioned(sideBySide(keypoints[0], keypoints[1]),
                             "keypoints of image 1: cv::ORB on the left, AdaptiveQuadtreeORB on the right"));
    for (size_t i = 0; i < found.size(); i++)
        rows.push_back(captioned(drawAgreeing(image1, image2, found[i]),
                                 methods[i].name + format(": %d places", found[i].places)));
    Mat picture;
    vconcat(rows, picture);
    writePicture(file, picture);
}

//! Compares the methods on photographs for which the outcome is known.
void compareExamples(int nfeatures, const String& out)
{
    const String FOUNTAIN = "/Benchmarking_Camera_Calibration_2008/fountain-P11/images/";
    const char* const variable = std::getenv("AQORB_STRECHA");
    const String fountain = variable ? variable + FOUNTAIN : String();
    std::vector<std::vector<String>> examples = {
        {"rubberwhale1.png", "rubberwhale2.png", "two frames of a video, with something to see everywhere"},
        {"box.png", "box_in_scene.png",
         "a box, and the same box among other things, where growMatches finds it"},
        {"graf1.png", "graf3.png", "a painted wall from two sides"}};
    if (utils::fs::exists(fountain + "0003.jpg") && utils::fs::exists(fountain + "0005.jpg"))
        examples.push_back({fountain + "0003.jpg", fountain + "0005.jpg",
                            "a fountain from two places, of which cv::ORB sees little but a sculpture"});
    else if (variable)
        std::cerr << "AQORB_STRECHA=" << variable << ": this folder has no file ." << FOUNTAIN
                  << "0003.jpg or 0005.jpg; the demo goes on without the fountain" << std::endl;
    for (size_t i = 0; i < examples.size(); i++)
    {
        std::cout << examples[i][0] << ", " << examples[i][1] << ": " << examples[i][2] << "\n\n";
        compare(readImage(examples[i][0]), readImage(examples[i][1]), nfeatures,
                out + format("/aqorb_demo%d.jpg", int(i + 1)));
        std::cout << std::endl;
    }
}

int demo(int argc, char** argv)
{
    const CommandLineParser parser = parseOptions(argc, argv, KEYS, ABOUT);
    const int nfeatures = option<int>(parser, "nfeatures");
    const String out = option<String>(parser, "out");
    if (!utils::fs::isDirectory(out))
        CV_Error(Error::StsObjectNotFound, out + ": cannot be written to; an existing folder is accepted");
    const std::vector<String> files = fileArguments(argc, argv);
    if (!files.empty() && files.size() != 2)
        CV_Error(Error::StsBadArg,
                 format("%d images; two are accepted, or none for examples", int(files.size())));
    setNumThreads(1);
    if (files.empty())
        compareExamples(nfeatures, out);
    else
        compare(readImage(files[0]), readImage(files[1]), nfeatures, out + "/aqorb_demo.jpg");
    return 0;
}

}  // namespace

int main(int argc, char** argv)
{
    return runSample(demo, argc, argv);
}
