// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "precomp.hpp"

#include "aligned.hpp"
#include "corners.hpp"

#include "corners.simd.hpp"
#include "corners.simd_declarations.hpp"

namespace cv
{
namespace aqorb
{

namespace
{

int writeKeptCorners(const CornerBlock* first, int cornerCount, const ScorePlane& plane, Corner* kept)
{
    const uchar* scores = plane.row(first->y);
    CV_CPU_DISPATCH(writeKept, (first, cornerCount, scores, plane.step(), kept), CV_CPU_DISPATCH_MODES_ALL);
}

// Appends corners to a list. Lists of corners are long and stay, so they grow by little more than they need.
void appendTo(std::vector<Corner>& corners, const Corner* first, const Corner* last)
{
    const size_t size = corners.size() + size_t(last - first);
    if (size > corners.capacity())
        corners.reserve(size + size / 8);
    corners.insert(corners.end(), first, last);
}

// Appends the corners of the first blocks: those that have no better one nearby, and the others.
void appendCorners(const CornerBlocks& blocks, int blockCount, int cornerCount, const ScorePlane& plane,
                   bool listPassedOver, FoundCorners& found, std::vector<Corner>& scratch)
{
    if (cornerCount == 0)
        return;
    // The kernel writes every corner before it knows whether it is kept.
    growTo(scratch, size_t(cornerCount) + 1);
    Corner* const kept = scratch.data();
    const int keptCount = writeKeptCorners(blocks.storage.data(), cornerCount, plane, kept);
    appendTo(found.kept, kept, kept + keptCount);
    if (!listPassedOver)
        return;
    const size_t before = found.suppressed.size();
    listCorners(blocks.storage.data(), blocks.storage.data() + blockCount, plane, found.suppressed);
    const auto isKept = [&](const Corner& corner)
    { return std::binary_search(kept, kept + keptCount, corner, InRasterOrder()); };
    found.suppressed.erase(std::remove_if(found.suppressed.begin() + before, found.suppressed.end(), isKept),
                           found.suppressed.end());
}

// Copies the blocks from `begin` to before `end` to the end of another list. There must be space for two more, which the
// kernel reads.
void appendBlocks(const CornerBlocks& blocks, int begin, int end, CornerBlocks& target)
{
    target.storage.resize(size_t(target.count + end - begin) + 2);
    for (int i = begin; i < end; i++)
    {
        target.storage[target.count++] = blocks.storage[i];
        target.cornerCount += bitCount(blocks.storage[i].columns);
    }
}

}  // namespace

void Seam::reset(int imageWidth, const Range& columns, int y)
{
    plane.reset(imageWidth, columns, y, ScorePlane::ROWS_ABOVE);
    above.count = above.cornerCount = below.count = below.cornerCount = 0;
}

void FoundCorners::clear()
{
    kept.clear();
    suppressed.clear();
    weak.clear();
}

void FoundCorners::append(const FoundCorners& next)
{
    appendTo(kept, next.kept.data(), next.kept.data() + next.kept.size());
    appendTo(suppressed, next.suppressed.data(), next.suppressed.data() + next.suppressed.size());
    appendTo(weak, next.weak.data(), next.weak.data() + next.weak.size());
}

void Seam::list(bool listPassedOver, FoundCorners& found, std::vector<Corner>& scratch) const
{
    appendCorners(above, above.count, above.cornerCount, plane, listPassedOver, found, scratch);
    appendCorners(below, below.count, below.cornerCount, plane, listPassedOver, found, scratch);
}

// Takes the corners of the rows before `end`. The SUPPRESS_RADIUS rows from there on must have their scores, too, as far as
// there are any.
void BandSearch::take(int end, bool listPassedOver, FoundCorners& found)
{
    int taken = blocks.count, left = 0;  // corners that are not taken yet
    while (taken > 0 && blocks.storage[taken - 1].y >= end)
        left += bitCount(blocks.storage[--taken].columns);
    appendCorners(blocks, taken, blocks.cornerCount - left, plane, listPassedOver, found, scratch);
    removeFirst(taken, left);
}

void BandSearch::removeFirst(int removed, int cornersLeft)
{
    std::copy(blocks.storage.begin() + removed, blocks.storage.begin() + blocks.count,
              blocks.storage.begin());
    blocks.count -= removed;
    blocks.cornerCount = cornersLeft;
}

// Leaves the corners of the first rows to the seam above.
void BandSearch::giveFirst(int end, Seam& above)
{
    int given = 0;
    while (given < blocks.count && blocks.storage[given].y < end)
        given++;
    const int before = above.below.cornerCount;
    appendBlocks(blocks, 0, given, above.below);
    removeFirst(given, blocks.cornerCount - (above.below.cornerCount - before));
}

void BandSearch::find(const Level& level, const Rect& band, const CornerRules& rules, Seam* above,
                      Seam* below, FoundCorners& found)
{
    CV_TRACE_FUNCTION();
    const Rect scanned = fastRegion(level.image.size(), band);
    if (scanned.empty())
        return;
    const Point end = band.br();
    const int bottom = scanned.y + scanned.height,
              side = std::min(rules.cellSize, std::max(band.width, band.height));
    plane.reset(level.image.cols, Range(scanned.x, scanned.x + scanned.width), scanned.y,
                std::min(side, scanned.height));
    scanner.reset(level, scanned, rules.thresholds, plane, blocks);
    int copied = scanned.y;  // rows before it have been copied to the seam above
    for (int y = band.y; y < end.y; y += side)
    {
        const int scannedEnd = std::min(y + side, bottom);
        plane.slideTo(std::min(y, bottom));
        scanner.scan(scannedEnd);
        for (int x = band.x; x < end.x; x += side)
        {
            const Range cell(x, std::min(x + side, end.x));
            if (scanner.hasStrong(cell))
                scanner.dropWeak(cell);
        }
        scanner.collect(rules.listPassedOver ? &found.weak : 0);
        if (!rules.suppressNear)
        {
            listCorners(blocks.storage.data(), blocks.storage.data() + blocks.count, plane, found.kept);
            removeFirst(blocks.count, 0);
        }
        if (above)
        {
            for (; copied < std::min(scannedEnd, scanned.y + ScorePlane::ROWS_ABOVE); copied++)
                above->plane.copyRow(copied, plane);
            giveFirst(scanned.y + SUPPRESS_RADIUS, *above);
        }
        take(scannedEnd - SUPPRESS_RADIUS, rules.listPassedOver, found);
    }
    // With an edgeThreshold below 3 the last band may have fewer than ROWS_ABOVE rows in which a whole circle fits. The
    // missing rows of the seam have no corners.
    if (above)
        above->plane.clearBelow(copied);
    if (below)
    {
        for (int y = bottom - ScorePlane::ROWS_ABOVE; y < bottom; y++)
            below->plane.copyRow(y, plane);
        appendBlocks(blocks, 0, blocks.count, below->above);
    }
    else
    {
        plane.clearBelow(bottom);
        take(bottom, rules.listPassedOver, found);
    }
}

// The rows of cells with which a band may begin: a seam takes ROWS_ABOVE rows from the bands above and below.
static int64 rowsOfCells(const Rect& region, int cellSize)
{
    return (int64(region.height) - ScorePlane::ROWS_ABOVE) / cellSize + 1;
}

int mostBands(const Rect& region, int cellSize)
{
    const int ROWS = 64;
    return int(std::max<int64>(std::min<int64>(rowsOfCells(region, cellSize), region.height / ROWS), 1));
}

Range rowsOfBand(const Rect& region, int cellSize, int bands, int index)
{
    const int64 cells = rowsOfCells(region, cellSize);
    const auto top = [&](int band) { return region.y + int(cells * band / bands * cellSize); };
    return Range(top(index), index == bands - 1 ? region.y + region.height : top(index + 1));
}

}  // namespace aqorb
}  // namespace cv
