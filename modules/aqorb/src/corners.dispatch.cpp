// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "precomp.hpp"

#include "corners.hpp"
#include "fast.hpp"

#include "corners.simd.hpp"
#include "corners.simd_declarations.hpp"

namespace cv
{
namespace aqorb
{
namespace stages
{

static int writeKeptCorners(const CornerBlocks& blocks, const ScorePlane& plane, Corner* kept)
{
    const CornerBlock* first = blocks.storage.data();
    const uchar* scores = plane.row(first->y);
    CV_CPU_DISPATCH(writeKept, (first, blocks.cornerCount, scores, plane.step(), kept),
                    CV_CPU_DISPATCH_MODES_ALL);
}

void suppressCorners(const CornerBlocks& blocks, const ScorePlane& plane, std::vector<Corner>& kept)
{
    CV_TRACE_FUNCTION();
    kept.resize(blocks.cornerCount);
    if (blocks.count > 0)
        kept.resize(writeKeptCorners(blocks, plane, kept.data()));
}

void cornersWithout(const std::vector<Corner>& corners, const std::vector<Corner>& excluded,
                    std::vector<Corner>& remaining)
{
    remaining.clear();
    std::set_difference(corners.begin(), corners.end(), excluded.begin(), excluded.end(),
                        std::back_inserter(remaining), InRasterOrder());
}

Range cornerBand(const Rect& region, int cellSize, int index)
{
    const int ROWS = 64;  // fewer would not be worth a task of their own
    const int64 rows = (ROWS + int64(cellSize) - 1) / cellSize * cellSize,
                end = region.y + int64(region.height);
    return Range(int(std::min(region.y + index * rows, end)),
                 int(std::min(region.y + (index + 1) * rows, end)));
}

void findBandCorners(const Level& level, const Rect& band, Thresholds thresholds, int cellSize,
                     ScorePlane& plane, CornerBlocks& found, FastScanner& scanner)
{
    CV_TRACE_FUNCTION();
    found.count = found.cornerCount = 0;
    const Rect scanned = fastRegion(level.image.size(), band);
    if (scanned.empty())
        return;
    scanner.begin(level, scanned, thresholds, plane, found);
    const int side = std::min(cellSize, std::max(band.width, band.height));
    const Point end = band.br();
    for (int y = band.y; y < end.y; y += side)
    {
        scanner.scan(y + side);
        for (int x = band.x; x < end.x; x += side)
        {
            const Range cell(x, std::min(x + side, end.x));
            if (scanner.hasStrong(cell))
                scanner.dropWeak(cell);
        }
        scanner.collect();
    }
}

void findWeakCorners(const Level& level, const Rect& region, Thresholds thresholds,
                     const std::vector<Corner>& found, std::vector<Corner>& weak)
{
    CV_TRACE_FUNCTION();
    weak.clear();
    const Rect scanned = fastRegion(level.image.size(), region);
    if (thresholds.min >= thresholds.ini || scanned.empty())
        return;
    ScorePlane plane;
    plane.begin(level.image.cols, scanned);
    CornerBlocks blocks;
    FastScanner scanner;
    const Thresholds atMinimum = {thresholds.min, thresholds.min};
    findBandCorners(level, region, atMinimum, INT_MAX, plane, blocks, scanner);
    std::vector<Corner> all;
    listCorners(blocks, plane, all);
    cornersWithout(all, found, weak);
}

}  // namespace stages
}  // namespace aqorb
}  // namespace cv
