// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// Compares AdaptiveQuadtreeORB and matchImages with cv::ORB: positions of keypoints, matches, and times.

#include "sample.hpp"

#include <opencv2/aqorb.hpp>

using namespace cv;

namespace
{

const char* const ABOUT =
    "Compares cv::aqorb::AdaptiveQuadtreeORB with cv::ORB on two images, by a table and a picture,\n"
    "aqorb_demo.jpg:\n"
    "  aqorb_demo --nfeatures=500 --out=pictures photograph1.jpg photograph2.jpg\n"
    "Without images it takes three pairs of OpenCV's samples and, if the variable AQORB_STRECHA names\n"
    "Strecha's photographs, two of a fountain.\n";

const char* const LEGEND =
    "\nThe first two columns match mutual nearest neighbours. matchImages also refines the matches, and\n"
    "finds more nearby. A match agrees if it lies within 3 pixels of the homography or, in a scene in\n"
    "depth, of the epipolar line; 1.5 pixels for matchImages. Places are cells of 16 x 16 pixels with\n"
    "such a match, in the image that has fewer. A frame is image 1 to keypoints and descriptors, a pair\n"
    "is both images to their geometry by USAC_MAGSAC. Times are medians on one thread.\n";

const char* const KEYS = "{help      |      | print this text }"
                         "{nfeatures | 1000 | number of keypoints to ask for }"
                         "{out       | .    | existing folder for the pictures }";

struct Method
{
    String name;
    Ptr<ORB> detector;
    Ptr<DescriptorMatcher> matcher;  // with cross check; matchImages takes the place of an empty one
    double threshold;                // of a match that agrees, in pixels
};

//! Result of a method.
struct Found
{
    std::vector<KeyPoint> keypoints;        // of image 1
    size_t matches;                         // number of matches, whether or not they agree
    std::vector<Point2f> points1, points2;  // of the matches that agree with the geometry
    std::vector<double> frames, pairs;      // times in milliseconds

    int places() const { return countPlaces(points1, points2); }
};

//! Finds points of two images that show the same spots.
void match(const Method& method, const Mat& image1, const Mat& image2, Found& found)
{
    found.points1.clear();
    found.points2.clear();
    if (!method.matcher)
    {
        std::vector<float> deviations;
        return aqorb::matchImages(image1, image2, found.points1, found.points2, deviations,
                                  method.detector->getMaxFeatures());
    }
    std::vector<KeyPoint> keypoints1, keypoints2;
    Mat descriptors1, descriptors2;
    std::vector<DMatch> matches;
    method.detector->detectAndCompute(image1, noArray(), keypoints1, descriptors1);
    method.detector->detectAndCompute(image2, noArray(), keypoints2, descriptors2);
    if (!descriptors1.empty() && !descriptors2.empty())
        method.matcher->match(descriptors1, descriptors2, matches);
    for (const DMatch& each : matches)
    {
        found.points1.push_back(keypoints1[each.queryIdx].pt);
        found.points2.push_back(keypoints2[each.trainIdx].pt);
    }
}

//! Keeps the matches that agree with a homography or an epipolar geometry.
void estimate(const Method& method, bool isEpipolar, Found& found)
{
    std::vector<uchar> agrees;
    found.matches = found.points1.size();
    if (found.matches >= 8 && isEpipolar)
        findFundamentalMat(found.points1, found.points2, USAC_MAGSAC, method.threshold, 0.9999, 10000,
                           agrees);
    else if (found.matches >= 8)
        findHomography(found.points1, found.points2, USAC_MAGSAC, method.threshold, agrees, 10000, 0.9999);
    found.points1 = flagged(found.points1, agrees);
    found.points2 = flagged(found.points2, agrees);
}

void measure(const Method& method, const Mat& image1, const Mat& image2, bool isEpipolar, Found& found)
{
    TickMeter frame, pair;
    Mat descriptors;
    frame.start();
    method.detector->detectAndCompute(image1, noArray(), found.keypoints, descriptors);
    frame.stop();
    pair.start();
    match(method, image1, image2, found);
    estimate(method, isEpipolar, found);
    pair.stop();
    found.frames.push_back(frame.getTimeMilli());
    found.pairs.push_back(pair.getTimeMilli());
}

double median(std::vector<double> values)
{
    std::sort(values.begin(), values.end());
    return values[values.size() / 2];
}

//! The image 800 pixels wide, and its points there.
Mat reduce(const Mat& image, const std::vector<Point2f>& points, std::vector<KeyPoint>& keypoints)
{
    const double scale = 800. / image.cols;
    for (const Point2f& point : points)
        keypoints.emplace_back((point + Point2f(.5f, .5f)) * scale - Point2f(.5f, .5f), 1.f);
    Mat reduced;
    resize(image, reduced, Size(800, cvCeil(image.rows * scale)), 0, 0,
           scale < 1 ? INTER_AREA : INTER_LINEAR);
    return reduced;
}

//! Both images side by side with their points. Pairs of points have at most 100 lines: more would hide the images.
Mat draw(const Mat& image1, const std::vector<Point2f>& points1, const Mat& image2,
         const std::vector<Point2f>& points2, bool hasLines, const String& caption)
{
    std::vector<KeyPoint> keypoints1, keypoints2;
    const Mat left = reduce(image1, points1, keypoints1), right = reduce(image2, points2, keypoints2);
    std::vector<DMatch> lines;
    for (int i = 0; hasLines && i < int(points1.size()); i += int(points1.size()) / 100 + 1)
        lines.emplace_back(i, i, 0.f);
    const Scalar yellow(0, 255, 255);
    Mat picture;
    drawMatches(left, keypoints1, right, keypoints2, lines, picture, yellow, yellow);
    return captioned(picture, caption);
}

//! Compares the methods on two images, and writes a picture.
void compare(const Mat& image1, const Mat& image2, int nfeatures, const String& file)
{
    for (const Mat& image : {image1, image2})
        if (std::min(image.cols, image.rows) < 32)
            CV_Error(Error::StsBadSize,
                     format("an image of %dx%d pixels; 32x32 or more are accepted", image.cols, image.rows));
    const Ptr<ORB> ours = aqorb::AdaptiveQuadtreeORB::create(nfeatures);
    const std::vector<Method> methods = {
        {"cv::ORB", ORB::create(nfeatures), makePtr<BFMatcher>(NORM_HAMMING, true), 3},
        {"AdaptiveQuadtreeORB", ours, makePtr<aqorb::HammingMatcher>(NORM_HAMMING, true), 3},
        {"matchImages", ours, nullptr, 1.5}};

    // find_object and the command "aqorb draw" decide so, too: a homography with few places is none.
    Found plane;
    match(methods[2], image1, image2, plane);
    Found depth = plane;
    estimate(methods[2], false, plane);
    estimate(methods[2], true, depth);
    const bool isSame = plane.places() >= MIN_PLACES;
    const bool isEpipolar = isSame && 2 * depth.points1.size() > 3 * plane.points1.size();

    std::vector<Found> found(methods.size());
    for (int turn = 0; turn < 11; turn++)  // in turns, so that other programs slow all methods equally
        for (size_t i = 0; i < methods.size(); i++)
            measure(methods[i], image1, image2, isEpipolar, found[i]);

    std::vector<std::vector<String>> columns = {
        {isEpipolar ? "by epipolar lines" : "by a homography", "keypoints of image 1",
         "  cells of a 16 x 12 grid that hold one", "matches that agree, of all", "  their places",
         "frame in ms", "  times as fast", "pair in ms", "  times as fast"}};
    const double orbFrame = median(found[0].frames), orbPair = median(found[0].pairs);
    for (size_t i = 0; i < found.size(); i++)
    {
        const double occupancy =
            aqorb::distributionOccupancy(found[i].keypoints, image1.size(), Size(16, 12));
        const double frame = median(found[i].frames), pair = median(found[i].pairs);
        columns.push_back({methods[i].name, format("%d", int(found[i].keypoints.size())),
                           format("%.0f %%", 100 * occupancy),
                           format("%d of %d", int(found[i].points1.size()), int(found[i].matches)),
                           format("%d", found[i].places()), format("%.1f", frame),
                           format("%.1f", orbFrame / frame), format("%.1f", pair),
                           format("%.1f", orbPair / pair)});
    }
    printTable(columns);
    if (!isSame)
        std::cout << "Fewer than " << MIN_PLACES << " places of matchImages agree with a homography: "
                  << "the images probably show different things.\n";

    std::vector<Point2f> keypoints[2];
    for (int i = 0; i < 2; i++)
        KeyPoint::convert(found[i].keypoints, keypoints[i]);
    std::vector<Mat> rows = {
        draw(image1, keypoints[0], image1, keypoints[1], false,
             "keypoints of image 1: cv::ORB on the left, AdaptiveQuadtreeORB on the right")};
    for (size_t i = 0; i < found.size(); i++)
        rows.push_back(draw(image1, found[i].points1, image2, found[i].points2, true,
                            methods[i].name + format(": %d places", found[i].places())));
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
         "a box, and the same box among other things, where matchImages finds it"},
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
        std::cout << (i == 0 ? LEGEND : "") << std::endl;
    }
}

int demo(int argc, char** argv)
{
    const CommandLineParser parser = parseOptions(argc, argv, KEYS, ABOUT + String(LEGEND));
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
    {
        compare(readImage(files[0]), readImage(files[1]), nfeatures, out + "/aqorb_demo.jpg");
        std::cout << LEGEND;
    }
    return 0;
}

}  // namespace

int main(int argc, char** argv)
{
    return runSample(demo, argc, argv);
}
