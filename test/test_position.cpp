// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "reference.hpp"

#include "detector/keypoints.hpp"

namespace opencv_test
{
namespace
{

using namespace aqorb;

TEST(Aqorb_Position, offset_equals_reference_at_every_pixel)
{
    const Size sizes[] = {Size(67, 45), Size(30, 9), Size(8, 8), Size(2, 3)};
    for (const Size& size : sizes)
    {
        const Mat noise = makeNoise(size);
        const Mat images[] = {noise, noise > 200, makeScene(size)};
        for (const Mat& image : images)
            for (int y = 0; y < size.height; y++)
                for (int x = 0; x < size.width; x++)
                {
                    const Point2d offset = subPixelOffset(image, x, y);
                    ASSERT_EQ(offset, reference::subPixelOffset(image, x, y)) << x << " " << y;
                    ASSERT_LE(std::abs(offset.x), 0.5);
                    ASSERT_LE(std::abs(offset.y), 0.5);
                    WithoutOptimization baseline;
                    ASSERT_EQ(subPixelOffset(image, x, y), offset) << x << " " << y;
                }
    }
}

TEST(Aqorb_Position, is_by_pixel_centres)
{
    // Half the size: pixel (20, 30) covers the pixels (40..41, 60..61).
    const PositionMap half = {Size(200, 160), Size(100, 80), 2.f, 3, true};
    EXPECT_EQ(half(20, 30), Point2f(40.5f, 60.5f));
    EXPECT_EQ(half(20, 30, 0.2, -0.2), Point2f(40.9f, 60.1f));
    // An offset never goes so far that scaling back would round to another pixel.
    EXPECT_EQ(half(20, 30, 0.5, -0.5), Point2f(40.98f, 59.5f));
    EXPECT_EQ(half(20, 30, -0.5, 0.5), Point2f(39.5f, 60.98f));
    const PositionMap same = {Size(200, 160), Size(200, 160), 1.f, 3, true};
    EXPECT_EQ(same(20, 30), Point2f(20, 30));
    EXPECT_EQ(same(20, 30, 0.5, -0.5), Point2f(20.49f, 29.51f));
}

// Positions of wide images are multiples of 1/64 of a pixel and more. Inside the border, because compute drops all
// keypoints within edgeThreshold of the image's sides.
TEST(Aqorb_Position, equals_reference_finds_back_to_its_pixel_and_stays_inside_the_border)
{
    const int border = 16;
    std::vector<int> widths = {153, 197, 40000, 131072, 132000, 262144, 700001, (1 << 20) - 1};
    for (int width = 40; width < 120; width++)
        widths.push_back(width);
    for (int width : widths)
        for (float factor : {1.1f, 1.2f, 1.5f, 2.f, 2.7f})
            for (int level = width < 200 ? -2 : 0; level <= 5; level++)
            {
                SCOPED_TRACE(format("width %d, factor %g, level %d", width, factor, level));
                const Size image(width, width);
                const float scale = reference::levelScale(level, 0, factor);
                const Size size = reference::levelSize(image, scale);
                const PositionMap map = {image, size, scale, border, true};
                const int end = size.width - border;
                for (int x = border; x < end; x += x < 100 || x > end - 400 ? 1 : 101)
                    for (double d : {-0.5, -0.49, -0.13, 0., 0.4, 0.49, 0.5})
                    {
                        const Point2f p = map(x, x, d, -d);
                        ASSERT_EQ(
                            p, reference::position(x, x, Point2d(d, -d), image, size, scale, border, true));
                        // Compute and cv::ORB round it back to its pixel.
                        ASSERT_EQ(x, cvRound(p.x * (1.f / scale))) << d;
                        ASSERT_EQ(x, cvRound(p.y * (1.f / scale))) << d;
                        if (level < 0)
                            continue;
                        ASSERT_GE(std::min(p.x, p.y), float(border)) << x;
                        ASSERT_LT(cvRound(std::max(p.x, p.y)), width - border) << x;
                    }
            }
}

TEST(Aqorb_Position, a_masked_pixel_has_no_usable_position)
{
    const Size image(90, 70);
    const Mat mask = makeNoise(image) > 60;
    for (int level = -1; level <= 3; level++)
        for (int subPixel = 0; subPixel <= 1; subPixel++)
        {
            SCOPED_TRACE(format("level %d, sub-pixel %d", level, subPixel));
            const float scale = reference::levelScale(level, 0, 1.3f);
            const Size size = reference::levelSize(image, scale);
            const PositionMap map = {image, size, scale, 3, subPixel != 0};
            Mat levelMask = makeNoise(size, level + 2) > 60;
            const Mat before = levelMask.clone();
            maskPositions(mask, map, levelMask);
            for (int y = 3; y < size.height - 3; y++)
                for (int x = 3; x < size.width - 3; x++)
                {
                    Point2f expected, found;
                    const bool hasPosition =
                        reference::usablePosition(mask, x, y, size, scale, 3, subPixel != 0, expected);
                    ASSERT_EQ(hasPosition, usablePosition(mask, map, x, y, found)) << x << " " << y;
                    ASSERT_EQ(expected, found) << x << " " << y;
                    const bool use = before.at<uchar>(y, x) && hasPosition;
                    ASSERT_EQ(levelMask.at<uchar>(y, x) != 0, use) << x << " " << y;
                }
        }
}

void drawBlob(Mat& image, Point2d center, double sigma, double height)
{
    for (int y = 0; y < image.rows; y++)
        for (int x = 0; x < image.cols; x++)
        {
            const double dx = x - center.x, dy = y - center.y;
            const double value = height * std::exp(-(dx * dx + dy * dy) / (2 * sigma * sigma));
            image.at<uchar>(y, x) = saturate_cast<uchar>(image.at<uchar>(y, x) + value);
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

TEST(Aqorb_Position, of_a_blob_is_a_small_fraction_of_a_pixel_off)
{
    EXPECT_LT(worstError(true), 0.15);
    EXPECT_GT(worstError(false), 0.5);  // Whole pixels are up to half a diagonal off.
}

TEST(Aqorb_Position, of_a_blob_is_at_the_same_place_on_every_level)
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
        double nearest = 1e9;
        for (const KeyPoint& keypoint : keypoints)
        {
            if (keypoint.octave == octave)
                nearest = std::min(nearest, cv::norm(Point2d(keypoint.pt) - center));
        }
        EXPECT_LT(nearest, 0.3 * scale) << "octave " << octave;
    }
}

}  // namespace
}  // namespace opencv_test
