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
#include <ctime>
#include <fstream>

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
     "cv::ORB has more matches in all: a small box, and the same box among other things.\n"
     "AdaptiveQuadtreeORB spreads its keypoints over the whole scene, so fewer of them lie on the box. If "
     "you\n"
     "look for a small object, see StrengthWeight in the tutorial on the parameters."},
    {"graf1.png", "graf3.png", "H1to3p.xml",
     "AdaptiveQuadtreeORB wins: a painted wall from two sides, with a known homography between them."}};

const char* const LEGEND =
    "How to read it: cv::ORB's keypoints crowd where the contrast is highest, several on one corner.\n"
    "Those of AdaptiveQuadtreeORB cover the image. So more of them match at distinct places, in more\n"
    "cells. The last column adds growMatches, which moves a match to where both images show the same spot,\n"
    "leaves it out where they show none, and finds more beside. In the picture, red is what it left out.\n"
    "Matches are mutual nearest neighbours. Correct: within 3 pixels of the known homography. Consistent:\n"
    "within 3 pixels of the homography estimated from the detector's matches or, in a scene in depth, of\n"
    "the epipolar line, where a dozen wrong matches may lie by chance. Distinct: at least 4 pixels from\n"
    "every better one in both images. cv::ORB often has more in all, because it finds a strong corner on\n"
    "several levels and each of these counts.\n"
    "Times are medians (quartiles); the methods take turns. Frame: image 1 to keypoints and descriptors.\n"
    "Pair: two images to their geometry. That is the features of both, matching by cv::BFMatcher or by\n"
    "HammingMatcher, growMatches in the last column, and RANSAC. Where few matches are right, RANSAC\n"
    "takes most of it. A second thread gains most with large images.\n\n";

struct Method
{
    const char* name;
    Ptr<ORB> detector;
    Ptr<DescriptorMatcher> matcher;  // with cross check
    bool grows;                      // whether growMatches refines and adds matches
};

//! Matched positions of two images: from[i] matches to[i].
struct Matches
{
    void add(const KeyPoint& a, const KeyPoint& b)
    {
        from.push_back(a);
        to.push_back(b);
    }

    std::vector<KeyPoint> from, to;
};

//! Results of a method.
struct Found
{
    std::vector<KeyPoint> keypoints[2];  // of each image
    Matches matches;                     // the best first
    Matches leftOut;                     // removed by growMatches
    Matches right, distinct;             // matches that agree with the geometry, and the distinct among them
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

//! Estimates the geometry by RANSAC: timed with the usual settings, else with more iterations, to judge the matches.
Geometry estimate(const Matches& matches, bool isEpipolar, bool isTimed, double threshold)
{
    std::vector<Point2f> from, to;
    KeyPoint::convert(matches.from, from);
    KeyPoint::convert(matches.to, to);
    Mat matrix;
    if (from.size() < 8)
        return {Matx33d(), isEpipolar, false};
    if (isEpipolar)
        matrix = isTimed ? findFundamentalMat(from, to, RANSAC, threshold)
                         : findFundamentalMat(from, to, USAC_MAGSAC, threshold, 0.9999, 10000);
    else
        matrix = isTimed ? findHomography(from, to, RANSAC, threshold)
                         : findHomography(from, to, USAC_MAGSAC, threshold, noArray(), 10000, 0.9999);
    const bool isFound = matrix.size() == Size(3, 3);
    return {isFound ? Matx33d(matrix.ptr<double>()) : Matx33d(), isEpipolar, isFound};
}

//! Finds keypoints in one or two images, their matches and, by RANSAC, the geometry.
Found find(const Method& method, const std::vector<Mat>& images, bool isEpipolar)
{
    Found found;
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
    std::vector<DMatch> kept = matches;
    std::vector<KeyPoint> grown2 = found.keypoints[1];
    std::vector<Point2f> from, to;
    std::vector<float> deviations;
    if (method.grows)
        aqorb::growMatches(images[0], found.keypoints[0], images[1], found.keypoints[1], kept, grown2, from,
                           to, deviations);
    size_t next = 0;
    for (const DMatch& match : matches)
    {
        KeyPoint a = found.keypoints[0][match.queryIdx], b = found.keypoints[1][match.trainIdx];
        const bool isKept = next < kept.size() && kept[next].queryIdx == match.queryIdx &&
                            kept[next].trainIdx == match.trainIdx;
        if (isKept && method.grows)
            b.pt = to[next];
        (isKept ? found.matches : found.leftOut).add(a, b);
        next += isKept;
    }
    for (; next < kept.size(); next++)
        found.matches.add(found.keypoints[0][kept[next].queryIdx], grown2[kept[next].trainIdx]);
    if (images.size() == 2)
        estimate(found.matches, isEpipolar, true, method.grows ? 1 : 3);
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
        found.right.add(from, to);
        bool isDistinct = true;
        for (size_t j = 0; j < found.distinct.from.size(); j++)
            isDistinct &=
                norm(from.pt - found.distinct.from[j].pt) >= 4 && norm(to.pt - found.distinct.to[j].pt) >= 4;
        if (isDistinct)
            found.distinct.add(from, to);
    }
    std::sort(errors.begin(), errors.end());
    found.error = errors.empty() ? 0 : errors[errors.size() / 2];
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
            const Geometry geometry = known.empty()
                                          ? estimate(one.matches, isEpipolar > 0, false, isEpipolar ? 1 : 3)
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

//! Prints a row of the table: its label, and a text for each method.
void printRow(const String& label, const std::vector<String>& texts)
{
    std::cout << format("%-34s", label.c_str());
    for (const String& text : texts)
        std::cout << format(" %21s", text.c_str());
    std::cout << "\n";
}

//! Seconds of work of all processors since the system began; 0 if unknown.
double busySeconds()
{
    std::ifstream file("/proc/stat");  // Linux: in hundredths of a second
    String name;
    double user = 0, nice = 0, system = 0, idle, waiting, interrupts = 0, softInterrupts = 0;
    file >> name >> user >> nice >> system >> idle >> waiting >> interrupts >> softInterrupts;
    return 0.01 * (user + nice + system + interrupts + softInterrupts);
}

//! Median, and quartiles in brackets.
String spread(std::vector<double> values, const char* number)
{
    std::sort(values.begin(), values.end());
    const auto at = [&](double share)
    { return format(number, values[size_t(share * double(values.size() - 1))]); };
    return at(0.5) + " (" + at(0.25) + "-" + at(0.75) + ")";
}

/** Measures the methods in turns, so that other programs slow all of them equally.
 @return number of processors that other programs used */
double printTimes(const std::vector<Method>& methods, const std::vector<Mat>& images, bool isEpipolar,
                  int threads)
{
    setNumThreads(threads);
    typedef std::vector<std::vector<double>> Values;  // of each method
    Values times[2] = {Values(methods.size()), Values(methods.size())}, gains[2] = {times[0], times[0]};
    TickMeter time;
    const double busyBefore = busySeconds();
    const std::clock_t ownBefore = std::clock();
    for (int turn = 0; turn < 8 || (turn < 101 && time.getTimeSec() < 2); turn++)
    {
        time.start();
        for (size_t i = 0; i < methods.size(); i++)
        {
            const Found found = find(methods[i], images, isEpipolar);
            for (size_t j = 0; j < images.size(); j++)
            {
                times[j][i].push_back(found.milliseconds[j]);
                gains[j][i].push_back(times[j][0].back() / times[j][i].back());
            }
        }
        time.stop();
    }
    const double own = double(std::clock() - ownBefore) / CLOCKS_PER_SEC;
    for (size_t j = 0; j < images.size(); j++)
    {
        std::vector<String> texts[2];
        for (size_t i = 0; i < methods.size(); i++)
        {
            texts[0].push_back(spread(times[j][i], "%.1f"));
            texts[1].push_back(i > 0 ? spread(gains[j][i], "%.1f") : "1");
        }
        printRow(format("%s in ms, %d thread%s", j > 0 ? "pair" : "frame", threads, threads > 1 ? "s" : ""),
                 texts[0]);
        printRow("  times as fast", texts[1]);
    }
    return (busySeconds() - busyBefore - own) / time.getTimeSec();
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
void drawCircle(Mat& picture, const Point2f& position, double scale,
                const Scalar& colour = Scalar(0, 255, 255))
{
    const int BITS = 4;  // of the fraction
    const Point2d half(0.5, 0.5), centre = (Point2d(position) + half) * scale - half;
    circle(picture, Point(centre * (1 << BITS)), 3 << BITS, colour, 1, LINE_AA, BITS);
}

Mat keypointPicture(const Mat& image, const std::vector<KeyPoint>& keypoints)
{
    const double scale = PANEL / image.cols;
    Mat picture = panel(image, scale, 1);
    for (const KeyPoint& keypoint : keypoints)
        drawCircle(picture, keypoint.pt, scale);
    return picture;
}

//! Two darkened images side by side, with a line for each match, and with the removed matches in red.
Mat matchPicture(const std::vector<Mat>& images, const Matches& matches, const Matches& leftOut)
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
    for (size_t i = 0; i < leftOut.from.size(); i++)
    {
        drawCircle(picture, leftOut.from[i].pt, scale, Scalar(60, 60, 255));
        drawCircle(rightPart, leftOut.to[i].pt, scale, Scalar(60, 60, 255));
    }
    for (size_t i = 0; i < count; i++)
    {
        drawCircle(picture, matches.from[i].pt, scale);
        drawCircle(rightPart, matches.to[i].pt, scale);
    }
    return picture;
}

/** Compares the methods on one image or two, with or without a known homography. Names of pictures end with `number`.
 @return number of processors that other programs used meanwhile */
double compare(const std::vector<Mat>& images, const Mat& known, const CommandLineParser& parser,
               const String& number)
{
    const int nfeatures = option<int>(parser, "nfeatures"), threads = getNumThreads();
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
    const String kind = known.empty() ? "consistent" : "correct", distinct = "distinct " + kind + " matches";
    std::vector<String> labels = {"", "keypoints", "uniformity (less is more uniform)",
                                  "occupied cells of a 16x12 grid"};
    if (isPair)
        labels.insert(labels.end(), {distinct, "  cells of image 1 that hold one", kind + " matches in all",
                                     "  their median error in pixels"});
    std::vector<std::vector<String>> rows(labels.size());
    std::vector<Mat> keypoints, matches;
    for (size_t i = 0; i < methods.size(); i++)
    {
        const Found& one = found[i];
        String counts, uniformity, cells;
        for (size_t j = 0; j < images.size(); j++)
        {
            const String comma = j > 0 ? ", " : "";
            counts += comma + format("%d", int(one.keypoints[j].size()));
            uniformity +=
                comma + format("%.1f", aqorb::distributionUniformity(one.keypoints[j], images[j].size()));
            cells += comma + occupied(one.keypoints[j], images[j]);
        }
        const String name = methods[i].name;
        std::vector<String> texts = {name, counts, uniformity, cells};
        if (!methods[i].grows)
            keypoints.push_back(
                captioned(keypointPicture(images[0], one.keypoints[0]), name + ": keypoints of image 1"));
        if (isPair)
        {
            const int right = int(one.right.from.size()), all = int(one.matches.from.size());
            const int count = int(one.distinct.from.size()), leftOut = int(one.leftOut.from.size());
            texts.insert(texts.end(),
                         {format("%d", count), occupied(one.distinct.from, images[0]),
                          format("%d of %d", right, all), right ? format("%.2f", one.error) : "-"});
            matches.push_back(
                captioned(matchPicture(images, one.distinct, one.leftOut),
                          format("%s: %d %s, median error %.2f pixels", methods[i].name, count,
                                 distinct.c_str(), one.error) +
                              (methods[i].grows ? format(", %d left out", leftOut) : String())));
        }
        for (size_t j = 0; j < rows.size(); j++)
            rows[j].push_back(texts[j]);
    }
    for (size_t i = 0; i < rows.size(); i++)
        printRow(labels[i], rows[i]);
    double others = printTimes(methods, images, isEpipolar, 1);
    if (threads > 1)
        others = std::max(others, printTimes(methods, images, isEpipolar, threads));

    Mat picture;
    hconcat(keypoints, picture);
    writePicture(option<String>(parser, "out") + "/aqorb_keypoints" + number + ".jpg", picture);
    if (!isPair)
        return others;
    vconcat(matches, picture);
    writePicture(option<String>(parser, "out") + "/aqorb_matches" + number + ".jpg", picture);
    return others;
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
    double others = 0;
    if (!images.empty())
        others = compare(images, Mat(), parser, "");
    const char* const strecha = std::getenv("AQORB_STRECHA");
    if (strecha)
        samples::addSamplesDataSearchPath(strecha + String("/Benchmarking_Camera_Calibration_2008"));
    int number = 0;
    for (const auto& pair : PAIRS)
    {
        if (!images.empty() || (&pair == PAIRS && !strecha))
            continue;
        std::cout << ++number << ". " << pair.text << "\n" << pair.image1 << ", " << pair.image2 << "\n\n";
        Mat homography;
        if (*pair.homography)
            FileStorage(samples::findFile(pair.homography), FileStorage::READ)["H13"] >> homography;
        others = std::max(others, compare({readImage(pair.image1), readImage(pair.image2)}, homography,
                                          parser, format("%d", number)));
        std::cout << std::endl;
    }
    if (others > 0.15)
        std::cout << format(
            "Busy: other programs used up to %.1f of %d processors. Repeat this later for times.\n", others,
            getNumberOfCPUs());
    return 0;
}

}  // namespace

int main(int argc, char** argv)
{
    return runSample(demo, argc, argv);
}
