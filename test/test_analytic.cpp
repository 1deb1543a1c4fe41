// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "test_precomp.hpp"

// Drawn images of which the answer is known.

namespace opencv_test
{
namespace
{

void drawBlob(Mat& image, Point2d center, double sigma, double height)
{
    for (int y = 0; y < image.rows; y++)
    {
        for (int x = 0; x < image.cols; x++)
        {
            const double dx = x - center.x, dy = y - center.y;
            const double value = height * std::exp(-(dx * dx + dy * dy) / (2 * sigma * sigma));
            image.at<uchar>(y, x) = saturate_cast<uchar>(image.at<uchar>(y, x) + value);
        }
    }
}

// How far the only keypoint of a small round blob is off its centre, at worst.
double worstError(bool subPixel)
{
    double worst = 0;
    for (int i = 0; i < 36; i++)
    {
        const Point2d center(60 + (i % 6 - 2.5) / 6., 52 + (i / 6 - 2.5) / 6.);
        Mat image(110, 120, CV_8UC1, Scalar(20));
        drawBlob(image, center, 1, 200);  // The circle of FAST lies outside the blob.
        const Ptr<AdaptiveQuadtreeORB> detector = AdaptiveQuadtreeORB::create(1, 1.2f, 1);
        detector->setSubPixel(subPixel);
        KeyPoints keypoints;
        detector->detect(image, keypoints);
        EXPECT_EQ(1u, keypoints.size());
        if (!keypoints.empty())
            worst = std::max(worst, cv::norm(Point2d(keypoints[0].pt) - center));
    }
    return worst;
}

TEST(Aqorb_Analytic, position_of_a_blob_is_a_small_fraction_of_a_pixel_off)
{
    EXPECT_LT(worstError(true), 0.15);
    EXPECT_GT(worstError(false), 0.5);  // Whole pixels are up to half a diagonal off.
}

TEST(Aqorb_Analytic, a_blob_is_at_the_same_place_on_every_level)
{
    for (int octave = 0; octave < 8; octave++)
    {
        // a blob of the level's size; a map without pixel centres would be off by half a pixel of the level
        const double scale = std::pow(1.2, octave);
        const Point2d center(150.3, 140.8);
        Mat image(290, 300, CV_8UC1, Scalar(20));
        drawBlob(image, center, 1.2 * scale, 200);
        const Ptr<AdaptiveQuadtreeORB> detector = AdaptiveQuadtreeORB::create(200);
        detector->setOctaveSuppression(0);  // This keeps the same blob on several levels.
        KeyPoints keypoints;
        detector->detect(image, keypoints);
        double least = 1e9;
        for (const KeyPoint& keypoint : keypoints)
        {
            if (keypoint.octave == octave)
                least = std::min(least, cv::norm(Point2d(keypoint.pt) - center));
        }
        EXPECT_LT(least, 0.3 * scale) << "octave " << octave;
    }
}

TEST(Aqorb_Analytic, the_best_of_each_leaf_is_chosen)
{
    // The balanced selection: a level with 16 features has 4 x 4 leaves. Each holds dots of three brightnesses in random places;
    // neither the other dots nor the leaves with the brightest ones may crowd the others out.
    const int edge = 16, leaf = 30, side = 4 * leaf;
    RNG rng(12);
    for (int round = 0; round < 10; round++)
    {
        SCOPED_TRACE(round);
        Mat image(side + 2 * edge, side + 2 * edge, CV_8UC1, Scalar(0));
        std::vector<Point> best;
        for (int i = 0; i < 16; i++)
        {
            const Rect cell(edge + leaf * (i % 4), edge + leaf * (i / 4), leaf, leaf);
            const int strength = rng.uniform(60, 230), strongest = rng.uniform(0, 3);
            for (int j = 0; j < 3; j++)
            {
                // apart by 8 pixels or more, so that no dot lies on the circle of another
                const Point dot(cell.x + 4 + rng.uniform(0, 22), cell.y + 2 + 10 * j + rng.uniform(0, 3));
                image.at<uchar>(dot) = uchar(j == strongest ? strength : strength - 10 - j);
                if (j == strongest)
                    best.push_back(dot);
            }
        }
        const Ptr<AdaptiveQuadtreeORB> detector = AdaptiveQuadtreeORB::create(
            16, 1.2f, 1, edge, 0, 2, round % 2 ? ORB::FAST_SCORE : ORB::HARRIS_SCORE);
        detector->setSelectionType(AdaptiveQuadtreeORB::BALANCED_SELECTION);
        detector->setAdaptiveThreshold(false);
        KeyPoints keypoints;
        detector->detect(image, keypoints);
        ASSERT_EQ(16u, keypoints.size());
        // Keypoints of a level come in raster order.
        std::sort(best.begin(), best.end(),
                  [](const Point& a, const Point& b) { return a.y != b.y ? a.y < b.y : a.x < b.x; });
        std::vector<Point> found;
        for (const KeyPoint& keypoint : keypoints)
            found.push_back(Point(cvRound(keypoint.pt.x), cvRound(keypoint.pt.y)));
        EXPECT_EQ(best, found);
    }
}

TEST(Aqorb_Analytic, dots_that_are_alone_come_before_a_crowd)
{
    // The ranked selection: 16 features in 4 x 4 cells are a cell apart on average, and with radius .6 no dot of one
    // cell counts in another. In 15 cells a dot is alone and has rank 0. In the other one are nine brighter ones, of
    // which one has rank 0.
    const int edge = 16, cell = 90, side = 4 * cell;
    RNG rng(13);
    for (int round = 0; round < 10; round++)
    {
        SCOPED_TRACE(round);
        Mat image(side + 2 * edge, side + 2 * edge, CV_8UC1, Scalar(0));
        std::vector<Point> alone;
        const int crowded = rng.uniform(0, 16);
        Point crowd;
        for (int i = 0; i < 16; i++)
        {
            const Point center(edge + cell * (i % 4) + cell / 2 + rng.uniform(-5, 6),
                               edge + cell * (i / 4) + cell / 2 + rng.uniform(-5, 6));
            if (i != crowded)
            {
                image.at<uchar>(center) = uchar(rng.uniform(60, 200));
                alone.push_back(center);
                continue;
            }
            crowd = center;
            for (int j = 0; j < 9; j++)
                image.at<uchar>(center + Point(8 * (j % 3 - 1), 8 * (j / 3 - 1))) = uchar(255 - j);
        }
        const Ptr<AdaptiveQuadtreeORB> detector = AdaptiveQuadtreeORB::create(
            16, 1.2f, 1, edge, 0, 2, round % 2 ? ORB::FAST_SCORE : ORB::HARRIS_SCORE);
        detector->setAdaptiveThreshold(false);
        detector->setRankRadius(0.6);
        detector->setStrengthWeight(0);
        KeyPoints keypoints;
        detector->detect(image, keypoints);
        ASSERT_EQ(16u, keypoints.size());
        int inCrowd = 0;
        std::vector<Point> found;
        for (const KeyPoint& keypoint : keypoints)
        {
            const Point place(cvRound(keypoint.pt.x), cvRound(keypoint.pt.y));
            if (cv::norm(place - crowd) < 15)
                inCrowd++;
            else
                found.push_back(place);
        }
        EXPECT_EQ(1, inCrowd);
        const auto inRasterOrder = [](const Point& a, const Point& b)
        { return a.y != b.y ? a.y < b.y : a.x < b.x; };
        std::sort(alone.begin(), alone.end(), inRasterOrder);
        std::sort(found.begin(), found.end(), inRasterOrder);
        EXPECT_EQ(alone, found);
    }
}

//! Detects the keypoints of a blob's image, and returns by octave how many of them lie at the blob.
std::vector<int> octavesAtBlob(AdaptiveQuadtreeORB& detector, const Mat& image, Point2f blob)
{
    KeyPoints keypoints;
    detector.detect(image, keypoints);
    std::vector<int> count(detector.getNLevels());
    for (const KeyPoint& keypoint : keypoints)
        count[keypoint.octave] += cv::norm(keypoint.pt - blob) < 1;
    return count;
}

// The ranked selection.
TEST(Aqorb_Analytic, a_corner_is_not_kept_on_neighbouring_levels)
{
    Mat image(400, 400, CV_8UC1, Scalar(20));
    const Point2f blob(200, 200);
    drawBlob(image, blob, 2, 200);
    for (int i = 0; i < 49; i++)  // enough others for every level
    {
        if (i != 24)
            image.at<uchar>(50 + 50 * (i / 7), 50 + 50 * (i % 7)) = 250;
    }
    const Ptr<AdaptiveQuadtreeORB> detector = AdaptiveQuadtreeORB::create(60);
    for (double octaveSuppression : {0., 1.5})
    {
        detector->setOctaveSuppression(octaveSuppression);
        const std::vector<int> count = octavesAtBlob(*detector, image, blob);
        int onBoth = 0;
        for (size_t i = 1; i < count.size(); i++)
            onBoth += count[i] > 0 && count[i - 1] > 0;
        if (octaveSuppression > 0)
        {
            EXPECT_EQ(0, onBoth);
            EXPECT_GT(*std::max_element(count.begin(), count.end()), 0);
        }
        else
        {
            EXPECT_GT(onBoth, 0);
        }
    }
}

TEST(Aqorb_Analytic, a_corner_is_kept_once_instead_of_on_every_level)
{
    // The balanced selection, which looks at all levels.
    Mat image(300, 300, CV_8UC1, Scalar(20));
    drawBlob(image, Point2d(150, 150), 4, 200);
    const Ptr<AdaptiveQuadtreeORB> detector = AdaptiveQuadtreeORB::create(8);
    detector->setSelectionType(AdaptiveQuadtreeORB::BALANCED_SELECTION);
    KeyPoints once, often;
    detector->setOctaveSuppression(0);
    detector->detect(image, often);
    ASSERT_GT(often.size(), 2u);
    // Other corners exist beside it: then these, not the same one again, make up the number.
    for (int i = 0; i < 8; i++)
        image.at<uchar>(60 + 25 * i, 60 + (i % 3) * 9) = 250;
    detector->setOctaveSuppression(1.5);
    detector->detect(image, once);
    ASSERT_EQ(8u, once.size());
    int atBlob = 0;
    for (const KeyPoint& keypoint : once)
        atBlob += cv::norm(keypoint.pt - Point2f(150, 150)) < 4;
    EXPECT_EQ(1, atBlob);
}

}  // namespace
}  // namespace opencv_test
