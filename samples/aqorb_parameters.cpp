// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// Draws how AdaptiveQuadtreeORB chooses and what each of its parameters does: the pictures of the tutorials.

#include "drawing.hpp"
#include "program.hpp"

#include <opencv2/aqorb.hpp>

#include <functional>
#include <set>

using namespace cv;

namespace
{

const Program PROGRAM = {
    "aqorb_parameters",
    "Draws how cv::aqorb::AdaptiveQuadtreeORB chooses and what each of its parameters does: the\n"
    "pictures of the tutorials. Without an image it takes leuvenA.jpg of OpenCV's samples.",
    "[IMAGE]",
    0,
    1,
    {{"out", ".", "existing folder for the pictures"}},
    "aqorb_parameters --out=pictures leuvenA.jpg"};

typedef Ptr<aqorb::AdaptiveQuadtreeORB> Detector;

// One setting of a parameter, and its part of the picture.
struct Panel
{
    String caption;
    std::function<void(const Detector&)> set;
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
        throw Failure{FAILED, "the image has no keypoints"};
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

// Draws one parameter, a panel a setting, and prints its numbers.
void draw(const String& path, const Mat& image, int nfeatures, const std::vector<Panel>& panels,
          const View& view = overview)
{
    std::vector<Mat> pictures;
    for (const Panel& panel : panels)
    {
        const Detector detector = aqorb::AdaptiveQuadtreeORB::create(nfeatures);
        panel.set(detector);
        std::vector<KeyPoint> keypoints;
        detector->detect(image, keypoints);
        const String numbers = format("%d keypoints, u %.0f, %.0f %% of a 16x12 grid", int(keypoints.size()),
                                      aqorb::distributionUniformity(keypoints, image.size()),
                                      100 * aqorb::distributionOccupancy(keypoints, image.size()));
        std::printf("%-28s %s\n", panel.caption.c_str(), numbers.c_str());
        pictures.push_back(labelled(view(image, keypoints), panel.caption, numbers));
    }
    Mat picture;
    hconcat(pictures, picture);
    writePicture(path, picture, 80);
}

void drawParameters(const Mat& image, const String& folder)
{
    const auto path = [&](const String& name) { return pathIn(folder, "aqorb_" + name + ".jpg"); };
    const auto none = [](const Detector&) {};

    draw(path("max_depth"), image, 500,
         {{"MaxDepth 0: by score alone", [](const Detector& d) { d->setMaxDepth(0); }},
          {"MaxDepth 2", [](const Detector& d) { d->setMaxDepth(2); }},
          {"MaxDepth -1", none}});
    draw(path("selection_type"), image, 500,
         {{"BALANCED_SELECTION",
           [](const Detector& d) { d->setSelectionType(aqorb::AdaptiveQuadtreeORB::BALANCED_SELECTION); }},
          {"RANKED_SELECTION", none}});
    draw(path("strength_weight"), image, 500,
         {{"StrengthWeight 0", [](const Detector& d) { d->setStrengthWeight(0); }},
          {"StrengthWeight 0.2", none},
          {"StrengthWeight 1", [](const Detector& d) { d->setStrengthWeight(1); }},
          {"StrengthWeight 1000", [](const Detector& d) { d->setStrengthWeight(1000); }}});
    draw(path("rank_radius"), image, 500,
         {{"RankRadius 0", [](const Detector& d) { d->setRankRadius(0); }},
          {"RankRadius 1", none},
          {"RankRadius 3", [](const Detector& d) { d->setRankRadius(3); }}});
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
    draw(path("min_threshold_ratio"), image, 500,
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
          {"OctaveSuppression -1: 0.6", none},
          {"OctaveSuppression 2", [](const Detector& d) { d->setOctaveSuppression(2); }}},
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
                circle(mesh, keypoint.pt, 2, ratio == 1 ? YELLOW : Scalar(60, 60, 255), FILLED);
        }
    }

    const int quota = 161, leaves = 64;  // leaves a side: 4^6 >= 16 * 161
    detector->setMaxFeatures(quota);
    detector->detect(image, keypoints);
    Mat tree = divided(image, border,
                       Size2d((image.cols - 2. * border) / leaves, (image.rows - 2. * border) / leaves));
    for (const KeyPoint& keypoint : keypoints)
        circle(tree, keypoint.pt, 4, YELLOW, FILLED);

    Mat picture;
    hconcat(labelled(mesh, "Corners at iniT (yellow) and, in cells without these, at minT (red)", ""),
            labelled(tree, "The 161 chosen of them; 4^6 leaves of the quadtree", ""), picture);
    resize(picture, picture, Size(), 0.7, 0.7, INTER_AREA);
    writePicture(pathIn(folder, "aqorb_stages.jpg"), picture, 80);
}

void run(const Arguments& arguments)
{
    const String folder = pathIn(arguments.text("out"), "");
    const Mat image = readImage(arguments.file(0, "leuvenA.jpg"), IMREAD_GRAYSCALE, 100);
    drawStages(image, folder);
    drawParameters(image, folder);
}

}  // namespace

int main(int argc, char** argv)
{
    return runProgram(PROGRAM, run, argc, argv);
}
