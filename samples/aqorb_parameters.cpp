// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// Draws how AdaptiveQuadtreeORB chooses and what each of its parameters does: the pictures of the tutorials.

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

#include <cstdlib>
#include <functional>
#include <iostream>
#include <set>

using namespace cv;

namespace
{

const char* const KEYS =
    "{help   |              | print this text }"
    "{out    | .            | existing folder for the pictures }"
    "{@image | leuvenA.jpg  | file, or one of OpenCV's samples in OPENCV_SAMPLES_DATA_PATH }";

typedef Ptr<aqorb::AdaptiveQuadtreeORB> Detector;

const Scalar YELLOW(0, 255, 255), RED(60, 60, 255);

void writePicture(const String& path, const Mat& picture)
{
    if (!imwrite(path, picture, {IMWRITE_JPEG_QUALITY, 80}))
    {
        std::cerr << path << ": cannot be written; does its folder exist?\n";
        std::exit(1);
    }
}

// One setting of a parameter, and its part of the picture.
struct Panel
{
    String caption;
    std::function<void(const Detector&)> set;  // empty: cv::ORB, for comparison
};

typedef std::function<Mat(const Mat& image, const std::vector<KeyPoint>& keypoints)> View;

// Keypoints as dots on the whole image, which show how they are distributed.
Mat overview(const Mat& image, const std::vector<KeyPoint>& keypoints)
{
    const float scale = 400.f / image.cols;
    Mat picture;
    resize(image, picture, Size(), scale, scale, INTER_AREA);
    cvtColor(picture, picture, COLOR_GRAY2BGR);
    for (const KeyPoint& keypoint : keypoints)
        circle(picture, keypoint.pt * scale, 1, YELLOW, FILLED);
    return picture;
}

// Keypoints as circles of a tenth of their patch with a cross at their position, on an enlarged part.
View closeUp(const Rect& part, int factor)
{
    return [=](const Mat& image, const std::vector<KeyPoint>& keypoints)
    {
        Mat picture;
        resize(image(part), picture, Size(), factor, factor, INTER_NEAREST);
        cvtColor(picture, picture, COLOR_GRAY2BGR);
        for (const KeyPoint& keypoint : keypoints)
        {
            // the centre of pixel 0 lies half a pixel off the corner of the picture
            const Point2f p = (keypoint.pt - Point2f(part.tl()) + Point2f(0.5f, 0.5f)) * factor;
            circle(picture, p, cvRound(keypoint.size * factor / 20), YELLOW, 1, LINE_AA);
            drawMarker(picture, p, YELLOW, MARKER_CROSS, 7);
        }
        return picture;
    };
}

// The part of the image around its best keypoint.
Rect partAroundBest(const Mat& image, Size size)
{
    std::vector<KeyPoint> keypoints;
    aqorb::AdaptiveQuadtreeORB::create()->detect(image, keypoints);
    if (keypoints.empty())
        CV_Error(Error::StsError, "the image has no keypoints");
    const auto best =
        std::max_element(keypoints.begin(), keypoints.end(),
                         [](const KeyPoint& a, const KeyPoint& b) { return a.response < b.response; });
    const Point centre = best->pt;
    return Rect(std::min(std::max(centre.x - size.width / 2, 0), image.cols - size.width),
                std::min(std::max(centre.y - size.height / 2, 0), image.rows - size.height), size.width,
                size.height);
}

Mat labelled(const Mat& picture, const String& first, const String& second)
{
    Mat result;
    copyMakeBorder(picture, result, 42, 0, 0, 6, BORDER_CONSTANT, Scalar::all(255));
    putText(result, first, Point(4, 17), FONT_HERSHEY_SIMPLEX, 0.5, Scalar::all(0), 1, LINE_AA);
    putText(result, second, Point(4, 35), FONT_HERSHEY_SIMPLEX, 0.4, Scalar::all(90), 1, LINE_AA);
    return result;
}

// Pictures of one size side by side, in rows of so many.
Mat arranged(const std::vector<Mat>& pictures, int columns)
{
    std::vector<Mat> rows;
    for (size_t i = 0; i + columns <= pictures.size(); i += columns)
    {
        rows.push_back(Mat());
        hconcat(&pictures[i], columns, rows.back());
    }
    Mat picture;
    vconcat(rows, picture);
    return picture;
}

// Draws one parameter, a panel a setting, and prints its numbers.
void draw(const String& path, const Mat& image, int nfeatures, const std::vector<Panel>& panels,
          const View& view = overview, int columns = 0)
{
    std::vector<Mat> pictures;
    for (const Panel& panel : panels)
    {
        Ptr<ORB> orb = ORB::create(nfeatures);
        if (panel.set)
        {
            const Detector detector = aqorb::AdaptiveQuadtreeORB::create(nfeatures);
            panel.set(detector);
            orb = detector;
        }
        std::vector<KeyPoint> keypoints;
        orb->detect(image, keypoints);
        const String numbers = format("%d keypoints, u %.0f, %.0f %% of a 16x12 grid", int(keypoints.size()),
                                      aqorb::distributionUniformity(keypoints, image.size()),
                                      100 * aqorb::distributionOccupancy(keypoints, image.size()));
        std::printf("%-28s %s\n", panel.caption.c_str(), numbers.c_str());
        pictures.push_back(labelled(view(image, keypoints), panel.caption, numbers));
    }
    writePicture(path, arranged(pictures, columns ? columns : int(pictures.size())));
}

void drawParameters(const Mat& image, const String& folder)
{
    const auto path = [&](const String& name) { return folder + "/aqorb_" + name + ".jpg"; };
    const auto none = [](const Detector&) {};

    draw(path("max_depth"), image, 500,
         {{"MaxDepth 0: by response alone", [](const Detector& d) { d->setMaxDepth(0); }},
          {"MaxDepth 2", [](const Detector& d) { d->setMaxDepth(2); }},
          {"MaxDepth -1", none}});
    draw(path("selection_type"), image, 500,
         {{"BALANCED_SELECTION",
           [](const Detector& d) { d->setSelectionType(aqorb::AdaptiveQuadtreeORB::BALANCED_SELECTION); }},
          {"RANKED_SELECTION", none}});
    draw(path("strength_weight"), image, 500,
         {{"StrengthWeight 0: most even", [](const Detector& d) { d->setStrengthWeight(0); }},
          {"StrengthWeight 0.05", none},
          {"StrengthWeight 1", [](const Detector& d) { d->setStrengthWeight(1); }},
          {"StrengthWeight 1000: strongest", [](const Detector& d) { d->setStrengthWeight(1000); }},
          {"OctaveSuppression 0, MaxDepth 0",
           [](const Detector& d) { d->setMaxDepth(0), d->setOctaveSuppression(0); }},
          {"cv::ORB, for comparison", nullptr}},
         overview, 3);
    draw(path("rank_radius"), image, 500,
         {{"RankRadius 0", [](const Detector& d) { d->setRankRadius(0); }},
          {"RankRadius 1", [](const Detector& d) { d->setRankRadius(1); }},
          {"RankRadius 2.25", none}});
    const Mat dark = image * 0.1;
    draw(path("adaptive_threshold"), dark, 500,
         {{"AdaptiveThreshold false", [](const Detector& d) { d->setAdaptiveThreshold(false); }},
          {"AdaptiveThreshold true", none}},
         [&](const Mat&, const std::vector<KeyPoint>& keypoints) { return overview(image, keypoints); });
    draw(
        path("fast_threshold"), image, 20000,
        {{"FastThreshold 40", [](const Detector& d) { d->setFastThreshold(40), d->setMinThresholdRatio(1); }},
         {"FastThreshold 20", [](const Detector& d) { d->setMinThresholdRatio(1); }},
         {"FastThreshold 10",
          [](const Detector& d) { d->setFastThreshold(10), d->setMinThresholdRatio(1); }}});
    draw(path("min_threshold_ratio"), image, 2000,
         {{"MinThresholdRatio 1: off", [](const Detector& d) { d->setMinThresholdRatio(1); }},
          {"MinThresholdRatio 2", [](const Detector& d) { d->setMinThresholdRatio(2); }},
          {"MinThresholdRatio 4", none}});
    draw(path("cell_size"), image, 500,
         {{"CellSize 140", [](const Detector& d) { d->setCellSize(140); }},
          {"CellSize 35", none},
          {"CellSize 12", [](const Detector& d) { d->setCellSize(12); }}});
    draw(path("edge_threshold"), image, 500,
         {{"EdgeThreshold 31, as cv::ORB", [](const Detector& d) { d->setEdgeThreshold(31); }},
          {"EdgeThreshold 16", none}});
    draw(path("octave_suppression"), image, 2000,
         {{"OctaveSuppression 0: off", [](const Detector& d) { d->setOctaveSuppression(0); }},
          {"OctaveSuppression 0.5", [](const Detector& d) { d->setOctaveSuppression(0.5); }},
          {"OctaveSuppression -1: 2", none}},
         closeUp(partAroundBest(image, Size(100, 66)), 4));
    draw(path("sub_pixel"), image, 2000,
         {{"SubPixel false", [](const Detector& d) { d->setSubPixel(false); }}, {"SubPixel true", none}},
         closeUp(partAroundBest(image, Size(33, 22)), 12));
}

// An image and the lines that divide its inside, all but a border, into cells of the given size.
Mat divided(const Mat& image, double border, Size2d cell)
{
    Mat picture;
    cvtColor(image, picture, COLOR_GRAY2BGR);
    const Point2d low(border, border), high(image.cols - border, image.rows - border);
    const Scalar colour(200, 160, 60);
    for (int i = 0; low.x + i * cell.width < high.x + 0.5; i++)
        line(picture, Point2d(low.x + i * cell.width, low.y), Point2d(low.x + i * cell.width, high.y),
             colour);
    for (int i = 0; low.y + i * cell.height < high.y + 0.5; i++)
        line(picture, Point2d(low.x, low.y + i * cell.height), Point2d(high.x, low.y + i * cell.height),
             colour);
    return picture;
}

// The mesh and the quadtree of one level, with as many features as the first of 8 levels gets of 500.
void drawStages(const Mat& image, const String& folder)
{
    const Detector detector = aqorb::AdaptiveQuadtreeORB::create(100000, 1.2f, 1);
    const int border = detector->getEdgeThreshold(), cell = detector->getCellSize();
    detector->setSubPixel(false);
    Mat mesh = divided(image, border, Size2d(cell, cell));
    std::set<std::pair<int, int>> full;  // cells with a corner at iniT
    std::vector<KeyPoint> keypoints;
    for (double ratio : {1., 4.})
    {
        detector->setMinThresholdRatio(ratio);
        detector->detect(image, keypoints);
        for (const KeyPoint& keypoint : keypoints)
        {
            const std::pair<int, int> in(int(keypoint.pt.x - border) / cell,
                                         int(keypoint.pt.y - border) / cell);
            if (ratio == 1)
                full.insert(in);
            if (ratio == 1 || !full.count(in))
                circle(mesh, keypoint.pt, 2, ratio == 1 ? YELLOW : RED, FILLED);
        }
    }

    const int quota = 141, leaves = 64;  // leaves a side: 4^6 >= 9 * 141
    detector->setMaxFeatures(quota);
    detector->detect(image, keypoints);
    Mat tree = divided(image, border,
                       Size2d((image.cols - 2. * border) / leaves, (image.rows - 2. * border) / leaves));
    for (const KeyPoint& keypoint : keypoints)
        circle(tree, keypoint.pt, 4, YELLOW, FILLED);
    // The disc of RankRadius around the corner that is nearest to the middle.
    const Point2f middle(float(image.cols) / 2, float(image.rows) / 2);
    const auto nearest = std::min_element(keypoints.begin(), keypoints.end(),
                                          [&](const KeyPoint& a, const KeyPoint& b)
                                          { return norm(a.pt - middle) < norm(b.pt - middle); });
    const double area = (image.cols - 2. * border) * (image.rows - 2. * border);
    if (nearest != keypoints.end())
        circle(tree, nearest->pt, cvRound(detector->getRankRadius() * std::sqrt(area / quota)), RED, 2,
               LINE_AA);

    Mat picture;
    hconcat(labelled(mesh, "Corners at iniT (yellow) and, in cells without these, at minT (red)", ""),
            labelled(tree, "The 141 chosen, 4^6 leaves, and the disc in which one is ranked (red)", ""),
            picture);
    resize(picture, picture, Size(), 0.7, 0.7, INTER_AREA);
    writePicture(folder + "/aqorb_stages.jpg", picture);
}

// What a camera sees of the image: its middle, turned by so many degrees. The frame lies inside of the image.
struct TurnedView
{
    TurnedView(const Mat& image, double degrees)
    {
        const int diagonal = std::min(image.cols, image.rows);
        const Size size(diagonal * 4 / 5, diagonal * 3 / 5);
        const Point2f centre(float(image.cols - 1) / 2, float(image.rows - 1) / 2);
        fromImage = getRotationMatrix2D(centre, degrees, 1);
        fromImage.at<double>(0, 2) -= (image.cols - size.width) / 2;
        fromImage.at<double>(1, 2) -= (image.rows - size.height) / 2;
        warpAffine(image, frame, fromImage, size, INTER_LINEAR, BORDER_REFLECT_101);
    }

    Mat frame, fromImage;  // the frame, and where points of the image are in it
};

// Features of a view.
struct Features
{
    Features(const Ptr<ORB>& detector, const TurnedView& view)
    {
        detector->detectAndCompute(view.frame, noArray(), keypoints, descriptors);
    }

    std::vector<KeyPoint> keypoints;
    Mat descriptors;
};

// Where the keypoints of a view are in another one.
std::vector<Point2f> carried(const std::vector<KeyPoint>& keypoints, const TurnedView& from,
                             const TurnedView& to)
{
    std::vector<Point2f> points;
    KeyPoint::convert(keypoints, points);
    if (points.empty())
        return points;
    Mat toImage;
    invertAffineTransform(from.fromImage, toImage);
    transform(points, points, toImage);
    transform(points, points, to.fromImage);
    return points;
}

// Which features of the second set are matched with one of the first within 3 pixels of the right place.
std::vector<bool> foundAgain(const Features& first, const Features& second,
                             const std::vector<Point2f>& rightPlaces)
{
    std::vector<bool> found(second.keypoints.size(), false);
    std::vector<DMatch> matches;
    if (!first.keypoints.empty() && !second.keypoints.empty())
        aqorb::HammingMatcher(NORM_HAMMING, true).match(second.descriptors, first.descriptors, matches);
    for (const DMatch& match : matches)
        found[match.queryIdx] = norm(first.keypoints[match.trainIdx].pt - rightPlaces[match.queryIdx]) <= 3;
    return found;
}

// The number of places, at least 4 pixels from each other, of the keypoints that were found again.
int countPlaces(const std::vector<KeyPoint>& keypoints, const std::vector<bool>& found)
{
    std::vector<Point2f> places;
    for (size_t i = 0; i < keypoints.size(); i++)
    {
        const Point2f p = keypoints[i].pt;
        if (found[i] &&
            std::none_of(places.begin(), places.end(), [&](const Point2f& q) { return norm(p - q) < 4; }))
            places.push_back(p);
    }
    return int(places.size());
}

// Which keypoints are found again when the camera turns.
void drawTurn(const Mat& image, const String& folder)
{
    const int nfeatures = 300;
    const Detector ranked = aqorb::AdaptiveQuadtreeORB::create(nfeatures);
    const Detector balanced = aqorb::AdaptiveQuadtreeORB::create(nfeatures);
    balanced->setSelectionType(aqorb::AdaptiveQuadtreeORB::BALANCED_SELECTION);
    const std::vector<std::pair<String, Ptr<ORB>>> detectors = {
        {"cv::ORB", ORB::create(nfeatures)}, {"BALANCED_SELECTION", balanced}, {"RANKED_SELECTION", ranked}};

    const TurnedView upright(image, 0);
    const int SHOWN = 45, STEP = 30;  // degrees
    Mat first;
    cvtColor(upright.frame, first, COLOR_GRAY2BGR);
    std::vector<Mat> pictures = {labelled(first, "Before the turn", "")};
    for (const auto& detector : detectors)
    {
        const Features before(detector.second, upright);
        int placesHere = 0;
        double sum = 0;
        Mat picture;
        for (int degrees = SHOWN - STEP; degrees < 360; degrees += STEP)
        {
            const TurnedView turned(image, degrees);
            const Features after(detector.second, turned);
            const std::vector<Point2f> rightPlaces = carried(after.keypoints, turned, upright);
            const std::vector<bool> found = foundAgain(before, after, rightPlaces);
            const int places = countPlaces(after.keypoints, found);
            sum += places;
            if (degrees != SHOWN)
                continue;
            placesHere = places;
            cvtColor(turned.frame, picture, COLOR_GRAY2BGR);
            const Rect2f frame(Point2f(0, 0), Size2f(upright.frame.size()));
            for (size_t i = 0; i < after.keypoints.size(); i++)
            {
                if (found[i])
                    circle(picture, after.keypoints[i].pt, 4, YELLOW, FILLED, LINE_AA);
                else if (frame.contains(rightPlaces[i]))
                    circle(picture, after.keypoints[i].pt, 4, RED, 1, LINE_AA);
            }
        }
        const String numbers = format("found again at %d places; on average of %d angles at %.0f", placesHere,
                                      360 / STEP, sum / (360 / STEP));
        std::printf("%-28s %s\n", detector.first.c_str(), numbers.c_str());
        pictures.push_back(labelled(picture, detector.first, numbers));
    }
    writePicture(folder + "/aqorb_turn.jpg", arranged(pictures, 2));
}

}  // namespace

int main(int argc, char** argv)
{
    CommandLineParser parser(argc, argv, KEYS);
    parser.about(
        "Draws how cv::aqorb::AdaptiveQuadtreeORB chooses and what each of its parameters does: the\n"
        "pictures of the tutorials.");
    if (parser.has("help"))
    {
        parser.printMessage();
        return 0;
    }
    const String file = parser.get<String>("@image"), folder = parser.get<String>("out");
    const Mat image = imread(samples::findFile(file, false), IMREAD_GRAYSCALE);
    if (image.empty())
    {
        std::cerr << file
                  << ": cannot be read as an image (OpenCV's: export "
                     "OPENCV_SAMPLES_DATA_PATH=$(scripts/demo.sh --images))\n";
        return 1;
    }
    drawStages(image, folder);
    drawTurn(image, folder);
    drawParameters(image, folder);
    return 0;
}
