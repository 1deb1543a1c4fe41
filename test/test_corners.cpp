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

using namespace aqorb::stages;

// The corners to choose from, and those that suppression passes over.
struct LevelCorners
{
    std::vector<Corner> kept, suppressed;
};

// Memory that is used for one image after the other.
struct CornerScratch
{
    FastScanner scanner;
    ScorePlane plane;
    CornerBlocks blocks;
    std::vector<Corner> all;
};

// Finds the corners of a level as one band.
void findCorners(const Level& level, const Rect& region, Thresholds thresholds, int cellSize,
                 bool suppressNear, LevelCorners& corners, CornerScratch& scratch)
{
    corners.kept.clear();
    corners.suppressed.clear();
    scratch.all.clear();
    const Rect scanned = fastRegion(level.image.size(), region);
    if (scanned.empty())
        return;
    scratch.plane.begin(level.image.cols, scanned);
    findBandCorners(level, region, thresholds, cellSize, scratch.plane, scratch.blocks, scratch.scanner);
    listCorners(scratch.blocks, scratch.plane, scratch.all);
    if (suppressNear)
        suppressCorners(scratch.blocks, scratch.plane, corners.kept);
    else
        corners.kept = scratch.all;
    cornersWithout(scratch.all, corners.kept, corners.suppressed);
}

void findWeakCorners(const Level& level, const Rect& region, Thresholds thresholds, int cellSize,
                     std::vector<Corner>& weak)
{
    LevelCorners found;
    CornerScratch scratch;
    findCorners(level, region, thresholds, cellSize, false, found, scratch);
    findWeakCorners(level, region, thresholds, found.kept, weak);
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

// The reference gives all corners in raster order, and so must the stage.
void expectAsReference(const Level& level, const Rect& region, int ini, int min, int cellSize,
                       bool suppressNear, LevelCorners& workspace)
{
    const Thresholds thresholds = {ini, min};
    static CornerScratch scratch;  // Images of all sizes share it.
    const reference::Corners expected =
        reference::findCorners(level.image, level.mask, region, thresholds, cellSize, suppressNear);
    for (int optimized = 1; optimized >= 0; optimized--)
    {
        SCOPED_TRACE(optimized);
        const bool before = useOptimized();
        setUseOptimized(optimized && before);
        std::vector<Corner> weak;
        findCorners(level, region, thresholds, cellSize, suppressNear, workspace, scratch);
        findWeakCorners(level, region, thresholds, cellSize, weak);
        setUseOptimized(before);
        EXPECT_TRUE(sameCorners(workspace.kept, expected.kept));
        EXPECT_TRUE(sameCorners(workspace.suppressed, expected.suppressed));
        EXPECT_TRUE(sameCorners(weak, expected.weak));
    }
}

TEST(Aqorb_Corners, equal_reference)
{
    const Size size(121, 93);
    Mat smooth;
    blur(makeNoise(size, 3), smooth, Size(3, 3));
    const Mat images[] = {makeScene(size, 2), makeNoise(size), makeNoise(size, 2) > 220, smooth};
    const int thresholds[][2] = {{1, 1}, {20, 5}, {60, 60}, {120, 10}, {254, 20}, {254, 1}};
    const int cells[] = {8, 13, 35, 1000};
    LevelCorners workspace;
    for (int i = 0; i < 4; i++)
    {
        for (int j = 0; j < 6; j++)
        {
            for (int k = 0; k < 4; k++)
            {
                SCOPED_TRACE(format("image %d, thresholds %d, cells %d", i, j, cells[k]));
                const int border = (i + j + k) % 12;
                const Rect region(border, border, size.width - 2 * border, size.height - 2 * border);
                const bool suppressNear = (j + k) % 3 != 0;
                expectAsReference(levelOf(images[i]), region, thresholds[j][0], thresholds[j][1], cells[k],
                                  suppressNear, workspace);
            }
        }
    }
}

TEST(Aqorb_Corners, equal_reference_with_masks)
{
    const Size size(90, 70);
    const Mat scene = makeScene(size, 5);
    LevelCorners workspace;
    for (int i = 0; i < 10; i++)
    {
        SCOPED_TRACE(i);
        Mat mask = makeNoise(size, i) > i * 25;
        mask.setTo(1 + i, mask);
        expectAsReference(levelOf(scene, mask), Rect(3, 3, 84, 64), 40, 8, 16, i % 2 == 0, workspace);
    }
    expectAsReference(levelOf(scene, Mat::zeros(size, CV_8UC1)), Rect(3, 3, 84, 64), 40, 8, 16, true,
                      workspace);
}

TEST(Aqorb_Corners, equal_reference_for_every_width_and_any_workspace)
{
    LevelCorners workspace;  // What one image leaves in it must not show in the next, smaller or larger.
    for (int width = MAX_WIDTH; width >= 1; width--)
    {
        SCOPED_TRACE(width);
        const Mat noise = makeNoise(Size(width, 31), width);
        expectAsReference(levelOf(noise), Rect(Point(), noise.size()), 150, 30, 9, true, workspace);
    }
}

// A bright dot is a corner of score contrast - 1.
Mat dots(const std::vector<Point>& places, const std::vector<int>& contrasts)
{
    Mat image(80, 80, CV_8UC1, Scalar(20));
    for (size_t i = 0; i < places.size(); i++)
        image.at<uchar>(places[i]) = uchar(20 + contrasts[i]);
    return image;
}

TEST(Aqorb_Corners, a_weak_corner_counts_only_in_a_cell_without_strong_ones)
{
    const Point places[] = {Point(15, 15), Point(25, 25), Point(60, 20)};
    const int contrasts[] = {101, 31, 31};
    const Mat image =
        dots(std::vector<Point>(places, places + 3), std::vector<int>(contrasts, contrasts + 3));
    const Thresholds thresholds = {100, 10};
    const Rect region(10, 10, 60, 60);
    LevelCorners corners;
    CornerScratch scratch;
    findCorners(levelOf(image), region, thresholds, 30, false, corners, scratch);
    ASSERT_EQ(corners.kept.size(), 2u);  // cells begin at the region's corner: (25, 25) is in the first
    EXPECT_EQ(corners.kept[0].score, 100);
    EXPECT_EQ(corners.kept[1].x, 60);
    EXPECT_EQ(corners.kept[1].score, 30);
    std::vector<Corner> weak;
    findWeakCorners(levelOf(image), region, thresholds, 30, weak);
    ASSERT_EQ(weak.size(), 1u);
    EXPECT_EQ(weak[0].x, 25);

    // A corner that the mask takes away does not make its cell full.
    Mat mask(image.size(), CV_8UC1, Scalar(255));
    mask.at<uchar>(15, 15) = 0;
    findCorners(levelOf(image, mask), region, thresholds, 30, false, corners, scratch);
    EXPECT_EQ(corners.kept.size(), 2u);
    findWeakCorners(levelOf(image, mask), region, thresholds, 30, weak);
    EXPECT_TRUE(weak.empty());
}

TEST(Aqorb_Corners, a_corner_falls_even_to_one_that_falls)
{
    // Three dots in a row, off each other's circles, so that the first and the last do not see each other.
    const Point places[] = {Point(40, 40), Point(43, 43), Point(46, 46), Point(60, 60), Point(60, 64)};
    const int contrasts[] = {50, 80, 110, 60, 60};
    const Mat image =
        dots(std::vector<Point>(places, places + 5), std::vector<int>(contrasts, contrasts + 5));
    const Thresholds thresholds = {10, 10};
    LevelCorners corners;
    CornerScratch scratch;
    findCorners(levelOf(image), Rect(5, 5, 70, 70), thresholds, 35, true, corners, scratch);
    ASSERT_EQ(corners.kept.size(), 3u);
    EXPECT_EQ(corners.kept[0].x, 46);
    EXPECT_EQ(corners.kept[1].y, 60);  // 4 pixels apart: both stay
    EXPECT_EQ(corners.kept[2].y, 64);
    EXPECT_EQ(corners.suppressed.size(), 2u);
}

TEST(Aqorb_Corners, of_equal_ones_the_first_in_raster_order_stays)
{
    const Point places[] = {Point(40, 40), Point(37, 43), Point(20, 20), Point(23, 20)};
    const int contrasts[] = {60, 60, 60, 60};
    const Mat image =
        dots(std::vector<Point>(places, places + 4), std::vector<int>(contrasts, contrasts + 4));
    const Thresholds thresholds = {10, 10};
    LevelCorners corners;
    CornerScratch scratch;
    findCorners(levelOf(image), Rect(5, 5, 70, 70), thresholds, 35, true, corners, scratch);
    ASSERT_EQ(corners.kept.size(), 2u);
    EXPECT_EQ(corners.kept[0].x, 20);
    EXPECT_EQ(corners.kept[1].x, 40);
}

}  // namespace
}  // namespace opencv_test
