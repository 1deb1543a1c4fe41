// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// Shows AdaptiveQuadtreeORB beside cv::ORB: where their keypoints lie, how well these match, and how fast.

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
    "OpenCV's samples: with all of the scene in both images, with a small object, and from two sides:\n"
    "  aqorb_demo --nfeatures=500 --out=pictures photograph1.jpg photograph2.jpg";

const char* const KEYS = "{help      |      | print this text }"
                         "{nfeatures | 1000 | number of keypoints to ask for }"
                         "{out       | .    | existing folder for the pictures }";

// What the program shows without images.
const struct
{
    const char *image1, *image2, *homography, *text;
} PAIRS[] = {
    {"rubberwhale1.png", "rubberwhale2.png", "",
     "1. AdaptiveQuadtreeORB wins: two frames of a video, with something to see everywhere.\n"
     "How to read it: cv::ORB's keypoints crowd where the contrast is highest, several on one corner. Those\n"
     "of AdaptiveQuadtreeORB cover the image. So more of them match at distinct places, in more cells."},
    {"box.png", "box_in_scene.png", "",
     "2. cv::ORB has more matches in all: a small box, and the same box among other things.\n"
     "How to read it: only the box is in both images. AdaptiveQuadtreeORB spreads its keypoints over the\n"
     "whole scene, so fewer of them lie on the box. As few matches are right, most of the time goes into\n"
     "RANSAC. If you look for a small object, see StrengthWeight in the tutorial on the parameters."},
    {"graf1.png", "graf3.png", "H1to3p.xml",
     "3. AdaptiveQuadtreeORB wins: a painted wall from two sides, with a known homography between them.\n"
     "How to read it: AdaptiveQuadtreeORB has more distinct correct matches, in more places on the wall."}};

const char* const LEGEND =
    "Matches are mutual nearest neighbours. Consistent: within 3 pixels of the homography estimated from\n"
    "the detector's matches; correct: of the known one. Distinct: at least 4 pixels from every better one\n"
    "in both images. cv::ORB often has more in all, because it finds a strong corner on several levels and\n"
    "each of these counts.\n"
    "Time: from the images in memory to their homography (RANSAC), by cv::ORB and cv::BFMatcher and by\n"
    "AdaptiveQuadtreeORB and HammingMatcher, in turns: median (quartiles). With one image: to its features.\n"
    "A second thread gains most with large images, and little where other programs use the processors.\n";

struct Method
{
    const char* name;
    Ptr<ORB> detector;
    Ptr<DescriptorMatcher> matcher;  // with cross check
};

//! Matched keypoints of two images: from[i] and to[i] belong together.
struct Matches
{
    void add(const KeyPoint& a, const KeyPoint& b)
    {
        from.push_back(a);
        to.push_back(b);
    }

    std::vector<KeyPoint> from, to;
};

//! What a method finds.
struct Found
{
    std::vector<KeyPoint> keypoints[2];  // of each image
    Matches matches;                     // the best first
    Matches right, distinct;  // those that agree with the homography, and the distinct ones of these
    Mat homography;           // estimated from the matches; empty: there is none
    double milliseconds;
};

//! The homography by a method of findHomography; empty where the matches give none.
Mat estimateHomography(const Matches& matches, int method)
{
    std::vector<Point2f> from, to;
    KeyPoint::convert(matches.from, from);
    KeyPoint::convert(matches.to, to);
    if (from.size() < 4)
        return Mat();
    // RANSAC as most programs call it, to be timed. More patience, to see what the matches are worth.
    return method == RANSAC ? findHomography(from, to, RANSAC)
                            : findHomography(from, to, method, 3, noArray(), 10000, 0.9999);
}

//! From one or two images to keypoints, matches and the homography.
Found find(const Method& method, const std::vector<Mat>& images, int estimator)
{
    Found found;
    Mat descriptors[2];
    TickMeter time;
    time.start();
    for (size_t i = 0; i < images.size(); i++)
        method.detector->detectAndCompute(images[i], noArray(), found.keypoints[i], descriptors[i]);
    std::vector<DMatch> matches;
    if (!descriptors[0].empty() && !descriptors[1].empty())
        method.matcher->match(descriptors[0], descriptors[1], matches);
    std::stable_sort(matches.begin(), matches.end());
    for (const DMatch& match : matches)
        found.matches.add(found.keypoints[0][match.queryIdx], found.keypoints[1][match.trainIdx]);
    found.homography = estimateHomography(found.matches, estimator);
    time.stop();
    found.milliseconds = time.getTimeMilli();
    return found;
}

/** Chooses the matches within 3 pixels of the homography, and of these the distinct ones: at least 4 pixels away from
 every better one in both images. Several keypoints on one corner of the scene say no more about it than one. */
void choose(Found& found, const Mat& homography)
{
    std::vector<Point2f> mapped;
    KeyPoint::convert(found.matches.from, mapped);
    if (!homography.empty())
        perspectiveTransform(mapped, mapped, homography);
    for (size_t i = 0; i < mapped.size() && !homography.empty(); i++)
    {
        const KeyPoint &from = found.matches.from[i], &to = found.matches.to[i];
        if (norm(mapped[i] - to.pt) > 3)
            continue;
        found.right.add(from, to);
        bool isDistinct = true;
        for (size_t j = 0; j < found.distinct.from.size(); j++)
            isDistinct &=
                norm(from.pt - found.distinct.from[j].pt) >= 4 && norm(to.pt - found.distinct.to[j].pt) >= 4;
        if (isDistinct)
            found.distinct.add(from, to);
    }
}

String occupied(const std::vector<KeyPoint>& keypoints, const Mat& image)
{
    return format("%.0f %%", 100 * aqorb::distributionOccupancy(keypoints, image.size(), Size(16, 12)));
}

void printRow(const String& label, const String& orb, const String& ours)
{
    std::cout << format("%-34s %16s %22s\n", label.c_str(), orb.c_str(), ours.c_str());
}

//! The seconds that all processors together have worked since the system began; 0 where that is not known.
double busySeconds()
{
    std::ifstream file("/proc/stat");  // Linux: in hundredths of a second
    String name;
    double user = 0, nice = 0, system = 0, idle, waiting, interrupts = 0, softInterrupts = 0;
    file >> name >> user >> nice >> system >> idle >> waiting >> interrupts >> softInterrupts;
    return 0.01 * (user + nice + system + interrupts + softInterrupts);
}

//! The median, and in brackets the quartiles.
String spread(std::vector<double> values, const char* number)
{
    std::sort(values.begin(), values.end());
    const auto at = [&](double share)
    { return format(number, values[size_t(share * double(values.size() - 1))]); };
    return at(0.5) + " (" + at(0.25) + "-" + at(0.75) + ")";
}

//! Measures both methods in turns, so that other work slows both of them.
void printTimes(const std::vector<Method>& methods, const std::vector<Mat>& images, int threads)
{
    setNumThreads(threads);
    std::vector<double> times[2], gains;
    TickMeter time;
    const double busyBefore = busySeconds();
    const std::clock_t ownBefore = std::clock();
    for (int turn = 0; turn < 8 || (turn < 101 && time.getTimeSec() < 2); turn++)
    {
        time.start();
        for (int i = 0; i < 2; i++)
            times[i].push_back(find(methods[i], images, RANSAC).milliseconds);
        time.stop();
        gains.push_back(times[0].back() / times[1].back());
    }
    const double own = double(std::clock() - ownBefore) / CLOCKS_PER_SEC;
    const double others = (busySeconds() - busyBefore - own) / time.getTimeSec();
    printRow(format("time in ms, %d thread%s", threads, threads > 1 ? "s" : ""), spread(times[0], "%.2f"),
             spread(times[1], "%.2f"));
    printRow("  times as fast", "1", spread(gains, "%.1f"));
    if (others > 0.15)
        std::cout << format("  Busy: other programs use %.1f of %d processors. Repeat this later.\n", others,
                            getNumberOfCPUs());
}

const double PANEL = 640;  // pixels, the width of an image in the pictures

Mat panel(const Mat& image, double scale, double brightness)
{
    Mat picture;
    resize(image * brightness, picture, Size(), scale, scale, scale < 1 ? INTER_AREA : INTER_LINEAR);
    cvtColor(picture, picture, COLOR_GRAY2BGR);
    return picture;
}

//! A circle at a position of an image that was scaled.
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

//! Two images side by side, darker, with a line for each match.
Mat matchPicture(const std::vector<Mat>& images, const Matches& matches)
{
    const double scale = PANEL / std::max(images[0].cols, images[1].cols);
    const Mat left = panel(images[0], scale, 0.6), right = panel(images[1], scale, 0.6);
    Mat picture(std::max(left.rows, right.rows), left.cols + right.cols, CV_8UC3, Scalar::all(255));
    left.copyTo(picture(Rect(Point(0, 0), left.size())));
    Mat rightPart = picture(Rect(Point(left.cols, 0), right.size()));
    right.copyTo(rightPart);
    // Hundreds of lines would hide the images. So they are translucent, and of many matches only some have one.
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

//! Compares on one image or two. The homography between two may be known. The names of the pictures end with `number`.
void compare(const std::vector<Mat>& images, const Mat& known, const CommandLineParser& parser,
             const String& number)
{
    const int nfeatures = option<int>(parser, "nfeatures"), threads = getNumThreads();
    const bool isPair = images.size() == 2;
    const std::vector<Method> methods = {
        {"cv::ORB", ORB::create(nfeatures), makePtr<BFMatcher>(NORM_HAMMING, true)},
        {"AdaptiveQuadtreeORB", aqorb::AdaptiveQuadtreeORB::create(nfeatures),
         makePtr<aqorb::HammingMatcher>(NORM_HAMMING, true)}};
    const String kind = known.empty() ? "consistent" : "correct";
    std::vector<String> labels, texts[2];  // of the table's rows
    Mat keypoints[2], matches[2], picture;
    for (int i = 0; i < 2; i++)
    {
        Found found = find(methods[i], images, USAC_MAGSAC);
        choose(found, known.empty() ? found.homography : known);
        String counts, uniformity, cells;
        for (size_t j = 0; j < images.size(); j++)
        {
            const String comma = j > 0 ? ", " : "";
            counts += comma + format("%d", int(found.keypoints[j].size()));
            uniformity +=
                comma + format("%.1f", aqorb::distributionUniformity(found.keypoints[j], images[j].size()));
            cells += comma + occupied(found.keypoints[j], images[j]);
        }
        const String name = methods[i].name, distinct = "distinct " + kind + " matches";
        labels = {"", "keypoints", "uniformity (less is more uniform)", "occupied cells of a 16x12 grid"};
        texts[i] = {name, counts, uniformity, cells};
        keypoints[i] =
            captioned(keypointPicture(images[0], found.keypoints[0]), name + ": keypoints of image 1");
        if (!isPair)
            continue;
        const int count = int(found.distinct.from.size()), right = int(found.right.from.size());
        labels.insert(labels.end(), {distinct, "  cells of image 1 that hold one", kind + " matches in all"});
        texts[i].insert(texts[i].end(), {format("%d", count), occupied(found.distinct.from, images[0]),
                                         format("%d of %d", right, int(found.matches.from.size()))});
        matches[i] = captioned(matchPicture(images, found.distinct),
                               format("%s: %d %s", methods[i].name, count, distinct.c_str()));
    }
    for (size_t i = 0; i < labels.size(); i++)
        printRow(labels[i], texts[0][i], texts[1][i]);
    printTimes(methods, images, 1);
    if (threads > 1)
        printTimes(methods, images, threads);

    hconcat(keypoints, 2, picture);
    writePicture(option<String>(parser, "out") + "/aqorb_keypoints" + number + ".jpg", picture);
    if (!isPair)
        return;
    vconcat(matches, 2, picture);
    writePicture(option<String>(parser, "out") + "/aqorb_matches" + number + ".jpg", picture);
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
    if (!images.empty())
        compare(images, Mat(), parser, "");
    for (int i = 0; i < 3 && images.empty(); i++)
    {
        std::cout << PAIRS[i].text << "\n" << PAIRS[i].image1 << ", " << PAIRS[i].image2 << "\n\n";
        Mat homography;
        if (*PAIRS[i].homography)
            FileStorage(samples::findFile(PAIRS[i].homography), FileStorage::READ)["H13"] >> homography;
        compare({readImage(PAIRS[i].image1), readImage(PAIRS[i].image2)}, homography, parser,
                format("%d", i + 1));
        std::cout << std::endl;
    }
    std::cout << LEGEND;
    return 0;
}

}  // namespace

int main(int argc, char** argv)
{
    return runSample(demo, argc, argv);
}
