// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "reference.hpp"

#include "corners.hpp"
#include "fast.hpp"

#include <climits>

namespace opencv_test
{
namespace
{

using namespace aqorb;

// Memory that is used for one image after the other.
struct CornerScratch
{
    BandSearch search;
    std::vector<Seam> seams;
    std::vector<FoundCorners> bands;
};

//! Finds the corners of a region that is divided into bands, which are searched in any order, as several threads do.
void findCorners(const Level& level, const Rect& region, const Thresholds& thresholds, int cellSize,
                 bool suppressNear, FoundCorners& found, CornerScratch& scratch, int bands = 1,
                 bool listPassedOver = true)
{
    const CornerRules rules = {thresholds, cellSize, suppressNear, listPassedOver};
    scratch.seams.resize(std::max(scratch.seams.size(), size_t(bands)));
    scratch.bands.resize(std::max(scratch.bands.size(), size_t(bands)));
    const Rect scanned = fastRegion(level.image.size(), region);
    std::vector<int> order;
    std::vector<Range> rows;
    for (int i = 0; i < bands; i++)
    {
        order.push_back(i);
        rows.push_back(rowsOfBand(region, cellSize, bands, i));
        scratch.bands[i].clear();
        if (i > 0)
            scratch.seams[i].reset(level.image.cols, Range(scanned.x, scanned.x + scanned.width),
                                   rows[i].start);
    }
    RNG rng(bands);
    for (int i = bands; i > 1; i--)
        std::swap(order[i - 1], order[rng.uniform(0, i)]);
    for (int i : order)
    {
        const Rect band(region.x, rows[i].start, region.width, rows[i].size());
        scratch.search.find(level, band, rules, suppressNear && i > 0 ? &scratch.seams[i] : 0,
                            suppressNear && i < bands - 1 ? &scratch.seams[i + 1] : 0, scratch.bands[i]);
    }
    found.clear();
    for (int i = 0; i < bands; i++)
    {
        if (suppressNear && i > 0)
            scratch.seams[i].list(listPassedOver, found, scratch.search.scratch);
        found.append(scratch.bands[i]);
    }
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
                       bool suppressNear, FoundCorners& found, int bands = 1)
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
        findCorners(level, region, thresholds, cellSize, suppressNear, found, scratch, bands);
        setUseOptimized(before);
        EXPECT_TRUE(sameCorners(found.kept, expected.kept));
        EXPECT_TRUE(sameCorners(found.suppressed, expected.suppressed));
        EXPECT_TRUE(sameCorners(found.weak, expected.weak));
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
    FoundCorners found;
    for (int i = 0; i < 4; i++)
        for (int j = 0; j < 6; j++)
            for (int k = 0; k < 4; k++)
            {
                SCOPED_TRACE(format("image %d, thresholds %d, cells %d", i, j, cells[k]));
                const int border = (i + j + k) % 12;
                const Rect region(border, border, size.width - 2 * border, size.height - 2 * border);
                const bool suppressNear = (j + k) % 3 != 0;
                expectAsReference(levelOf(images[i]), region, thresholds[j][0], thresholds[j][1], cells[k],
                                  suppressNear, found);
            }
}

struct Dot
{
    Point place;
    int contrast;
};

// A bright dot is a corner of score contrast - 1.
FoundCorners cornersOfDots(const std::vector<Dot>& dots, const Rect& region, const Thresholds& thresholds,
                           int cellSize, bool suppressNear, const Mat& mask = Mat())
{
    Mat image(80, 80, CV_8UC1, Scalar(20));
    for (const Dot& dot : dots)
        image.at<uchar>(dot.place) = uchar(20 + dot.contrast);
    FoundCorners found;
    CornerScratch scratch;
    findCorners(levelOf(image, mask), region, thresholds, cellSize, suppressNear, found, scratch);
    return found;
}

TEST(Aqorb_Corners, a_weak_corner_counts_only_in_a_cell_without_strong_ones)
{
    const std::vector<Dot> dots = {{Point(15, 15), 101}, {Point(25, 25), 31}, {Point(60, 20), 31}};
    const Thresholds thresholds = {100, 10};
    const Rect region(10, 10, 60, 60);
    FoundCorners corners = cornersOfDots(dots, region, thresholds, 30, false);
    ASSERT_EQ(corners.kept.size(), 2u);  // cells begin at the region's corner: (25, 25) is in the first
    EXPECT_EQ(corners.kept[0].score, 100);
    EXPECT_EQ(corners.kept[1].x, 60);
    EXPECT_EQ(corners.kept[1].score, 30);
    ASSERT_EQ(corners.weak.size(), 1u);
    EXPECT_EQ(corners.weak[0].x, 25);

    // A corner that the mask takes away does not make its cell full.
    Mat mask(80, 80, CV_8UC1, Scalar(255));
    mask.at<uchar>(15, 15) = 0;
    corners = cornersOfDots(dots, region, thresholds, 30, false, mask);
    EXPECT_EQ(corners.kept.size(), 2u);
    EXPECT_TRUE(corners.weak.empty());
}

TEST(Aqorb_Corners, a_corner_falls_even_to_one_that_falls)
{
    // Three dots in a row, off each other's circles, so that the first and the last do not see each other. Of the two
    // equal ones on the left the first in raster order stays.
    const FoundCorners corners = cornersOfDots({{Point(40, 40), 50},
                                                {Point(43, 43), 80},
                                                {Point(46, 46), 110},
                                                {Point(60, 60), 60},
                                                {Point(60, 64), 60},
                                                {Point(20, 20), 60},
                                                {Point(17, 23), 60}},
                                               Rect(5, 5, 70, 70), {10, 10}, 35, true);
    ASSERT_EQ(corners.kept.size(), 4u);
    EXPECT_EQ(corners.kept[0].x, 20);
    EXPECT_EQ(corners.kept[1].x, 46);
    EXPECT_EQ(corners.kept[2].y, 60);  // 4 pixels apart: both stay
    EXPECT_EQ(corners.kept[3].y, 64);
    EXPECT_EQ(corners.suppressed.size(), 3u);
}

// Corners that are suppressed from the other side of the border between two bands, and cells that end there.
TEST(Aqorb_Corners, of_several_bands_equal_reference)
{
    RNG rng(12);
    FoundCorners corners;
    int divided = 0;
    for (int i = 0; i < 160; i++)
    {
        const int border = rng.uniform(0, i % 4 ? 32 : 3), cellSize = rng.uniform(1, 101);
        const Size size(2 * border + rng.uniform(1, 60), 2 * border + rng.uniform(1, 700));
        const Rect region(border, border, size.width - 2 * border, size.height - 2 * border);
        const int min = rng.uniform(5, 60), ini = min + rng.uniform(0, 60);
        Mat noise = makeNoise(size, i), mask;
        if (i % 2)
            blur(noise, noise, Size(3, 3));
        if (i % 3 == 0)
            mask = makeNoise(size, -i) > rng.uniform(0, 256);
        const int bands = std::min(rng.uniform(1, 9), mostBands(region, cellSize));
        SCOPED_TRACE(format("%d: %d x %d, border %d, cells %d, thresholds %d and %d, %d bands", i, size.width,
                            size.height, border, cellSize, ini, min, bands));
        expectAsReference(levelOf(noise, mask), region, ini, min, cellSize, i % 5 != 0, corners, bands);
        divided += bands > 2;
        if (HasFailure())
            return;
    }
    EXPECT_GT(divided, 50);
}

// The last band has hardly more rows than the seam takes, and without a border some of them cannot have corners.
TEST(Aqorb_Corners, of_bands_of_few_rows_equal_reference)
{
    FoundCorners corners;
    for (int i = 0; i < 120; i++)
    {
        const int border = i % 4, rest = 6 + i / 4 % 5, cellSize = 64 + i % 37;
        const int bands = 2 + i % 3, height = (bands - 1) * cellSize + rest;
        const Size size(2 * border + 50, 2 * border + height);
        const Rect region(border, border, 50, height);
        SCOPED_TRACE(format("border %d, %d cells of %d and %d rows", border, bands - 1, cellSize, rest));
        const Mat noise = makeNoise(size, i);
        expectAsReference(levelOf(noise), region, 90, 20, cellSize, true, corners,
                          std::min(bands, mostBands(region, cellSize)));
        if (HasFailure())
            return;
    }
}

// Each level has as many bands as are worth while, and each row of the region is in one of them.
TEST(Aqorb_Corners, bands_are_of_whole_cells)
{
    RNG rng(3);
    for (int i = 0; i < 2000; i++)
    {
        const Rect region(rng.uniform(0, 40), rng.uniform(0, 40), rng.uniform(1, 2000), rng.uniform(1, 3000));
        const int cellSize = i % 10 ? rng.uniform(1, 200) : INT_MAX, most = mostBands(region, cellSize);
        SCOPED_TRACE(format("%d rows, cells of %d", region.height, cellSize));
        ASSERT_GE(most, 1);
        ASSERT_LE(most, std::max(region.height / 64, 1));
        const int bands = rng.uniform(1, most + 1);
        int end = region.y;
        for (int band = 0; band < bands; band++)
        {
            const Range rows = rowsOfBand(region, cellSize, bands, band);
            ASSERT_EQ(rows.start, end);
            ASSERT_EQ((rows.start - region.y) % cellSize, 0);
            // A seam takes so many rows from each of two bands.
            ASSERT_TRUE(bands == 1 || rows.size() >= ScorePlane::ROWS_ABOVE) << rows.size();
            end = rows.end;
        }
        ASSERT_EQ(end, region.y + region.height);
    }
}

TEST(Aqorb_Corners, passed_over_are_listed_only_where_that_is_asked_for)
{
    const Mat scene = makeScene(Size(120, 700), 4);
    const Rect region(16, 16, 88, 668);
    const Thresholds thresholds = {30, 8};
    CornerScratch scratch;
    for (int bands = 1; bands <= 8; bands++)
        for (int suppressNear = 0; suppressNear < 2; suppressNear++)
        {
            SCOPED_TRACE(format("%d bands, suppression %d", bands, suppressNear));
            FoundCorners all, kept;
            findCorners(levelOf(scene), region, thresholds, 20, suppressNear != 0, all, scratch, bands);
            ASSERT_GT(all.kept.size(), 100u);
            ASSERT_FALSE(all.weak.empty());
            ASSERT_EQ(all.suppressed.empty(), suppressNear == 0);
            findCorners(levelOf(scene), region, thresholds, 20, suppressNear != 0, kept, scratch, bands,
                        false);
            EXPECT_TRUE(sameCorners(kept.kept, all.kept));
            EXPECT_TRUE(kept.suppressed.empty());
            EXPECT_TRUE(kept.weak.empty());
        }
}

}  // namespace
}  // namespace opencv_test
