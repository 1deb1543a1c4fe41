// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "reference.hpp"

#include "fast.hpp"

#include <iterator>

namespace opencv_test
{
namespace
{

using namespace aqorb;

// Appends the corners of score >= threshold whose centres lie in the region, in raster order.
void detectCorners(const Mat& image, const Rect& region, int threshold, std::vector<Corner>& corners)
{
    const Rect scanned = fastRegion(image.size(), region);
    if (scanned.empty())
        return;
    Level level;
    level.image = image;
    const Thresholds thresholds = {threshold, threshold};
    FastScanner scanner;
    scanner.begin(level, scanned, thresholds, scanned.height);
    scanner.scan(scanned.br().y, std::vector<Range>());
    scanner.append(false, corners);
}

int cornerScore(const Mat& image, int x, int y)
{
    int scores[3][3];
    cornerScores3x3(image, x, y, scores);
    return scores[1][1];
}

std::vector<Corner> cornersOfOpenCV(const Mat& image, const Rect& region, int threshold)
{
    KeyPoints keypoints;
    FAST(image, keypoints, threshold, true);
    std::vector<Corner> corners;
    for (const KeyPoint& keypoint : keypoints)
    {
        const Corner corner = {int(keypoint.pt.x), int(keypoint.pt.y), int(keypoint.response)};
        if (region.contains(Point(corner.x, corner.y)))
            corners.push_back(corner);
    }
    return corners;
}

std::vector<Corner> corners(const Mat& image, const Rect& region, int threshold)
{
    std::vector<Corner> found;
    detectCorners(image, region, threshold, found);
    return found;
}

// The stage on either kernel, cv::FAST and the reference must all give the same corners.
void expectSameEverywhere(const Mat& image, const Rect& region, int threshold)
{
    const std::vector<Corner> expected = reference::fastCorners(image, region, threshold);
    EXPECT_TRUE(sameCorners(corners(image, region, threshold), expected));
    // cv::FAST reads beyond images without a circle
    if (image.cols >= 7 && image.rows >= 7)
    {
        EXPECT_TRUE(sameCorners(cornersOfOpenCV(image, region, threshold), expected));
    }
    WithoutOptimization baseline;
    EXPECT_TRUE(sameCorners(corners(image, region, threshold), expected));
}

TEST(Aqorb_Fast, equals_brute_force_for_every_width_alignment_and_threshold)
{
    for (int width = 1; width <= MAX_WIDTH; width++)
    {
        SCOPED_TRACE(format("width %d", width));
        const Mat dots = makeDots(Size(width, 9), width);
        const Rect region(Point(), dots.size());
        const std::vector<Corner> all = reference::fastCorners(dots, region, 1);
        atEveryOffset(dots,
                      [&](const Mat& image, int offset)
                      {
                          for (int threshold = offset + 1; threshold <= 255; threshold += 64)
                          {
                              std::vector<Corner> expected;
                              std::copy_if(all.begin(), all.end(), std::back_inserter(expected),
                                           [=](const Corner& corner) { return corner.score >= threshold; });
                              EXPECT_TRUE(sameCorners(corners(image, region, threshold), expected))
                                  << threshold;
                          }
                      });
    }
}

TEST(Aqorb_Fast, equals_brute_force_in_every_region)
{
    const Mat noise = makeNoise(Size(100, 60)), extremes = makeNoise(Size(100, 60), 2) > 200;
    RNG rng(4);
    for (int i = 0; i < 80; i++)
    {
        const Rect region(rng.uniform(0, 80), rng.uniform(0, 50), rng.uniform(1, 100), rng.uniform(1, 60));
        SCOPED_TRACE(format("%d, %d, %d x %d", region.x, region.y, region.width, region.height));
        expectSameEverywhere(noise, region, 1 + i);
        expectSameEverywhere(extremes, region, 250);
    }
    EXPECT_TRUE(corners(noise, Rect(), 1).empty());
    EXPECT_TRUE(corners(noise, Rect(-9, -9, 3, 3), 1).empty());
    EXPECT_TRUE(corners(noise, Rect(0, 0, 3, 60), 1).empty());
}

TEST(Aqorb_Fast, nine_of_the_circle_are_needed)
{
    static const int CIRCLE[16][2] = {{0, 3},  {1, 3},  {2, 2},  {3, 1},   {3, 0},   {3, -1},
                                      {2, -2}, {1, -3}, {0, -3}, {-1, -3}, {-2, -2}, {-3, -1},
                                      {-3, 0}, {-3, 1}, {-2, 2}, {-1, 3}};
    for (int first = 0; first < 16; first++)
        for (int length = 1; length <= 16; length++)
            for (int sign = -1; sign <= 1; sign += 2)
            {
                Mat image(9, 30, CV_8UC1, Scalar(100));
                for (int i = first; i < first + length; i++)
                    image.at<uchar>(4 + CIRCLE[i % 16][1], 12 + CIRCLE[i % 16][0]) = uchar(100 + sign * 60);
                const int score = cornerScore(image, 12, 4);
                EXPECT_EQ(score, length >= 9 ? 60 : 0) << first << " " << length << " " << sign;
                EXPECT_EQ(score, reference::cornerScore(image, 12, 4));
                expectSameEverywhere(image, Rect(12, 4, 1, 1), 30);
            }
}

TEST(Aqorb_Fast, scores_of_neighbours_equal_brute_force_everywhere)
{
    const Size sizes[] = {Size(60, 20), Size(25, 13), Size(9, 9), Size(3, 5), Size(1, 1)};
    for (const Size& size : sizes)
    {
        const Mat noise = makeNoise(size, 6);
        const Mat images[] = {noise, noise > 128, noise > 230, Mat(size, CV_8UC1, Scalar(255))};
        for (const Mat& image : images)
            for (int y = 0; y < size.height; y++)
                for (int x = 0; x < size.width; x++)
                {
                    int scores[3][3], baselineScores[3][3];
                    cornerScores3x3(image, x, y, scores);
                    {
                        WithoutOptimization baseline;
                        cornerScores3x3(image, x, y, baselineScores);
                    }
                    for (int i = 0; i < 9; i++)
                    {
                        const int dx = i % 3 - 1, dy = i / 3 - 1;
                        ASSERT_EQ(scores[dy + 1][dx + 1], reference::cornerScore(image, x + dx, y + dy))
                            << x << " " << y << " " << i;
                        ASSERT_EQ(scores[dy + 1][dx + 1], baselineScores[dy + 1][dx + 1]);
                    }
                }
    }
}

}  // namespace
}  // namespace opencv_test
