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

using namespace cv;

namespace
{

const char* const ABOUT =
    "Compares cv::aqorb::AdaptiveQuadtreeORB with cv::ORB on one image or two, by a table and by pictures:\n"
    "aqorb_keypoints.jpg and, for two images, aqorb_matches.jpg. Without images it takes three pairs of\n"
    "OpenCV's samples: with all of the scene in both images, with a small object, and from two sides; and\n"
    "first, where the variable AQORB_STRECHA names Strecha's photographs, two of a fountain:\n"
    "  aqorb_demo --nfeatures=500 --out=pictures photograph1.jpg photograph2.jpg";

const char* const KEYS = "{help      |      | print this text }"
                         "{nfeatures | 1000 | number of keypoints to ask for }"
                         "{out       | .    | existing folder for the pictures }";

// Default images and their comments.
const struct
{
    const char *image1, *image2, *homography, *text;
} PAIRS[] = {
    {"fountain-P11/images/0003.jpg", "fountain-P11/images/0005.jpg", "",
     "AdaptiveQuadtreeORB wins: a fountain from two places. cv::ORB sees little but two targets and a\n"
     "sculpture."},
    {"rubberwhale1.png", "rubberwhale2.png", "",
     "AdaptiveQuadtreeORB wins: two frames of a video, with something to see everywhere."},
    {"box.png", "box_in_scene.png", "",
     "cv::ORB has more matches than AdaptiveQuadtreeORB alone: a small box, and the same box among other\n"
     "things. AdaptiveQuadtreeORB spreads its keypoints over the whole scene, so fewer of them lie on the\n"
     "box. growMatches finds the others. See StrengthWeight in the tutorial on the parameters, too."},
    {"graf1.png", "graf3.png", "H1to3p.xml",
     "AdaptiveQuadtreeORB wins: a painted wall from two sides, with a known homography between them."}};

const char* const LEGEND =
    "How to read it: cv::ORB's keypoints crowd where the contrast is highest, several on one corner.\n"
    "Those of AdaptiveQuadtreeORB cover the image. So more of them match at distinct places, in more\n"
    "cells. The last column adds growMatches, which moves a match to where both images show the same spot,\n"
    "leaves it out where they show none, and finds more beside.\n"
    "Matches are mutual nearest neighbours. Correct: within 3 pixels of the known homography. Consistent:\n"
    "within 3 pixels of the homography estimated from the detector's matches or, in a scene in depth, of\n"
    "the epipolar line, where a dozen wrong matches may lie by chance. Distinct: at least 4 pixels from\n"
    "every better one in both images. cv::ORB often has more in all, because it finds a strong corner on\n"
    "several levels and each of these counts.\n"
    "Times are medians; the methods take turns. Frame: image 1 to keypoints and descriptors.\n"
    "Pair: two images to their geometry. That is the features of both, matching by cv::BFMatcher or by\n"
    "HammingMatcher, growMatches in the last column, and RANSAC or, after growMatches, MAGSAC. Where\n"
    "few matches are right, RANSAC takes most of it. A second thread gains most with large images.\n\n";

struct Method
{
    const char* name;
    Ptr<ORB> detector;
    Ptr<DescriptorMatcher> matcher;  // with cross check
    bool grows;                      // whether growMatches refines and adds matches
};

double median(std::vector<double> values)
{
    std::sort(values.begin(), values.end());
    return values.empty() ? 0 : values[values.size() / 2];
}

//! Matched positions of two images: from[i] matches to[i].
struct Matches
{
    std::vector<KeyPoint> from, to;
};

//! Results of a method.
struct Found
{
    String method;
    std::vector<KeyPoint> keypoints[2];  // of each image
    Matches matches;                     // the best first
    int right = 0;                       // number of the matches that agree with the geometry
    Matches distinct;                    // the distinct among them
    double error = 0;                    // median error of the right matches, in pixels
    double milliseconds[2] = {0, 0};     // for the features of image 1, and for the pair
};

//! Geometry of two images: a homography or, for a scene in depth, a fundamental matrix.
struct Geometry
{
    Matx33d matrix;
    bool isEpipolar, isFound;
};

//! Distance of a match from its position by the homography, or from its epipolar line, in pixels of the second image.
double errorOf(const Geometry& geometry, const Point2f& from, const Point2f& to)
{
    const Vec3d v = geometry.matrix * Vec3d(from.x, from.y, 1);
    return geometry.isEpipolar ? std::abs(v[0] * to.x + v[1] * to.y + v[2]) / std::hypot(v[0], v[1])
                               : norm(Point2d(v[0] / v[2] - to.x, v[1] / v[2] - to.y));
}

//! Estimates the geometry by a method of OpenCV: timed as usual, else with more iterations, to judge the matches.
Geometry estimate(const Matches& matches, bool isEpipolar, bool isTimed, int method, double threshold)
{
    std::vector<Point2f> from, to;
    KeyPoint::convert(matches.from, from);
    KeyPoint::convert(matches.to, to);
    Mat matrix;
    if (from.size() < 8)
        return {Matx33d(), isEpipolar, false};
    if (isEpipolar)
        matrix = isTimed ? findFundamentalMat(from, to, method, threshold)
                         : findFundamentalMat(from, to, method, threshold, 0.9999, 10000);
    else
        matrix = isTimed ? findHomography(from, to, method, threshold)
                         : findHomography(from, to, method, threshold, noArray(), 10000, 0.9999);
    const bool isFound = matrix.size() == Size(3, 3);
    return {isFound ? Matx33d(matrix.ptr<double>()) : Matx33d(), isEpipolar, isFound};
}

//! Finds keypoints in one or two images, their matches and, with the usual settings, the geometry.
Found find(const Method& method, const std::vector<Mat>& images, bool isEpipolar)
{
    Found found;
    found.method = method.name;
    Mat descriptors[2];
    TickMeter time;
    time.start();
    for (size_t i = 0; i < images.size(); i++)
    {
        method.detector->detectAndCompute(images[i], noArray(), found.keypoints[i], descriptors[i]);
        time.stop();
        found.milliseconds[0] = i == 0 ? time.getTimeMilli() : found.milliseconds[0];
        time.start();
    }
    std::vector<DMatch> matches;
    if (!descriptors[0].empty() && !descriptors[1].empty())
        method.matcher->match(descriptors[0], descriptors[1], matches);
    std::stable_sort(matches.begin(), matches.end());
    std::vector<KeyPoint> keypoints2 = found.keypoints[1];
    std::vector<Point2f> from, to;
    std::vector<float> deviations;
    if (method.grows)
        aqorb::growMatches(images[0], found.keypoints[0], images[1], found.keypoints[1], matches, keypoints2,
                           from, to, deviations);
    for (size_t i = 0; i < matches.size(); i++)
    {
        found.matches.from.push_back(found.keypoints[0][matches[i].queryIdx]);
        found.matches.to.push_back(keypoints2[matches[i].trainIdx]);
        if (method.grows)
            found.matches.to[i].pt = to[i];
    }
    if (images.size() == 2)
        estimate(found.matches, isEpipolar, true, method.grows ? USAC_MAGSAC : RANSAC, method.grows ? 1 : 3);
    time.stop();
    found.milliseconds[1] = time.getTimeMilli();
    return found;
}

/** Selects the matches within 3 pixels of the geometry, and among them the distinct matches: at least 4 pixels from
 every better match in both images. Several keypoints on one corner of the scene tell no more than one. */
void choose(Found& found, const Geometry& geometry)
{
    std::vector<double> errors;
    for (size_t i = 0; i < found.matches.from.size() && geometry.isFound; i++)
    {
        const KeyPoint &from = found.matches.from[i], &to = found.matches.to[i];
        const double error = errorOf(geometry, from.pt, to.pt);
        if (!(error <= 3))
            continue;
        errors.push_back(error);
        found.right++;
        bool isDistinct = true;
        for (size_t j = 0; j < found.distinct.from.size(); j++)
            isDistinct &=
                norm(from.pt - found.distinct.from[j].pt) >= 4 && norm(to.pt - found.distinct.to[j].pt) >= 4;
        if (isDistinct)
        {
            found.distinct.from.push_back(from);
            found.distinct.to.push_back(to);
        }
    }
    found.error = median(errors);
}

/** Judges the results by the known homography. Without one, it estimates a homography from each method's matches or, if
 this explains half as many matches again, a fundamental matrix.
 @return whether a fundamental matrix was used */
bool judge(std::vector<Found>& found, const Mat& known)
{
    std::vector<Geometry> geometries[2];
    int agreeing[2] = {0, 0};
    for (int isEpipolar = 0; isEpipolar < 2; isEpipolar++)
        for (const Found& one : found)
        {
            const Geometry geometry =
                known.empty() ? estimate(one.matches, isEpipolar > 0, false, USAC_MAGSAC, isEpipolar ? 1 : 3)
                              : Geometry{Matx33d(known.ptr<double>()), false, true};
            geometries[isEpipolar].push_back(geometry);
            for (size_t i = 0; i < one.matches.from.size() && geometry.isFound; i++)
                agreeing[isEpipolar] += errorOf(geometry, one.matches.from[i].pt, one.matches.to[i].pt) <= 3;
        }
    const bool isEpipolar = agreeing[1] > 1.5 * agreeing[0];
    for (size_t i = 0; i < found.size(); i++)
        choose(found[i], geometries[isEpipolar][i]);
    return isEpipolar;
}

String occupied(const std::vector<KeyPoint>& keypoints, const Mat& image)
{
    return format("%.0f %%", 100 * aqorb::distributionOccupancy(keypoints, image.size(), Size(16, 12)));
}

//! Measures the methods in turns, so that other programs slow all of them equally.
void printTimes(const std::vector<Method>& methods, const std::vector<Mat>& images, bool isEpipolar,
                int threads)
{
    setNumThreads(threads);
    typedef std::vector<std::vector<double>> Values;  // of each method
    Values times[2] = {Values(methods.size()), Values(methods.size())};
    TickMeter time;
    for (int turn = 0; turn < 8 || (turn < 101 && time.getTimeSec() < 2); turn++)
    {
        time.start();
        for (size_t i = 0; i < methods.size(); i++)
        {
            const Found found = find(methods[i], images, isEpipolar);
            for (size_t j = 0; j < images.size(); j++)
                times[j][i].push_back(found.milliseconds[j]);
        }
        time.stop();
    }
    for (size_t j = 0; j < images.size(); j++)
    {
        const double first = median(times[j][0]);
        printRow(format("%s in ms, %d thread%s", j > 0 ? "pair" : "frame", threads, threads > 1 ? "s" : ""),
                 times[j], [](const std::vector<double>& values) { return format("%.1f", median(values)); });
        printRow("  times as fast", times[j],
                 [&](const std::vector<double>& values) { return format("%.1f", first / median(values)); });
    }
}

const double PANEL = 640;  // width of an image in the pictures, in pixels

Mat panel(const Mat& image, double scale, double brightness)
{
    Mat picture;
    resize(image * brightness, picture, Size(), scale, scale, scale < 1 ? INTER_AREA : INTER_LINEAR);
    cvtColor(picture, picture, COLOR_GRAY2BGR);
    return picture;
}

//! Draws a circle at a position of a scaled image.
void drawCircle(Mat& picture, const Point2f& position, double scale)
{
    const int BITS = 4;  // of the fraction
    const Point2d half(0.5, 0.5), centre = (Point2d(position) + half) * scale - half;
    circle(picture, Point(centre * (1 << BITS)), 3 << BITS, Scalar(0, 255, 255), 1, LINE_AA, BITS);
}

Mat keypointPicture(const Mat& image, const std::vector<KeyPoint>& keypoints)
{
    const double scale = PANEL / image.cols;
    Mat picture = panel(image, scale, 1);
    for (const KeyPoint& keypoint : keypoints)
        drawCircle(picture, keypoint.pt, scale);
    return picture;
}

//! Two darkened images side by side, with a line for each match.
Mat matchPicture(const std::vector<Mat>& images, const Matches& matches)
{
    const double scale = PANEL / std::max(images[0].cols, images[1].cols);
    const Mat left = panel(images[0], scale, 0.6), right = panel(images[1], scale, 0.6);
    Mat picture(std::max(left.rows, right.rows), left.cols + right.cols, CV_8UC3, Scalar::all(255));
    left.copyTo(picture(Rect(Point(0, 0), left.size())));
    Mat rightPart = picture(Rect(Point(left.cols, 0), right.size()));
    right.copyTo(rightPart);
    // Hundreds of lines would hide the images. So lines are translucent, and only some of many matches have one.
    const size_t LINES = 100, count = matches.from.size(), step = count / LINES + 1;
    Mat lines = picture.clone();
    const Point shift(left.cols, 0);
    for (size_t i = 0; i < count; i += step)
        line(lines, matches.from[i].pt * scale, Point(matches.to[i].pt * scale) + shift, Scalar(0, 255, 255),
             1, LINE_AA);
    addWeighted(lines, 0.4, picture, 0.6, 0, picture);
    for (size_t i = 0; i < count; i++)
    {
        drawCircle(picture, matches.from[i].pt, scale);
        drawCircle(rightPart, matches.to[i].pt, scale);
    }
    return picture;
}

//! Compares the methods on one image or two, with or without a known homography. Names of pictures end with `number`.
void compare(const std::vector<Mat>& images, const Mat& known, const CommandLineParser& parser,
             const String& number)
{
    const int nfeatures = option<int>(parser, "nfeatures"), threads = getNumThreads();
    const String out = option<String>(parser, "out");
    const bool isPair = images.size() == 2;
    const Ptr<ORB> ours = aqorb::AdaptiveQuadtreeORB::create(nfeatures);
    const Ptr<DescriptorMatcher> matcher = makePtr<aqorb::HammingMatcher>(NORM_HAMMING, true);
    std::vector<Method> methods = {
        {"cv::ORB", ORB::create(nfeatures), makePtr<BFMatcher>(NORM_HAMMING, true), false},
        {"AdaptiveQuadtreeORB", ours, matcher, false}};
    if (isPair)
        methods.push_back({"with growMatches", ours, matcher, true});
    std::vector<Found> found;
    for (const Method& method : methods)
        found.push_back(find(method, images, false));
    const bool isEpipolar = isPair && judge(found, known);
    if (isEpipolar)
        std::cout << "A scene in depth: the epipolar geometry explains more matches than a homography.\n";

    printRow("", found, [](const Found& one) { return one.method; });
    printRow("keypoints of image 1", found,
             [](const Found& one) { return format("%d", int(one.keypoints[0].size())); });
    printRow("  uniformity (less is more uniform)", found,
             [&](const Found& one)
             { return format("%.1f", aqorb::distributionUniformity(one.keypoints[0], images[0].size())); });
    printRow("  occupied cells of a 16x12 grid", found,
             [&](const Found& one) { return occupied(one.keypoints[0], images[0]); });
    const String kind = known.empty() ? "consistent" : "correct", distinct = "distinct " + kind + " matches";
    if (isPair)
    {
        printRow(distinct, found,
                 [](const Found& one) { return format("%d", int(one.distinct.from.size())); });
        printRow("  cells of image 1 that hold one", found,
                 [&](const Found& one) { return occupied(one.distinct.from, images[0]); });
        printRow(kind + " matches in all", found,
                 [](const Found& one)
                 { return format("%d of %d", one.right, int(one.matches.from.size())); });
        printRow("  their median error in pixels", found,
                 [](const Found& one) { return one.right > 0 ? format("%.2f", one.error) : String("-"); });
    }
    printTimes(methods, images, isEpipolar, 1);
    if (threads > 1)
        printTimes(methods, images, isEpipolar, threads);

    std::vector<Mat> keypoints, matches;
    for (size_t i = 0; i < found.size(); i++)
    {
        const Found& one = found[i];
        if (!methods[i].grows)
            keypoints.push_back(captioned(keypointPicture(images[0], one.keypoints[0]),
                                          one.method + ": keypoints of image 1"));
        if (isPair)
            matches.push_back(captioned(matchPicture(images, one.distinct),
                                        format("%s: %d %s, median error %.2f pixels", one.method.c_str(),
                                               int(one.distinct.from.size()), distinct.c_str(), one.error)));
    }
    Mat picture;
    hconcat(keypoints, picture);
    writePicture(out + "/aqorb_keypoints" + number + ".jpg", picture);
    if (!isPair)
        return;
    vconcat(matches, picture);
    writePicture(out + "/aqorb_matches" + number + ".jpg", picture);
}

int demo(int argc, char** argv)
{
    const CommandLineParser parser = parseOptions(argc, argv, KEYS, ABOUT);
    const String out = option<String>(parser, "out");
    if (!utils::fs::isDirectory(out))
        CV_Error(Error::StsObjectNotFound, out + ": cannot be written to; an existing folder is accepted");
    std::vector<Mat> images;
    for (const String& file : fileArguments(argc, argv))
    {
        images.push_back(readImage(file));
        if (std::min(images.back().cols, images.back().rows) < 32)
            CV_Error(Error::StsBadSize, file + format(" has %dx%d pixels; 32x32 or more are accepted",
                                                      images.back().cols, images.back().rows));
    }
    if (images.size() > 2)
        CV_Error(Error::StsBadArg, "one image or two are accepted");
    std::cout << LEGEND;
    if (!images.empty())
    {
        compare(images, Mat(), parser, "");
        return 0;
    }
    const char* const strecha = std::getenv("AQORB_STRECHA");
    if (strecha)
        samples::addSamplesDataSearchPath(strecha + String("/Benchmarking_Camera_Calibration_2008"));
    int number = 0;
    for (const auto& pair : PAIRS)
    {
        if (&pair == PAIRS && !strecha)
            continue;
        std::cout << ++number << ". " << pair.text << "\n" << pair.image1 << ", " << pair.image2 << "\n\n";
        Mat homography;
        if (*pair.homography)
            FileStorage(samples::findFile(pair.homography), FileStorage::READ)["H13"] >> homography;
        compare({readImage(pair.image1), readImage(pair.image2)}, homography, parser, format("%d", number));
        std::cout << std::endl;
    }
    return 0;
}

}  // namespace

int main(int argc, char** argv)
{
    return runSample(demo, argc, argv);
}
