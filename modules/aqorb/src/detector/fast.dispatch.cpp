// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// Class FastScanner, and FAST scores of single pixels.

#include "precomp.hpp"

#include "detector/types.hpp"
#include "detector/fast.hpp"
#include "detector/neighborhood.hpp"

#include "detector/fast.simd.hpp"
// Generated: CV_CPU_DISPATCH_MODES_ALL=AVX512_SKX, AVX2, BASELINE on x86-64.
#include "detector/fast.simd_declarations.hpp"

namespace cv
{
namespace aqorb
{

namespace
{

// Bits of the pixels of a block that lie in a range of columns.
uint64 columnBits(int x, int width, const Range& columns)
{
    const int begin = std::max(columns.start, x), end = std::min(columns.end, x + width);
    return begin < end ? (~uint64(0) >> (64 - (end - begin))) << (begin - x) : 0;
}

// Covers columns, and one more on each side, with blocks inside `pixels`.
void coverWithBlocks(const Range& columns, const Range& pixels, int width, std::vector<ScanBlock>& blocks)
{
    blocks.clear();
    const int end = std::min(columns.end + 1, pixels.end);
    for (int x = std::max(columns.start - 1, pixels.start), next; x < end; x = next)
    {
        // The last block may overlap the block before, but each column is wanted once.
        const int first = std::min(x, pixels.end - width);
        next = first + width;
        const Range wanted(std::max(columns.start, x), columns.end);
        blocks.push_back({first, columnBits(first, width, wanted)});
    }
}

void continueFastScan(const ScanArea& area, ScanScores& kept, ScanCorners& corners, int end)
{
    CV_CPU_DISPATCH(continueScan, (area, kept, corners, end), CV_CPU_DISPATCH_MODES_ALL);
}

int scanBlockWidth(int columns)
{
    CV_CPU_DISPATCH(blockWidthFor, (columns), CV_CPU_DISPATCH_MODES_ALL);
}

int dropScanCorners(ScanCorners& corners, int blockWidth, int first, const uchar* dropped)
{
    CV_CPU_DISPATCH(dropCorners, (corners, blockWidth, first, dropped), CV_CPU_DISPATCH_MODES_ALL);
}

}  // namespace

Rect fastRegion(Size imageSize, const Rect& region)
{
    return region & Rect(FAST_RADIUS, FAST_RADIUS, imageSize.width - 2 * FAST_RADIUS,
                         imageSize.height - 2 * FAST_RADIUS);
}

// Address of column 0 in a buffer that aligns the given column.
static uchar* alignedRow(uchar* buffer, int column)
{
    return alignPtr(buffer + SCAN_MARGIN + column, CACHE_LINE) - column;
}

static size_t rowBytesOf(int imageWidth)
{
    return alignSize(size_t(imageWidth) + 2 * SCAN_MARGIN, CACHE_LINE);
}

void ScorePlane::reset(int imageWidth, const Rect& region, int rows)
{
    const size_t rowSize = rowBytesOf(imageWidth);
    growTo(bytes, (ROWS_ABOVE + size_t(rows) + SUPPRESS_RADIUS) * rowSize + CACHE_LINE);
    top = region.y;
    rowBytes = ptrdiff_t(rowSize);
    // The first block of a scan usually begins one column before the region.
    first =
        alignedRow(bytes.data() + ROWS_ABOVE * rowSize, std::max(region.x - 1, FAST_RADIUS)) - bytes.data();
    std::fill_n(row(top) - SCAN_MARGIN - ROWS_ABOVE * rowBytes, ROWS_ABOVE * rowSize, uchar(0));
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

void FastScanner::begin(const Level& level, const Rect& region, Thresholds thresholds, int rows)
{
    const Mat& image = level.image;
    const Rect pixels = fastRegion(image.size(), Rect(Point(), image.size()));
    const int width = scanBlockWidth(pixels.width);
    columns = Range(region.x, region.x + region.width);
    coverWithBlocks(columns, Range(pixels.x, pixels.x + pixels.width), width, blocks);
    const size_t blockCount = blocks.size();
    growTo(listed, 2 * blockCount);
    growTo(dropped, size_t(image.cols));
    const size_t rowBytes = rowBytesOf(image.cols);
    growTo(scores, SCAN_ROWS * rowBytes + CACHE_LINE);
    plane.reset(image.cols, region, std::min(rows, region.height));
    foundCount = cornerCount = 0;

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
    out.planeStep = plane.step();
}

void FastScanner::scan(int end, const std::vector<Range>& cells, std::atomic<int64>& room,
                       std::vector<CornerBlock>& all)
{
    end = std::min(end, area.bottom);
    const size_t rows = size_t(end - kept.nextRow + 1);  // suppression lags by one row
    plane.slideTo(kept.nextRow - 1);
    out.planeTop = plane.topRow();
    out.plane = plane.row(out.planeTop);
    out.foundCount = foundCount;
    const size_t maxCount = foundCount + rows * blocks.size() + 2;
    found.reserve(maxCount);  // resize alone may allocate twice as much
    found.resize(std::max(found.size(), maxCount));
    out.found = found.data();
    strong.assign(blocks.size(), 0);
    out.strong = strong.data();
    continueFastScan(area, kept, out, end);
    if ((room -= out.foundCount - foundCount) >= 0)
        all.insert(all.end(), found.begin() + foundCount, found.begin() + out.foundCount);

    // dropped[x]: highest score to drop in column x.
    std::fill_n(dropped.begin() + blocks[0].x, blocks.back().x + area.blockWidth - blocks[0].x, uchar(255));
    std::fill_n(dropped.begin() + columns.start, columns.size(), uchar(0));
    for (const Range& cell : cells)
    {
        const Range inside = cell & columns;
        if (hasStrong(cell))
            std::fill(dropped.begin() + inside.start, dropped.begin() + inside.end,
                      uchar(area.strongThreshold));
    }
    cornerCount += dropScanCorners(out, area.blockWidth, foundCount, dropped.data());
    foundCount = out.foundCount;
}

// Whether the last scan found a strong corner in a range of columns.
bool FastScanner::hasStrong(const Range& range) const
{
    const int width = area.blockWidth;
    const int before = (range.start - blocks[0].x) / width;
    for (size_t i = size_t(std::max(before, 0)); i < blocks.size() && blocks[i].x < range.end; i++)
    {
        if (strong[i] & columnBits(blocks[i].x, width, range))
            return true;
    }
    return false;
}

static void appendAll(const CornerBlock* first, const CornerBlock* last, ScorePlane& plane,
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

// Writes the corners without a better corner within SUPPRESS_RADIUS, and returns their number.
static int writeUnsuppressed(const CornerBlock* first, int cornerCount, const uchar* scores, ptrdiff_t step,
                             Corner* corners)
{
    CV_CPU_DISPATCH(writeKept, (first, cornerCount, scores, step, corners), CV_CPU_DISPATCH_MODES_ALL);
}

void FastScanner::append(bool suppressNear, std::vector<Corner>& corners)
{
    int end = kept.nextRow - 1;
    if (end == area.bottom)
        plane.clearBelow(end);
    else
        end -= SUPPRESS_RADIUS;
    int taken = foundCount, left = 0;  // blocks to append now, and corners left for later
    while (taken > 0 && found[taken - 1].y >= end)
        left += bitCount(found[--taken].columns);
    const int count = cornerCount - left;
    if (!suppressNear)
    {
        appendAll(found.data(), found.data() + taken, plane, corners);
    }
    else if (count > 0)
    {
        // The kernel writes each corner before it tests it, hence one more element.
        growTo(unsuppressed, size_t(count) + 1);
        const int written =
            writeUnsuppressed(found.data(), count, plane.row(found[0].y), plane.step(), unsuppressed.data());
        // Lists of corners are long and live long, so they grow by small steps.
        const size_t size = corners.size() + size_t(written);
        if (size > corners.capacity())
            corners.reserve(size + size / 8);
        corners.insert(corners.end(), unsuppressed.data(), unsuppressed.data() + written);
    }
    std::copy(found.begin() + taken, found.begin() + foundCount, found.begin());
    foundCount -= taken;
    cornerCount = left;
}

static void neighborCornerScores(const uchar* p, ptrdiff_t step, int scores[3][3])
{
    CV_CPU_DISPATCH(neighborScores, (p, step, scores), CV_CPU_DISPATCH_MODES_ALL);
}

void cornerScores3x3(const Mat& image, int x, int y, int scores[3][3])
{
    const int REACH = 5;  // of the kernel
    NeighborhoodSpace space;
    const Neighborhood pixels = neighborhoodOf(image, x, y, REACH, space);
    neighborCornerScores(pixels.center, pixels.step, scores);
}

}  // namespace aqorb
}  // namespace cv
