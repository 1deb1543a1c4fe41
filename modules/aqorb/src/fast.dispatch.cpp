// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// Prepares the scan of a level, and scores single pixels.

#include "precomp.hpp"

#include "types.hpp"
#include "fast.hpp"
#include "patch.hpp"

#include "fast.simd.hpp"
#include "fast.simd_declarations.hpp"

namespace cv
{
namespace aqorb
{

namespace
{

// Which pixels of a block are in a range of columns, a bit for each.
uint64 columnsOf(int x, int width, const Range& columns)
{
    const int begin = std::max(columns.start, x), end = std::min(columns.end, x + width);
    return begin < end ? (~uint64(0) >> (64 - (end - begin))) << (begin - x) : 0;
}

// Covers columns, and one more on both sides, with blocks inside `pixels`.
void coverWithBlocks(const Range& columns, const Range& pixels, int width, std::vector<ScanBlock>& blocks)
{
    blocks.clear();
    const int end = std::min(columns.end + 1, pixels.end);
    for (int x = std::max(columns.start - 1, pixels.start), next; x < end; x = next)
    {
        // The last block may overlap the one before, whose columns are not wanted twice.
        const int first = std::min(x, pixels.end - width);
        next = first + width;
        const Range wanted(std::max(columns.start, x), columns.end);
        blocks.push_back({first, columnsOf(first, width, wanted)});
    }
}

void continueFastScan(const ScanArea& area, ScanScores& kept, ScanCorners& corners, int end)
{
    CV_CPU_DISPATCH(continueScan, (area, kept, corners, end), CV_CPU_DISPATCH_MODES_ALL);
}

int widthOfBlocks(int columns)
{
    CV_CPU_DISPATCH(blockWidthFor, (columns), CV_CPU_DISPATCH_MODES_ALL);
}

int dropCornersOfScan(ScanCorners& corners, int blockWidth, int first, const uchar* floors)
{
    CV_CPU_DISPATCH(dropCorners, (corners, blockWidth, first, floors), CV_CPU_DISPATCH_MODES_ALL);
}

}  // namespace

Rect fastRegion(Size imageSize, const Rect& region)
{
    return region & Rect(FAST_RADIUS, FAST_RADIUS, imageSize.width - 2 * FAST_RADIUS,
                         imageSize.height - 2 * FAST_RADIUS);
}

// Where column 0 of the first row in a buffer is, if the given column is to be aligned.
static uchar* alignedRow(uchar* buffer, int column)
{
    return alignPtr(buffer + SCAN_MARGIN + column, SCAN_ALIGNMENT) - column;
}

static size_t rowBytesOf(int imageWidth)
{
    return alignSize(size_t(imageWidth) + 2 * SCAN_MARGIN, SCAN_ALIGNMENT);
}

void ScorePlane::reset(int imageWidth, const Range& columns_, int top_, int rows)
{
    const size_t bytesOfRow = rowBytesOf(imageWidth);
    growTo(bytes, (ROWS_ABOVE + size_t(rows) + SUPPRESS_RADIUS) * bytesOfRow + SCAN_ALIGNMENT);
    columns = columns_;
    top = top_;
    rowBytes = ptrdiff_t(bytesOfRow);
    // As a rule the first block of a scan begins one column before the region.
    first = alignedRow(bytes.data() + ROWS_ABOVE * bytesOfRow, std::max(columns.start - 1, FAST_RADIUS)) -
            bytes.data();
    std::fill_n(row(top) - SCAN_MARGIN - ROWS_ABOVE * rowBytes, ROWS_ABOVE * bytesOfRow, uchar(0));
}

void ScorePlane::slideTo(int top_)
{
    if (top_ <= top)
        return;
    std::memmove(row(top - ROWS_ABOVE) - SCAN_MARGIN, row(top_ - ROWS_ABOVE) - SCAN_MARGIN,
                 size_t(ROWS_ABOVE * rowBytes));
    top = top_;
}

void ScorePlane::clearBelow(int y)
{
    std::fill_n(row(y) - SCAN_MARGIN, size_t(SUPPRESS_RADIUS * rowBytes), uchar(0));
}

void FastScanner::reset(const Level& level, const Rect& region, Thresholds thresholds, ScorePlane& plane_,
                        CornerBlocks& corners_)
{
    plane = &plane_;
    const Mat& image = level.image;
    const Rect pixels = fastRegion(image.size(), Rect(Point(), image.size()));
    const int width = widthOfBlocks(pixels.width);
    coverWithBlocks(Range(region.x, region.x + region.width), Range(pixels.x, pixels.x + pixels.width), width,
                    blocks);
    const size_t blockCount = blocks.size();
    growTo(listed, 2 * blockCount);
    growTo(floors, size_t(image.cols));
    const size_t rowBytes = rowBytesOf(image.cols);
    growTo(scores, SCAN_ROWS * rowBytes + SCAN_ALIGNMENT);
    corners = &corners_;
    corners->count = corners->cornerCount = 0;

    area.image = image.ptr();
    area.step = ptrdiff_t(image.step);
    area.width = image.cols;
    area.height = image.rows;
    area.mask = level.mask.empty() ? 0 : level.mask.ptr();
    area.maskStep = ptrdiff_t(level.mask.step);
    area.top = region.y;
    area.bottom = region.y + region.height;
    area.blocks = blocks.data();
    area.blockCount = int(blockCount);
    area.blockWidth = width;
    area.strongThreshold = std::min(std::max(thresholds.ini, 1), 255);  // suppression needs scores > 0
    area.threshold = std::min(std::max(thresholds.min, 1), area.strongThreshold);
    kept.nextRow = area.top - 1;
    kept.rows = alignedRow(scores.data(), blocks[0].x);
    kept.step = ptrdiff_t(rowBytes);
    for (int i = 0; i < 2; i++)
    {
        kept.listed[i] = listed.data() + i * blockCount;
        kept.listedCount[i] = 0;
    }
    out.planeStep = plane->step();
    columns = Range(region.x, region.x + region.width);
}

void FastScanner::scan(int end)
{
    end = std::min(end, area.bottom);
    const size_t rows = size_t(std::max(end - kept.nextRow + 1, 0));  // suppression is one row behind
    out.planeTop = plane->topRow();
    out.plane = plane->row(out.planeTop);
    out.foundCount = corners->count;
    const size_t most = out.foundCount + rows * blocks.size() + 2;
    corners->storage.reserve(most);  // without this, a vector that grows may get twice as much
    corners->storage.resize(std::max(corners->storage.size(), most));
    out.found = corners->storage.data();
    strong.assign(blocks.size(), 0);
    out.strong = strong.data();
    std::fill_n(floors.begin() + blocks[0].x, blocks.back().x + area.blockWidth - blocks[0].x, uchar(255));
    std::fill_n(floors.begin() + columns.start, columns.size(), uchar(0));
    continueFastScan(area, kept, out, end);
}

bool FastScanner::hasStrong(const Range& range) const
{
    const int width = area.blockWidth;
    const int before = (range.start - blocks[0].x) / width;
    for (size_t i = size_t(std::max(before, 0)); i < blocks.size() && blocks[i].x < range.end; i++)
    {
        if (strong[i] & columnsOf(blocks[i].x, width, range))
            return true;
    }
    return false;
}

void FastScanner::dropWeak(const Range& range)
{
    const Range inside = range & columns;
    std::fill(floors.begin() + inside.start, floors.begin() + inside.end, uchar(area.strongThreshold));
}

void FastScanner::collect()
{
    corners->cornerCount += dropCornersOfScan(out, area.blockWidth, corners->count, floors.data());
    corners->count = out.foundCount;
}

void listCorners(const CornerBlock* first, const CornerBlock* last, const ScorePlane& plane,
                 std::vector<Corner>& corners)
{
    for (const CornerBlock* block = first; block < last; block++)
    {
        const uchar* scores = plane.row(block->y);
        for (uint64 columns = block->columns; columns; columns &= columns - 1)
        {
            const int x = block->x + trailingZeros(columns);
            corners.push_back({x, block->y, scores[x] - 1});
        }
    }
}

static void neighborCornerScores(const uchar* p, ptrdiff_t step, int scores[3][3])
{
    CV_CPU_DISPATCH(neighborScores, (p, step, scores), CV_CPU_DISPATCH_MODES_ALL);
}

void cornerScores3x3(const Mat& image, int x, int y, int scores[3][3])
{
    const int READ = 17;  // as far as vectors read
    PatchBuffer buffer;
    const Patch patch = patchAround(image, x, y, READ, buffer);
    neighborCornerScores(patch.center, patch.step, scores);
}

int writeKeptCorners(const CornerBlock* first, int cornerCount, const ScorePlane& plane, Corner* kept)
{
    const uchar* scores = plane.row(first->y);
    CV_CPU_DISPATCH(writeKept, (first, cornerCount, scores, plane.step(), kept), CV_CPU_DISPATCH_MODES_ALL);
}

}  // namespace aqorb
}  // namespace cv
