// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "reference.hpp"

#include "keypoints.hpp"

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

TEST(Aqorb_Position, without_sub_pixel_is_that_of_orb)
{
    const PositionMap map = {Size(640, 480), Size(444, 333), 1.44f, 16, false};
    EXPECT_EQ(map(100, 200, 0.3, -0.3), Point2f(100 * 1.44f, 200 * 1.44f));
    EXPECT_EQ(map(0, 1), Point2f(0, 1.44f));
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

TEST(Aqorb_Position, equals_reference_and_finds_back_to_its_pixel)
{
    const float factors[] = {1.1f, 1.2f, 1.5f, 2.f, 2.7f};
    const double offsets[] = {-0.5, -0.13, 0, 0.4, 0.5};
    for (float factor : factors)
        for (int level = -2; level <= 5; level++)
        {
            const Size image(197, 153);
            const float scale = reference::levelScale(level, 0, factor);
            const Size size = reference::levelSize(image, scale);
            const int border = 5 + level;
            const PositionMap map = {image, size, scale, border, true};
            for (int x = border; x < size.width - border; x++)
            {
                const int y = std::min(x, size.height - 1);
                for (double d : offsets)
                {
                    const Point2f p = map(x, y, d, -d);
                    ASSERT_EQ(p, reference::position(x, y, Point2d(d, -d), image, size, scale, border, true));
                    // Compute and cv::ORB round it back to its pixel.
                    ASSERT_EQ(cvRound(p.x * (1.f / scale)), x) << factor << " " << level << " " << d;
                    ASSERT_EQ(cvRound(p.y * (1.f / scale)), y) << factor << " " << level << " " << d;
                }
            }
        }
}

// Positions of wide images are multiples of 1/64 of a pixel and more.
TEST(Aqorb_Position, finds_back_to_its_pixel_in_the_widest_images)
{
    const double offsets[] = {-0.5, -0.49, 0, 0.49, 0.5};
    const int border = 16;
    for (int width : {40000, 131072, 132000, 262144, 700001, (1 << 20) - 1})
    {
        for (int level = 0; level <= 5; level++)
        {
            const Size image(width, 100);
            const float scale = reference::levelScale(level, 0, 1.2f);
            const Size size = reference::levelSize(image, scale);
            const PositionMap map = {image, size, scale, border, true};
            for (int x = border; x < size.width - border; x += x < 100 || x > size.width - 400 ? 1 : 101)
            {
                for (double d : offsets)
                {
                    const float position = map(x, 50, d, 0).x;
                    ASSERT_EQ(x, cvRound(position * (1.f / scale))) << width << " " << level << " " << d;
                    ASSERT_GE(position, float(border)) << width << " " << level << " " << x;
                    ASSERT_LT(cvRound(position), width - border) << width << " " << level << " " << x;
                }
            }
        }
    }
}

TEST(Aqorb_Position, stays_inside_the_border)
{
    // Otherwise compute would drop the keypoint, as it does with all within edgeThreshold of the image's sides.
    const int border = 16;
    for (int width = 40; width < 120; width++)
        for (int level = 0; level < 6; level++)
        {
            const Size image(width, 100);
            const float scale = reference::levelScale(level, 0, 1.2f);
            const Size size = reference::levelSize(image, scale);
            const PositionMap map = {image, size, scale, border, true};
            for (int x = border; x < size.width - border; x++)
                for (int d = -1; d <= 1; d++)
                {
                    const float position = map(x, 50, d * 0.5, 0).x;
                    ASSERT_GE(position, float(border)) << width << " " << level << " " << x;
                    ASSERT_LT(cvRound(position), width - border) << width << " " << level << " " << x;
                }
        }
}

// They moved towards a border of the image that no position of the pixel reaches, by almost a pixel of the level.
TEST(Aqorb_Position, on_enlarged_levels_is_by_pixel_centres_at_the_sides_too)
{
    const Size image(197, 153);
    const int border = 16;
    for (float factor : {1.2f, 1.5f, 2.f})
        for (int level = -3; level < 0; level++)
        {
            const float scale = reference::levelScale(level, 0, factor);
            const Size size = reference::levelSize(image, scale);
            const PositionMap map = {image, size, scale, border, true};
            for (int x = border; x < size.width - border; x++)
                for (double d : {-0.2, 0., 0.2})
                {
                    const double exact = (x + d + 0.5) * image.width / size.width - 0.5;
                    if (std::abs(exact - border) < 1 || std::abs(exact - (image.width - border - 0.5)) < 1)
                        continue;  // there the border can be reached
                    const double nearest = std::max(std::min(exact, (x + 0.49) * scale), (x - 0.49) * scale);
                    ASSERT_NEAR(map(x, 50, d, 0).x, nearest, 1e-4) << factor << " " << level << " " << x;
                }
        }
}

// A pixel of an enlarged level is made of at most four pixels of the image, and its keypoint lies on one of them.
TEST(Aqorb_Position, a_usable_pixel_of_an_enlarged_level_has_a_usable_position)
{
    RNG rng(3);
    for (int i = 0; i < 60; i++)
    {
        const Size image(rng.uniform(30, 100), rng.uniform(30, 100));
        const Mat mask = makeNoise(image, i) > 60;
        const float scale = reference::levelScale(-rng.uniform(1, 3), 0, rng.uniform(1.05f, 2.f));
        const Size size = reference::levelSize(image, scale);
        const int border = rng.uniform(0, 30);
        const PositionMap map = {image, size, scale, border, true};
        Mat levelMask = reference::resizeMask(mask, size);
        const Mat before = levelMask.clone();
        maskPositions(mask, map, levelMask);
        const Rect region(border, border, size.width - 2 * border, size.height - 2 * border);
        if (region.width > 0 && region.height > 0)
        {
            EXPECT_TRUE(sameMat(levelMask(region) != 0, before(region) != 0)) << scale << size << border;
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

}  // namespace
}  // namespace opencv_test
