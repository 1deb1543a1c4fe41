// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "reference.hpp"

#include "detector/corners.hpp"
#include "detector/fast.hpp"

#include <iterator>

namespace opencv_test
{
namespace
{

using namespace aqorb;

//! Positions of corners, with score 0.
std::vector<Corner> positionsOf(const std::vector<Corner>& corners)
{
    std::vector<Corner> positions;
    for (const Corner& corner : corners)
        positions.push_back({corner.x, corner.y, 0});
    return positions;
}

std::vector<Corner> positionsOf(const std::vector<CornerBlock>& blocks)
{
    std::vector<Corner> positions;
    for (const CornerBlock& block : blocks)
        for (int i = 0; i < 64; i++)
            if (block.columns >> i & 1)
                positions.push_back({block.x + i, block.y, 0});
    return positions;
}

//! Finds the corners of a region that is divided into bands.
//! @param all receives the positions of all corners at the lower threshold
std::vector<Corner> findCorners(const Level& level, const Rect& region, const Thresholds& thresholds,
                                bool suppressNear, int threads, std::vector<Corner>& all)
{
    static FastScanner scanner;  // Images of all sizes share it.
    std::atomic<int64> room(INT_MAX);
    const CornerRules rules = {thresholds, suppressNear, &room};
    std::vector<Corner> found;
    CornerLists lists;
    lists.chosen.resize(3);
    lists.all.resize(3);
    all.clear();
    for (const Band& band : divideIntoBands(std::vector<Rect>(1, region), threads))
    {
        searchBand(level, region, band.rows, rules, scanner, lists);
        found.insert(found.end(), lists.chosen.begin(), lists.chosen.end());
        const std::vector<Corner> positions = positionsOf(lists.all);
        all.insert(all.end(), positions.begin(), positions.end());
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
                       int threads)
{
    const auto expected = [&](const Thresholds& thresholds, bool isSuppressed)
    { return reference::findCorners(level.image, level.mask, region, thresholds, isSuppressed); };
    const std::vector<Corner> chosen = expected({ini, min}, suppressNear),
                              all = positionsOf(expected({min, min}, false));
    const auto expectFound = [&]
    {
        std::vector<Corner> foundAll;
        EXPECT_TRUE(
            sameCorners(findCorners(level, region, {ini, min}, suppressNear, threads, foundAll), chosen));
        EXPECT_TRUE(sameCorners(foundAll, all));
    };
    expectFound();
    WithoutOptimization baseline;
    expectFound();
}

// Corners that are suppressed from the other side of the border between two bands, and cells that end there.
TEST(Aqorb_Corners, of_one_or_several_bands_equal_reference)
{
    RNG rng(12);
    const int limits[][2] = {{1, 1}, {254, 1}, {254, 20}, {120, 10}, {60, 60}};
    int divided = 0;
    for (int i = 0; i < 250 && !HasFailure(); i++)
    {
        const int border = rng.uniform(0, i % 4 ? 32 : 3);
        const Size size(2 * border + rng.uniform(1, 90), 2 * border + rng.uniform(1, 700));
        const Rect region(border, border, size.width - 2 * border, size.height - 2 * border);
        int min = rng.uniform(5, 60), ini = min + rng.uniform(0, 60);
        if (i % 7 < 5)
        {
            ini = limits[i % 7][0];
            min = limits[i % 7][1];
        }
        Mat image = i % 8 == 4 ? makeScene(size, i) : makeNoise(size, i), mask;
        if (i % 8 == 2)
            image = image > 220;
        if (i % 2)
            blur(image, image, Size(3, 3));
        if (i % 3 == 0)
            mask = makeNoise(size, -i) > rng.uniform(0, 256);
        const int threads = rng.uniform(1, 9);
        SCOPED_TRACE(format("%d: %d x %d, border %d, thresholds %d and %d, %d threads", i, size.width,
                            size.height, border, ini, min, threads));
        expectAsReference(levelOf(image, mask), region, ini, min, i % 5 != 0, threads);
        divided += divideIntoBands(std::vector<Rect>(1, region), threads).size() > 2;
    }
    EXPECT_GT(divided, 50);
}

// The corners of score >= threshold whose centres lie in the region, in raster order.
std::vector<Corner> corners(const Mat& image, const Rect& region, int threshold)
{
    std::vector<Corner> found;
    const Rect scanned = fastRegion(image.size(), region);
    if (scanned.empty())
        return found;
    FastScanner scanner;
    scanner.begin(levelOf(image), scanned, {threshold, threshold}, scanned.height);
    std::atomic<int64> room(INT_MAX);
    std::vector<CornerBlock> all;
    scanner.scan(scanned.br().y, std::vector<Range>(), room, all);
    scanner.append(false, found);
    return found;
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

TEST(Aqorb_Corners, of_fast_equal_brute_force_and_opencv_for_every_width_alignment_and_threshold)
{
    for (int width = 1; width <= MAX_WIDTH; width++)
    {
        SCOPED_TRACE(format("width %d", width));
        const Mat dots = makeDots(Size(width, 9), width);
        const Rect region(Point(), dots.size());
        const std::vector<Corner> all = reference::fastCorners(dots, region, 1);
        if (width >= 7)  // cv::FAST reads beyond images without a circle
        {
            EXPECT_TRUE(sameCorners(cornersOfOpenCV(dots, region, 1), all));
        }
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

}  // namespace
}  // namespace opencv_test
