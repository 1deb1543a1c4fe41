// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// Shows AdaptiveQuadtreeORB beside cv::ORB: where their keypoints lie and how well these match.

#include "drawing.hpp"
#include "evaluation.hpp"
#include "program.hpp"

#include <opencv2/aqorb.hpp>

using namespace cv;

namespace
{

const Program PROGRAM = {
    "aqorb_demo",
    "Compares cv::aqorb::AdaptiveQuadtreeORB with cv::ORB: prints a table and writes the pictures\n"
    "aqorb_keypoints.jpg and, for two images, aqorb_matches.jpg. More than two images are taken one\n"
    "by one (aqorb_keypoints1.jpg, ...). Without images it takes three pairs of OpenCV's samples: one\n"
    "where all of the scene is in both images, one with a small object, and one from two sides.",
    "[IMAGE1 [IMAGE2]] or IMAGE IMAGE IMAGE ...",
    0,
    100000,
    {{"homography", "",
      "XML, YAML or JSON file with the 3x3 homography from image 1 to\n"
      "                       image 2; without it those matches are counted that agree with\n"
      "                       the homography estimated from them"},
     {"nfeatures", "1000", "number of keypoints to ask for"},
     {"out", ".", "existing folder for the pictures"}},
    "aqorb_demo --nfeatures=500 --out=pictures photograph1.jpg photograph2.jpg"};

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
     "2. cv::ORB has more matches: a small box, and the same box among other things.\n"
     "How to read it: only the box is in both images. AdaptiveQuadtreeORB spreads its keypoints over\n"
     "the whole scene, so fewer of them lie on the box, and fewer match. The matches cover as much of it.\n"
     "If you look for a small object, see StrengthWeight in the tutorial."},
    {"graf1.png", "graf3.png", "H1to3p.xml",
     "3. AdaptiveQuadtreeORB wins: a painted wall from two sides, with a known homography between them.\n"
     "How to read it: AdaptiveQuadtreeORB has more correct matches, on more places of the wall. The error\n"
     "says by how many pixels the homography is off that is estimated from each detector's matches."}};

const char* const LEGEND =
    "Distinct: matches at least 4 pixels from each other. Consistent: within 3 pixels of the\n"
    "homography estimated from the detector's matches; correct: of the known one.\n";

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
    double homographyError;          // in pixels; negative: there is none
};

// The first matrix in the file, whatever its name.
Mat readHomography(const String& name)
{
    Mat homography;
    const String path = findFile(name);
    try
    {
        const FileStorage file(path, FileStorage::READ);
        file.getFirstTopLevelNode() >> homography;
    }
    catch (const cv::Exception&)  // neither XML, YAML nor JSON, or no matrix
    {
    }
    if (homography.size() != Size(3, 3) || homography.channels() != 1)
        throw Failure{FAILED,
                      "--homography=" + name + ": an XML, YAML or JSON file with a 3x3 matrix is accepted"};
    homography.convertTo(homography, CV_64F);
    return homography;
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
    result.matches = distinctCorrect(first, second, matches, homography);
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
        {"FAST threshold (iniT)", thresholds},
        {"uniformity (less is more uniform)", uniformity},
        {"occupied cells of a 16x12 grid", cells}};
    if (input.images.size() == 2)
    {
        std::vector<KeyPoint> matched;
        for (const DMatch& match : result.matches)
            matched.push_back(result.features[0].keypoints[match.queryIdx]);
        rows.push_back({"distinct " + reference(input) + " matches", format("%d", int(matched.size()))});
        rows.push_back({"  cells of image 1 that hold one", occupied(matched, input.images[0].size())});
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
        std::printf("%-34s %13s %20s\n%s", orb[i].first.c_str(), orb[i].second.c_str(),
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
    writePicture(pathIn(input.folder, "aqorb_keypoints" + input.suffix + ".jpg"), picture);
    if (matches.empty())
        return;
    vconcat(matches, picture);
    writePicture(pathIn(input.folder, "aqorb_matches" + input.suffix + ".jpg"), picture);
}

void compare(const Arguments& arguments, const std::vector<String>& files, const String& homography,
             const String& suffix)
{
    Input input;
    for (const String& file : files)
        input.images.push_back(readImage(file));
    if (!homography.empty())
        input.homography = readHomography(homography);
    input.folder = arguments.text("out");
    input.suffix = suffix;
    input.nfeatures = arguments.featureCount();

    std::vector<Result> results = {
        {"cv::ORB", ORB::create(input.nfeatures), {}, {}, -1},
        {"AdaptiveQuadtreeORB", aqorb::AdaptiveQuadtreeORB::create(input.nfeatures), {}, {}, -1}};
    for (Result& result : results)
        detectAndMatch(input, result);
    printTable(input, results, medianTimes({results[0].detector, results[1].detector}, input.images[0]));
    savePictures(input, results);
}

void run(const Arguments& arguments)
{
    arguments.featureCount();
    pathIn(arguments.text("out"), "");
    const std::vector<String>& files = arguments.files;
    const String homography = arguments.text("homography");
    if (!homography.empty() && files.size() != 2)
        throw Failure{BAD_ARGUMENTS, "--homography=" + homography + ": is accepted with two images"};

    int number = 0;
    if (files.empty())
        for (const auto& pair : PAIRS)
        {
            std::printf("%s\n%s, %s\n\n", pair.text, pair.image1, pair.image2);
            compare(arguments, {pair.image1, pair.image2}, pair.homography, format("%d", ++number));
            std::printf("\n");
        }
    else if (files.size() <= 2)
        compare(arguments, files, homography, "");
    else
        for (const String& file : files)
        {
            std::printf("%s\n", file.c_str());
            compare(arguments, {file}, "", format("%d", ++number));
            std::printf("\n");
        }
    std::printf("%s", LEGEND);
    std::printf("Time: detectAndCompute, median of calls that take turns, %d thread(s).\n", getNumThreads());
}

}  // namespace

int main(int argc, char** argv)
{
    return runProgram(PROGRAM, run, argc, argv);
}
