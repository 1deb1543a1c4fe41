// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "reference.hpp"

#include "corners.hpp"
#include "fast.hpp"

namespace opencv_test
{
namespace
{

using namespace aqorb;

//! Finds the corners of a region that is divided into bands.
std::vector<Corner> findCorners(const Level& level, const Rect& region, const Thresholds& thresholds,
                                bool suppressNear, int threads = 1)
{
    static FastScanner scanner;  // Images of all sizes share it.
    const CornerRules rules = {thresholds, suppressNear};
    std::vector<Corner> found, bandCorners(3);
    for (const Band& band : divideIntoBands(std::vector<Rect>(1, region), threads))
    {
        searchBand(level, region, band.rows, rules, scanner, bandCorners);
        found.insert(found.end(), bandCorners.begin(), bandCorners.end());
    }
    return found;
}

Level levelOf(const Mat& image, const Mat& mask = Mat())
{
    Level level;
    level.image = image;
    level.mask = mask;
    level.scale = 1;
    level.isInput = true;
    return level;
}

void expectAsReference(const Level& level, const Rect& region, int ini, int min, bool suppressNear,
                       int threads = 1)
{
    const Thresholds thresholds = {ini, min};
    const std::vector<Corner> expected =
        reference::findCorners(level.image, level.mask, region, thresholds, suppressNear);
    for (int optimized = 1; optimized >= 0; optimized--)
    {
        SCOPED_TRACE(optimized);
        const bool before = useOptimized();
        setUseOptimized(optimized && before);
        EXPECT_TRUE(sameCorners(findCorners(level, region, thresholds, suppressNear, threads), expected));
        setUseOptimized(before);
    }
}

TEST(Aqorb_Corners, equal_reference)
{
    const Size size(121, 93);
    Mat smooth;
    blur(makeNoise(size, 3), smooth, Size(3, 3));
    const Mat images[] = {makeScene(size, 2), makeNoise(size), makeNoise(size, 2) > 220, smooth};
    const int thresholds[][2] = {{1, 1}, {20, 5}, {60, 60}, {120, 10}, {254, 20}, {254, 1}};
    for (int i = 0; i < 4; i++)
        for (int j = 0; j < 6; j++)
            for (int border = 0; border < 12; border += 3)
            {
                SCOPED_TRACE(format("image %d, thresholds %d, border %d", i, j, border));
                const Rect region(border, border, size.width - 2 * border, size.height - 2 * border);
                const bool suppressNear = (j + border / 3) % 3 != 0;
                expectAsReference(levelOf(images[i]), region, thresholds[j][0], thresholds[j][1],
                                  suppressNear);
            }
}

struct Dot
{
    Point place;
    int contrast;
};

// A bright dot is a corner of score contrast - 1.
std::vector<Corner> cornersOfDots(const std::vector<Dot>& dots, const Rect& region,
                                  const Thresholds& thresholds, bool suppressNear, const Mat& mask = Mat())
{
    Mat image(80, 80, CV_8UC1, Scalar(20));
    for (const Dot& dot : dots)
        image.at<uchar>(dot.place) = uchar(20 + dot.contrast);
    return findCorners(levelOf(image, mask), region, thresholds, suppressNear);
}

TEST(Aqorb_Corners, a_weak_corner_counts_only_in_a_cell_without_strong_ones)
{
    const std::vector<Dot> dots = {{Point(15, 15), 101}, {Point(25, 25), 31}, {Point(60, 20), 31}};
    const Thresholds thresholds = {100, 10};
    const Rect region(10, 10, 60, 60);
    std::vector<Corner> corners = cornersOfDots(dots, region, thresholds, false);
    ASSERT_EQ(corners.size(), 2u);  // cells begin at the region's corner: (25, 25) is in the first
    EXPECT_EQ(corners[0].score, 100);
    EXPECT_EQ(corners[1].x, 60);
    EXPECT_EQ(corners[1].score, 30);

    // A corner that the mask takes away does not make its cell full.
    Mat mask(80, 80, CV_8UC1, Scalar(255));
    mask.at<uchar>(15, 15) = 0;
    corners = cornersOfDots(dots, region, thresholds, false, mask);
    EXPECT_EQ(corners.size(), 2u);
}

TEST(Aqorb_Corners, a_corner_falls_even_to_one_that_falls)
{
    // Three dots in a row, off each other's circles, so that the first and the last do not see each other. Of the two
    // equal ones on the left the first in raster order stays.
    const std::vector<Corner> corners = cornersOfDots({{Point(40, 40), 50},
                                                       {Point(43, 43), 80},
                                                       {Point(46, 46), 110},
                                                       {Point(60, 60), 60},
                                                       {Point(60, 64), 60},
                                                       {Point(20, 20), 60},
                                                       {Point(17, 23), 60}},
                                                      Rect(5, 5, 70, 70), {10, 10}, true);
    ASSERT_EQ(corners.size(), 4u);
    EXPECT_EQ(corners[0].x, 20);
    EXPECT_EQ(corners[1].x, 46);
    EXPECT_EQ(corners[2].y, 60);  // 4 pixels apart: both stay
    EXPECT_EQ(corners[3].y, 64);
}

// Corners that are suppressed from the other side of the border between two bands, and cells that end there.
TEST(Aqorb_Corners, of_several_bands_equal_reference)
{
    RNG rng(12);
    int divided = 0;
    for (int i = 0; i < 160; i++)
    {
        const int border = rng.uniform(0, i % 4 ? 32 : 3);
        const Size size(2 * border + rng.uniform(1, 60), 2 * border + rng.uniform(1, 700));
        const Rect region(border, border, size.width - 2 * border, size.height - 2 * border);
        const int min = rng.uniform(5, 60), ini = min + rng.uniform(0, 60);
        Mat noise = makeNoise(size, i), mask;
        if (i % 2)
            blur(noise, noise, Size(3, 3));
        if (i % 3 == 0)
            mask = makeNoise(size, -i) > rng.uniform(0, 256);
        const int threads = rng.uniform(1, 9);
        SCOPED_TRACE(format("%d: %d x %d, border %d, thresholds %d and %d, %d threads", i, size.width,
                            size.height, border, ini, min, threads));
        expectAsReference(levelOf(noise, mask), region, ini, min, i % 5 != 0, threads);
        divided += divideIntoBands(std::vector<Rect>(1, region), threads).size() > 2;
        if (HasFailure())
            return;
    }
    EXPECT_GT(divided, 50);
}

}  // namespace
}  // namespace opencv_test
