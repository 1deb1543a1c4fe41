// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// Shows AdaptiveQuadtreeORB beside cv::ORB: where their keypoints lie and how well these match.

#include <opencv2/aqorb.hpp>
#include <opencv2/aqorb/features.hpp>
#include <opencv2/core/utility.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#if CV_VERSION_MAJOR >= 5
#include <opencv2/geometry.hpp>
#else
#include <opencv2/calib3d.hpp>
#endif

#include <algorithm>
#include <iostream>

using namespace cv;

namespace
{

const char* const ABOUT =
    "Compares cv::aqorb::AdaptiveQuadtreeORB with cv::ORB: prints a table and writes the pictures\n"
    "aqorb_keypoints.jpg and, for two images, aqorb_matches.jpg. More than two images are taken one\n"
    "by one (aqorb_keypoints1.jpg, ...). Without images it takes three pairs of OpenCV's samples: one\n"
    "where all of the scene is in both images, one with a small object, and one from two sides:\n"
    "  aqorb_demo --nfeatures=500 --out=pictures photograph1.jpg photograph2.jpg";

const char* const KEYS = "{help       |      | print this text }"
                         "{homography |      | XML, YAML or JSON file with the 3x3 homography from image 1 "
                         "to image 2; without it those "
                         "matches are counted that agree with the homography estimated from them }"
                         "{nfeatures  | 1000 | number of keypoints to ask for }"
                         "{out        | .    | existing folder for the pictures }";

const Scalar YELLOW(0, 255, 255);

//! The features of one image.
struct Features
{
    std::vector<KeyPoint> keypoints;
    Mat descriptors;
};

//! Mutual nearest neighbours, those of BFMatcher(normType, true), the best first.
std::vector<DMatch> matchFeatures(const Features& a, const Features& b, int normType)
{
    std::vector<DMatch> matches;
    if (!a.descriptors.empty() && !b.descriptors.empty())
        aqorb::HammingMatcher(normType, true).match(a.descriptors, b.descriptors, matches);
    std::stable_sort(matches.begin(), matches.end());
    return matches;
}

//! The positions of matches in both images.
void matchedPoints(const Features& a, const Features& b, const std::vector<DMatch>& matches,
                   std::vector<Point2f>& from, std::vector<Point2f>& to)
{
    for (const DMatch& match : matches)
    {
        from.push_back(a.keypoints[match.queryIdx].pt);
        to.push_back(b.keypoints[match.trainIdx].pt);
    }
}

//! The homography from the first image to the second; empty where the matches give none.
Mat estimateHomography(const Features& a, const Features& b, const std::vector<DMatch>& matches)
{
    std::vector<Point2f> from, to;
    matchedPoints(a, b, matches, from, to);
    if (matches.size() < 4)
        return Mat();
    return findHomography(from, to, USAC_MAGSAC, 3, noArray(), 10000, 0.9999);
}

//! The matches within 3 pixels of the homography.
std::vector<DMatch> agreeing(const Features& a, const Features& b, const std::vector<DMatch>& matches,
                             const Mat& homography)
{
    std::vector<DMatch> found;
    if (matches.empty() || homography.empty())
        return found;
    std::vector<Point2f> from, to, mapped;
    matchedPoints(a, b, matches, from, to);
    perspectiveTransform(from, mapped, homography);
    for (size_t i = 0; i < matches.size(); i++)
        if (norm(mapped[i] - to[i]) <= 3)
            found.push_back(matches[i]);
    return found;
}

/** Those of the matches that are at least 4 pixels away from every better one in both images: several keypoints on one
 corner of the scene say no more about it than one. */
std::vector<DMatch> distinct(const Features& a, const Features& b, const std::vector<DMatch>& matches)
{
    std::vector<DMatch> kept;
    for (const DMatch& match : matches)
    {
        const auto isNear = [&](const DMatch& better)
        {
            return norm(a.keypoints[match.queryIdx].pt - a.keypoints[better.queryIdx].pt) < 4 ||
                   norm(b.keypoints[match.trainIdx].pt - b.keypoints[better.trainIdx].pt) < 4;
        };
        if (std::none_of(kept.begin(), kept.end(), isNear))
            kept.push_back(match);
    }
    return kept;
}

//! How far apart two homographies map the corners of an image, on average; in pixels.
double cornerError(const Mat& a, const Mat& b, Size size)
{
    const float right = float(size.width - 1), bottom = float(size.height - 1);
    const std::vector<Point2f> corners = {{0, 0}, {right, 0}, {right, bottom}, {0, bottom}};
    std::vector<Point2f> cornersA, cornersB;
    perspectiveTransform(corners, cornersA, a);
    perspectiveTransform(corners, cornersB, b);
    double sum = 0;
    for (size_t i = 0; i < corners.size(); i++)
        sum += norm(cornersA[i] - cornersB[i]);
    return sum / corners.size();
}

//! Median times of detectAndCompute in ms. The detectors take turns, so that other load slows all of them.
std::vector<double> medianTimes(const std::vector<Ptr<ORB>>& detectors, const Mat& image, int repeats = 31)
{
    std::vector<std::vector<double>> times(detectors.size());
    for (int i = 0; i < repeats * int(detectors.size()); i++)
    {
        const size_t turn = i % detectors.size();
        Features features;
        const int64 start = getTickCount();
        detectors[turn]->detectAndCompute(image, noArray(), features.keypoints, features.descriptors);
        times[turn].push_back(1e3 * (getTickCount() - start) / getTickFrequency());
    }
    std::vector<double> medians;
    for (std::vector<double>& all : times)
    {
        std::sort(all.begin(), all.end());
        medians.push_back(all[all.size() / 2]);
    }
    return medians;
}

//! How much larger circles and letters are than on a picture of 800x640 pixels; at least 1.
double drawingScale(Size size)
{
    return std::max(1., std::sqrt(double(size.width) * size.height / (800 * 640)));
}

int lineWidth(Size size)
{
    return cvRound(drawingScale(size));
}

//! By which factor a small image is enlarged, so that circles and a caption find room on it.
int enlargement(Size size)
{
    const int WIDTH = 400;
    return std::max(1, (WIDTH + size.width - 1) / size.width);
}

//! The image in colour, enlarged.
Mat canvas(const Mat& image, int factor)
{
    Mat picture;
    resize(image, picture, Size(), factor, factor, INTER_NEAREST);
    if (picture.channels() == 1)
        cvtColor(picture, picture, COLOR_GRAY2BGR);
    return picture;
}

//! Where a position lies on the enlarged image. The centre of a pixel has whole numbers on both.
Point2f enlarged(const Point2f& position, int factor)
{
    const Point2f half(0.5f, 0.5f);
    return (position + half) * factor - half;
}

//! A circle at a fraction of a pixel.
void drawCircle(Mat& picture, const Point2f& centre, double radius, int width)
{
    const int BITS = 4;  // of the fraction
    circle(picture, Point(centre * (1 << BITS)), cvRound(radius * (1 << BITS)), YELLOW, width, LINE_AA, BITS);
}

//! The image with a circle at each keypoint.
Mat keypointPicture(const Mat& image, const std::vector<KeyPoint>& keypoints)
{
    const int factor = enlargement(image.size());
    Mat picture = canvas(image, factor);
    for (const KeyPoint& keypoint : keypoints)
        drawCircle(picture, enlarged(keypoint.pt, factor), 3 * drawingScale(picture.size()),
                   lineWidth(picture.size()));
    return picture;
}

/** Two images side by side, darker, with a line for each match. */
Mat matchPicture(const Mat& image1, const std::vector<KeyPoint>& keypoints1, const Mat& image2,
                 const std::vector<KeyPoint>& keypoints2, const std::vector<DMatch>& matches)
{
    const int factor = std::min(enlargement(image1.size()), enlargement(image2.size()));
    const Mat left = canvas(image1 * 0.6, factor), right = canvas(image2 * 0.6, factor);
    Mat picture(std::max(left.rows, right.rows), left.cols + right.cols, CV_8UC3, Scalar::all(255));
    left.copyTo(picture(Rect(Point(0, 0), left.size())));
    right.copyTo(picture(Rect(Point(left.cols, 0), right.size())));

    const Size size(std::max(left.cols, right.cols), picture.rows);
    const Point2f shift(float(left.cols), 0);
    // Hundreds of lines would hide the images. So they are translucent, and of many matches only some have one. All have
    // circles at their ends.
    const size_t LINES = 100, step = (matches.size() + LINES - 1) / LINES;
    Mat lines = picture.clone();
    for (size_t i = 0; i < matches.size(); i += step)
        line(lines, enlarged(keypoints1[matches[i].queryIdx].pt, factor),
             enlarged(keypoints2[matches[i].trainIdx].pt, factor) + shift, YELLOW, lineWidth(size), LINE_AA);
    addWeighted(lines, 0.4, picture, 0.6, 0, picture);
    for (const DMatch& match : matches)
        for (const Point2f& end : {enlarged(keypoints1[match.queryIdx].pt, factor),
                                   enlarged(keypoints2[match.trainIdx].pt, factor) + shift})
            drawCircle(picture, end, 3 * drawingScale(size), lineWidth(size));
    return picture;
}

//! The picture with a line of text above it, in letters that fit its width.
Mat captioned(const Mat& picture, const String& text)
{
    const int font = FONT_HERSHEY_SIMPLEX;
    const double largest = 0.75 * drawingScale(picture.size());
    const int width = getTextSize(text, font, 1, 1, nullptr).width;
    const double scale = std::min(largest, 0.94 * picture.cols / width);
    const int height = cvRound(48 * largest), thickness = std::max(1, cvRound(1.3 * scale));
    Mat result;
    copyMakeBorder(picture, result, height, 0, 0, 0, BORDER_CONSTANT, Scalar::all(255));
    putText(result, text, Point(cvRound(0.02 * picture.cols), height - cvRound(15 * largest)), font, scale,
            Scalar::all(0), thickness, LINE_AA);
    return result;
}

// What the program shows without images.
const struct
{
    const char *image1, *image2, *homography;
    const char* text;
} PAIRS[] = {
    {"rubberwhale1.png", "rubberwhale2.png", "",
     "1. AdaptiveQuadtreeORB wins: two frames of a video, with something to see everywhere.\n"
     "How to read it: cv::ORB's keypoints crowd where the contrast is highest, several on one corner;\n"
     "AdaptiveQuadtreeORB's cover the image. So more of them match at distinct places, and these\n"
     "places fill more of the image's cells."},
    {"box.png", "box_in_scene.png", "",
     "2. cv::ORB has more matches in all: a small box, and the same box among other things.\n"
     "How to read it: only the box is in both images. AdaptiveQuadtreeORB spreads its keypoints over\n"
     "the whole scene, so fewer of them lie on the box. If you look for a small object, see StrengthWeight\n"
     "in the tutorial."},
    {"graf1.png", "graf3.png", "H1to3p.xml",
     "3. AdaptiveQuadtreeORB wins: a painted wall from two sides, with a known homography between them.\n"
     "How to read it: AdaptiveQuadtreeORB has more correct matches, on more places of the wall. The error\n"
     "says by how many pixels the homography is off that is estimated from each detector's matches."}};

const char* const LEGEND =
    "Matches are mutual nearest neighbours. Consistent: within 3 pixels of the homography estimated\n"
    "from the detector's matches; correct: of the known one. Distinct: at least 4 pixels from every\n"
    "better one in both images. cv::ORB often has more in all, because it finds a strong corner on\n"
    "several levels and each of these counts. FAST threshold: cv::ORB's is fixed, AdaptiveQuadtreeORB's\n"
    "follows the contrast of the image.\n";

struct Input
{
    std::vector<Mat> images;  // one or two, grey
    Mat homography;           // empty where it is not known
    String folder, suffix;    // of the pictures, and of their names
    int nfeatures;
};

struct Result
{
    const char* name;
    Ptr<ORB> detector;
    std::vector<Features> features;  // of each image
    std::vector<DMatch> matches;     // distinct, and in agreement with the homography
    int agreeing, matched;           // matches in agreement with it, whether distinct or not; all matches
    double homographyError;          // in pixels; negative: there is none
};

// The file, or one of OpenCV's samples in OPENCV_SAMPLES_DATA_PATH.
Mat readImage(const String& name)
{
    const Mat image = imread(samples::findFile(name, false), IMREAD_GRAYSCALE);
    if (image.empty())
        CV_Error(Error::StsObjectNotFound, name + ": cannot be read as an image (OpenCV's: export "
                                                  "OPENCV_SAMPLES_DATA_PATH=$(scripts/demo.sh --images))");
    return image;
}

// The first matrix in the file, whatever its name.
Mat readHomography(const String& name)
{
    Mat homography;
    FileStorage(samples::findFile(name), FileStorage::READ).getFirstTopLevelNode() >> homography;
    if (homography.size() != Size(3, 3) || homography.channels() != 1)
        CV_Error(Error::StsParseError, name + ": has no 3x3 matrix");
    homography.convertTo(homography, CV_64F);
    return homography;
}

void writePicture(const String& path, const Mat& picture)
{
    if (!imwrite(path, picture, {IMWRITE_JPEG_QUALITY, 85}))
        CV_Error(Error::StsError, path + ": cannot be written; an existing folder is accepted");
    std::cout << "Picture: " << path << std::endl;
}

void detectAndMatch(const Input& input, Result& result)
{
    result.features.resize(input.images.size());
    for (size_t i = 0; i < input.images.size(); i++)
        result.detector->detectAndCompute(input.images[i], noArray(), result.features[i].keypoints,
                                          result.features[i].descriptors);
    if (input.images.size() < 2)
        return;
    const Features& first = result.features[0];
    const Features& second = result.features[1];
    const std::vector<DMatch> matches = matchFeatures(first, second, result.detector->defaultNorm());
    const Mat estimate = estimateHomography(first, second, matches);
    const Mat homography = input.homography.empty() ? estimate : input.homography;
    const std::vector<DMatch> right = agreeing(first, second, matches, homography);
    result.matches = distinct(first, second, right);
    result.agreeing = int(right.size());
    result.matched = int(matches.size());
    if (!estimate.empty())
        result.homographyError = cornerError(estimate, homography, input.images[0].size());
}

// The FAST threshold that a detector takes for an image: AdaptiveQuadtreeORB's is equation (7), limited.
int fastThreshold(const Ptr<ORB>& detector, const Mat& image)
{
    if (!detector.dynamicCast<aqorb::AdaptiveQuadtreeORB>())
        return detector->getFastThreshold();
    return std::min(std::max(cvRound(aqorb::adaptiveFastThreshold(image)), 1), 254);
}

String reference(const Input& input)
{
    return input.homography.empty() ? "consistent" : "correct";
}

String occupied(const std::vector<KeyPoint>& keypoints, Size size)
{
    return format("%.0f %%", 100 * aqorb::distributionOccupancy(keypoints, size, Size(16, 12)));
}

// A detector's part of the table: label and value of each row. What is said of each image is said in one row.
std::vector<std::pair<String, String>> column(const Input& input, const Result& result, double milliseconds,
                                              double orbMilliseconds)
{
    String counts, thresholds, uniformity, cells;
    for (size_t i = 0; i < input.images.size(); i++)
    {
        const std::vector<KeyPoint>& keypoints = result.features[i].keypoints;
        const Size size = input.images[i].size();
        const String comma = i > 0 ? ", " : "";
        counts += comma + format("%d", int(keypoints.size()));
        thresholds += comma + format("%d", fastThreshold(result.detector, input.images[i]));
        uniformity += comma + format("%.1f", aqorb::distributionUniformity(keypoints, size));
        cells += comma + occupied(keypoints, size);
    }
    std::vector<std::pair<String, String>> rows = {
        {input.images.size() == 2 ? "image 1, image 2" : "", result.name},
        {"keypoints", counts},
        {"FAST threshold", thresholds},
        {"uniformity (less is more uniform)", uniformity},
        {"occupied cells of a 16x12 grid", cells}};
    if (input.images.size() == 2)
    {
        std::vector<KeyPoint> matched;
        for (const DMatch& match : result.matches)
            matched.push_back(result.features[0].keypoints[match.queryIdx]);
        rows.push_back({"distinct " + reference(input) + " matches", format("%d", int(matched.size()))});
        rows.push_back({"  cells of image 1 that hold one", occupied(matched, input.images[0].size())});
        rows.push_back(
            {reference(input) + " matches in all", format("%d of %d", result.agreeing, result.matched)});
    }
    if (!input.homography.empty())
        rows.push_back({"error of the estimated homography",
                        result.homographyError < 0 ? "none" : format("%.2f px", result.homographyError)});
    rows.push_back({"time for image 1", format("%.2f ms", milliseconds)});
    rows.push_back({"  as a share of cv::ORB's", format("%.2f", milliseconds / orbMilliseconds)});
    return rows;
}

void printTable(const Input& input, const std::vector<Result>& results, const std::vector<double>& times)
{
    const auto orb = column(input, results[0], times[0], times[0]);
    const auto ours = column(input, results[1], times[1], times[0]);
    for (size_t i = 0; i < orb.size(); i++)
        std::cout << format("%-34s %13s %20s\n%s", orb[i].first.c_str(), orb[i].second.c_str(),
                            ours[i].second.c_str(), i > 0 ? "" : (String(69, '-') + "\n").c_str());
}

void savePictures(const Input& input, const std::vector<Result>& results)
{
    std::vector<Mat> keypoints, matches;
    for (const Result& result : results)
    {
        const int count = int(result.features[0].keypoints.size());
        keypoints.push_back(captioned(keypointPicture(input.images[0], result.features[0].keypoints),
                                      format("%s: %d keypoints", result.name, count)));
        if (input.images.size() == 2)
            matches.push_back(
                captioned(matchPicture(input.images[0], result.features[0].keypoints, input.images[1],
                                       result.features[1].keypoints, result.matches),
                          format("%s: %d distinct %s matches", result.name, int(result.matches.size()),
                                 reference(input).c_str())));
    }
    Mat picture;
    hconcat(keypoints, picture);
    writePicture(input.folder + "/aqorb_keypoints" + input.suffix + ".jpg", picture);
    if (matches.empty())
        return;
    vconcat(matches, picture);
    writePicture(input.folder + "/aqorb_matches" + input.suffix + ".jpg", picture);
}

void compare(const CommandLineParser& parser, const std::vector<String>& files, const String& homography,
             const String& suffix)
{
    Input input;
    for (const String& file : files)
        input.images.push_back(readImage(file));
    if (!homography.empty())
        input.homography = readHomography(homography);
    input.folder = parser.get<String>("out");
    input.suffix = suffix;
    input.nfeatures = parser.get<int>("nfeatures");

    std::vector<Result> results = {
        {"cv::ORB", ORB::create(input.nfeatures), {}, {}, 0, 0, -1},
        {"AdaptiveQuadtreeORB", aqorb::AdaptiveQuadtreeORB::create(input.nfeatures), {}, {}, 0, 0, -1}};
    for (Result& result : results)
        detectAndMatch(input, result);
    printTable(input, results, medianTimes({results[0].detector, results[1].detector}, input.images[0]));
    savePictures(input, results);
}

}  // namespace

int main(int argc, char** argv)
{
    CommandLineParser parser(argc, argv, KEYS);
    parser.about(ABOUT);
    std::vector<String> files;
    for (int i = 1; i < argc; i++)
        if (argv[i][0] != '-')
            files.push_back(argv[i]);
    if (parser.has("help"))
    {
        parser.printMessage();
        return 0;
    }

    int number = 0;
    try
    {
        if (files.empty())
            for (const auto& pair : PAIRS)
            {
                std::cout << pair.text << "\n" << pair.image1 << ", " << pair.image2 << "\n\n";
                compare(parser, {pair.image1, pair.image2}, pair.homography, format("%d", ++number));
                std::cout << std::endl;
            }
        else if (files.size() <= 2)
            compare(parser, files, parser.get<String>("homography"), "");
        else
            for (const String& file : files)
            {
                std::cout << file << std::endl;
                compare(parser, {file}, "", format("%d", ++number));
                std::cout << std::endl;
            }
    }
    catch (const cv::Exception& exception)
    {
        std::cerr << exception.err << std::endl;
        return 1;
    }
    std::cout << LEGEND << "Time: detectAndCompute, median of calls that take turns, " << getNumThreads()
              << " thread(s).\n";
    return 0;
}
