// This file is part of the aqorb project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.

#include "precomp.hpp"

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
    const CornerBlock* first = blocks.room.data();
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

void cornersWithout(const std::vector<Corner>& corners, const std::vector<Corner>& without,
                    std::vector<Corner>& rest)
{
    rest.clear();
    std::set_difference(corners.begin(), corners.end(), without.begin(), without.end(),
                        std::back_inserter(rest), InRasterOrder());
}

Range cornerBand(const Rect& region, int cellSize, int index)
{
    const int ROWS = 64;  // enough for a thread to be worth its while
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
        scanner.settle();
    }
}

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

void findCellRejects(const Level& level, const Rect& region, Thresholds thresholds,
                     const std::vector<Corner>& found, std::vector<Corner>& corners)
{
    CV_TRACE_FUNCTION();
    corners.clear();
    if (thresholds.min >= thresholds.ini)
        return;
    const Thresholds all = {thresholds.min, thresholds.min};
    LevelCorners atMinimum;
    CornerScratch scratch;
    findCorners(level, region, all, INT_MAX, false, atMinimum, scratch);
    cornersWithout(atMinimum.kept, found, corners);
}

void findCellRejects(const Level& level, const Rect& region, Thresholds thresholds, int cellSize,
                     std::vector<Corner>& corners)
{
    LevelCorners found;
    CornerScratch scratch;
    findCorners(level, region, thresholds, cellSize, false, found, scratch);
    findCellRejects(level, region, thresholds, found.kept, corners);
}

}  // namespace stages
}  // namespace aqorb
}  // namespace cv
