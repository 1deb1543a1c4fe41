// This file is part of the aqorb project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.

// Shows AdaptiveQuadtreeORB beside cv::ORB: where their keypoints lie and how well these match.

#include "evaluation.hpp"
#include "program.hpp"

#include <opencv2/aqorb.hpp>
#include <opencv2/core/utils/filesystem.hpp>
#include <opencv2/imgproc.hpp>

#include <cstdio>

using namespace cv;

namespace
{

const char* const ABOUT = "Compares cv::aqorb::AdaptiveQuadtreeORB with cv::ORB: prints a table and writes\n"
                          "the pictures aqorb_keypoints.jpg and, for two images, aqorb_matches.jpg.\n"
                          "More than two images are taken one by one (aqorb_keypoints1.jpg, ...).\n"
                          "Exit codes: 0 done, 1 bad arguments, 2 an input cannot be read, 3 a picture\n"
                          "cannot be written, 4 other.\n";

const char* const KEYS =
    "{help h usage ? |      | print this text }"
    "{homography     |      | XML, YAML or JSON file with the 3x3 homography from image1 "
    "to image2; without it the matches are counted that agree with an estimated one }"
    "{out            | .    | existing folder for the pictures }"
    "{nfeatures      | 1000 | number of keypoints to ask for, at least 1 }"
    "{@image1        |      | without images, OpenCV's samples graf1.png and graf3.png }"
    "{@image2        |      | image to match with the first }";

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

// The names of the images. CommandLineParser passes over options that it does not know and further images.
std::vector<String> checkArguments(int argc, char** argv)
{
    std::vector<String> images;
    for (int i = 1; i < argc; i++)
    {
        const String argument = argv[i], name = argument.substr(0, argument.find('='));
        if (argument[0] != '-')
            images.push_back(argument);
        else if (name != "--homography" && name != "--out" && name != "--nfeatures")
            throw Failure{1, argument + ": unknown option; see --help"};
    }
    return images;
}

// The path of a file or of one of OpenCV's samples.
String find(const String& name)
{
    const String path = samples::findFile(name, false, true);
    if (path.empty())
        throw Failure{2, name + ": no such file, nor a sample in OPENCV_SAMPLES_DATA_PATH"};
    return path;
}

// The first matrix in the file, whatever its name.
Mat readHomography(const String& name)
{
    Mat homography;
    try
    {
        const FileStorage file(find(name), FileStorage::READ);
        file.getFirstTopLevelNode() >> homography;
    }
    catch (const cv::Exception&)  // neither XML, YAML nor JSON, or no matrix
    {
    }
    if (homography.size() != Size(3, 3) || homography.channels() != 1)
        throw Failure{2, name + ": holds no 3x3 matrix"};
    homography.convertTo(homography, CV_64F);
    return homography;
}

Input readInput(const CommandLineParser& parser, const std::vector<String>& names, const String& suffix)
{
    Input input;
    input.suffix = suffix;
    input.nfeatures = featureCount(parser);
    input.folder = parser.get<String>("out");
    if (!utils::fs::isDirectory(input.folder))
        throw Failure{3, input.folder + ": no such folder"};
    const String homography = names.empty() ? "H1to3p.xml" : parser.get<String>("homography");
    if (!homography.empty() && names.size() != 2 && !names.empty())
        throw Failure{1, "--homography needs two images"};
    for (const String& name : names.empty() ? std::vector<String>{"graf1.png", "graf3.png"} : names)
        input.images.push_back(readGrayImage(find(name)));
    if (!homography.empty())
        input.homography = readHomography(homography);
    return input;
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

// A detector's part of the table: label and value of each row.
std::vector<std::pair<String, String>> column(const Input& input, const Result& result, double milliseconds,
                                              double orbMilliseconds)
{
    std::vector<std::pair<String, String>> rows = {{"", result.name}};
    for (size_t i = 0; i < input.images.size(); i++)
    {
        const std::vector<KeyPoint>& keypoints = result.features[i].keypoints;
        const Size size = input.images[i].size();
        const int iniT = fastThreshold(result.detector, input.images[i]);
        const double u = aqorb::distributionUniformity(keypoints, size);
        rows.push_back({format("image %d: keypoints", int(i + 1)), format("%d", int(keypoints.size()))});
        rows.push_back({"  FAST threshold (iniT)", format("%d", iniT)});
        rows.push_back({"  uniformity (less is more uniform)", format("%.1f", u)});
        rows.push_back({"  occupied cells of a 16x12 grid", occupied(keypoints, size)});
    }
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
        std::printf("%-36s %10s %20s\n", orb[i].first.c_str(), orb[i].second.c_str(), ours[i].second.c_str());
    std::printf("Time: detectAndCompute, median of calls that take turns, %d thread(s).\n", getNumThreads());
}

// The picture with a line of text above it.
Mat labelled(const Mat& picture, const String& text)
{
    Mat result;
    copyMakeBorder(picture, result, 36, 0, 0, 0, BORDER_CONSTANT, Scalar::all(255));
    putText(result, text, Point(10, 25), FONT_HERSHEY_SIMPLEX, 0.75, Scalar::all(0), 1, LINE_AA);
    return result;
}

Mat keypointPicture(const Input& input, const Result& result)
{
    Mat picture;
    const std::vector<KeyPoint>& keypoints = result.features[0].keypoints;
    drawKeypoints(input.images[0], keypoints, picture, Scalar(0, 255, 255));
    return labelled(picture, format("%s: %d keypoints", result.name, int(keypoints.size())));
}

Mat matchPicture(const Input& input, const Result& result)
{
    Mat picture;  // darker, so that the lines stand out
    drawMatches(input.images[0] * 0.6, result.features[0].keypoints, input.images[1] * 0.6,
                result.features[1].keypoints, result.matches, picture, Scalar(0, 255, 255), Scalar::all(-1),
                std::vector<char>(), DrawMatchesFlags::NOT_DRAW_SINGLE_POINTS);
    return labelled(picture, format("%s: %d distinct %s matches", result.name, int(result.matches.size()),
                                    reference(input).c_str()));
}

void save(const String& folder, const String& name, const Mat& picture)
{
    const String path = utils::fs::join(folder, name);
    if (!imwrite(path, picture, {IMWRITE_JPEG_QUALITY, 85}))
        throw Failure{3, path + ": cannot be written"};
    std::printf("Picture: %s\n", utils::fs::canonical(path).c_str());
}

void savePictures(const Input& input, const std::vector<Result>& results)
{
    Mat picture;
    hconcat(keypointPicture(input, results[0]), keypointPicture(input, results[1]), picture);
    save(input.folder, "aqorb_keypoints" + input.suffix + ".jpg", picture);
    if (input.images.size() < 2)
        return;
    vconcat(matchPicture(input, results[0]), matchPicture(input, results[1]), picture);
    save(input.folder, "aqorb_matches.jpg", picture);
}

void compare(const Input& input)
{
    std::vector<Result> results = {
        {"cv::ORB", ORB::create(input.nfeatures), {}, {}, -1},
        {"AdaptiveQuadtreeORB", aqorb::AdaptiveQuadtreeORB::create(input.nfeatures), {}, {}, -1}};
    for (Result& result : results)
        detectAndMatch(input, result);
    printTable(input, results, medianTimes({results[0].detector, results[1].detector}, input.images[0]));
    savePictures(input, results);
}

void run(int argc, char** argv)
{
    CommandLineParser parser(argc, argv, KEYS);
    parser.about(ABOUT);
    if (parser.has("help"))
        return parser.printMessage();
    const std::vector<String> names = checkArguments(argc, argv);
    if (names.size() <= 2)
        return compare(readInput(parser, names, ""));
    for (size_t i = 0; i < names.size(); i++)
    {
        std::printf("%s%s\n", i ? "\n" : "", names[i].c_str());
        compare(readInput(parser, {names[i]}, format("%d", int(i + 1))));
    }
}

}  // namespace

int main(int argc, char** argv)
{
    return runProgram("aqorb_demo", run, argc, argv);
}
