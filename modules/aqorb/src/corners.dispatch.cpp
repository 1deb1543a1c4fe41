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

static int splitCornersOf(const CornerBlocks& blocks, const uchar* scores, ptrdiff_t step, Corner* kept,
                          Corner* suppressed)
{
    CV_CPU_DISPATCH(splitCorners, (blocks.room.data(), blocks.cornerCount, scores, step, kept, suppressed),
                    CV_CPU_DISPATCH_MODES_ALL);
}

void suppressCorners(const CornerBlocks& blocks, ScorePlane& plane, LevelCorners& corners)
{
    CV_TRACE_FUNCTION();
    if (blocks.count == 0)
        return;
    const size_t kept = corners.kept.size(), suppressed = corners.suppressed.size();
    corners.kept.resize(kept + blocks.cornerCount);
    corners.suppressed.resize(suppressed + blocks.cornerCount);
    const int more = splitCornersOf(blocks, plane.row(blocks.room[0].y), plane.step(), &corners.kept[kept],
                                    &corners.suppressed[suppressed]);
    corners.kept.resize(kept + more);
    corners.suppressed.resize(suppressed + blocks.cornerCount - more);
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
    const Rect scanned = fastRegion(level.image.size(), region);
    if (scanned.empty())
        return;
    scratch.plane.begin(level.image.cols, scanned);
    findBandCorners(level, region, thresholds, cellSize, scratch.plane, scratch.blocks, scratch.scanner);
    if (suppressNear)
        suppressCorners(scratch.blocks, scratch.plane, corners);
    else
        listCorners(scratch.blocks, scratch.plane, corners.kept);
}

void findCellRejects(const Level& level, const Rect& region, Thresholds thresholds, int cellSize,
                     std::vector<Corner>& corners)
{
    CV_TRACE_FUNCTION();
    const Thresholds all = {thresholds.min, thresholds.min};
    LevelCorners found, taken;
    CornerScratch scratch;
    findCorners(level, region, all, cellSize, false, found, scratch);
    findCorners(level, region, thresholds, cellSize, false, taken, scratch);
    corners.clear();
    std::set_difference(found.kept.begin(), found.kept.end(), taken.kept.begin(), taken.kept.end(),
                        std::back_inserter(corners), InRasterOrder());
}

}  // namespace stages
}  // namespace aqorb
}  // namespace cv
