// This file is part of the aqorb project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.

#include "precomp.hpp"

#include "fast.simd.hpp"
#include "fast.simd_declarations.hpp"

namespace cv
{
namespace aqorb
{
namespace stages
{

static int continueFastScan(FastScan& scan, Corner* corners, int capacity)
{
    CV_CPU_DISPATCH(continueScan, (scan, corners, capacity), CV_CPU_DISPATCH_MODES_ALL);
}

static void widthsOfScan(int widths[2])
{
    CV_CPU_DISPATCH(scanWidths, (widths), CV_CPU_DISPATCH_MODES_ALL);
}

// Covers runs of columns, and one column around each, with blocks inside `pixels`.
static void coverWithBlocks(const std::vector<Range>& columns, const Range& pixels, int width,
                            std::vector<ScanBlock>& blocks)
{
    blocks.clear();
    int covered = pixels.start;
    for (size_t i = 0; i < columns.size(); i++)
    {
        const Range& run = columns[i];
        const int end = std::min(run.end + 1, pixels.end);
        covered = std::max(covered, run.start - 1);
        while (covered < end)
        {
            // The last one may overlap.
            const ScanBlock block = {std::min(covered, pixels.end - width), 0};
            blocks.push_back(block);
            covered = block.x + width;
        }
    }
    size_t run = 0;
    covered = pixels.start;
    for (size_t i = 0; i < blocks.size(); i++)
    {
        ScanBlock& block = blocks[i];
        while (run < columns.size() && columns[run].end <= block.x)
            run++;
        for (size_t j = run; j < columns.size() && columns[j].start < block.x + width; j++)
        {
            const int first = std::max(std::max(columns[j].start, covered), block.x);
            const int last = std::min(columns[j].end, block.x + width) - 1;
            if (first <= last)
                block.wanted |= (~uint64(0) >> (63 - (last - first))) << (first - block.x);
        }
        covered = block.x + width;
    }
}

void detectCorners(const Mat& image, const Range& rows, const std::vector<Range>& columns, int threshold,
                   std::vector<Corner>& corners, FastScratch& scratch)
{
    const int RADIUS = 3;  // of the circle
    const Range hasCircleX(RADIUS, image.cols - RADIUS), hasCircleY(RADIUS, image.rows - RADIUS);
    const Range wanted(std::max(rows.start, hasCircleY.start), std::min(rows.end, hasCircleY.end));
    if (wanted.start >= wanted.end || hasCircleX.start >= hasCircleX.end)
        return;

    int widths[2];
    widthsOfScan(widths);
    FastScan scan;
    scan.blockWidth = hasCircleX.size() >= widths[0]   ? widths[0]
                      : hasCircleX.size() >= widths[1] ? widths[1]
                                                       : hasCircleX.size();
    coverWithBlocks(columns, hasCircleX, scan.blockWidth, scratch.blocks);
    const int blockCount = int(scratch.blocks.size());
    if (blockCount == 0)
        return;
    const size_t rowBytes = size_t(image.cols) + 2 * SCAN_MARGIN;
    if (scratch.scores.size() < 3 * rowBytes)
        scratch.scores.resize(3 * rowBytes);
    if (scratch.listed.size() < 3 * size_t(blockCount))
        scratch.listed.resize(3 * size_t(blockCount));

    scan.image = image.ptr();
    scan.step = ptrdiff_t(image.step);
    scan.threshold = std::min(std::max(threshold, 1), 255);  // as suppression needs scores > 0
    scan.top = wanted.start;
    scan.bottom = wanted.end;
    scan.scoredTop = std::max(wanted.start - 1, hasCircleY.start);
    scan.scoredBottom = std::min(wanted.end + 1, hasCircleY.end);
    scan.y = wanted.start - 1;
    scan.blocks = scratch.blocks.data();
    scan.blockCount = blockCount;
    for (int i = 0; i < 3; i++)
    {
        scan.scores[i] = scratch.scores.data() + i * rowBytes + SCAN_MARGIN;
        scan.listed[i] = scratch.listed.data() + i * size_t(blockCount);
        scan.listedCount[i] = 0;
        scan.scores[i][hasCircleX.start - 1] = scan.scores[i][hasCircleX.end] = 0;
    }

    const int ROWS = 4;  // that there is room for, whatever they hold
    const int capacity = ROWS * (blockCount * ((scan.blockWidth + 1) / 2) + SCAN_OVERSHOOT);
    if (scratch.found.size() < size_t(capacity))
        scratch.found.resize(capacity);
    while (scan.y <= scan.bottom)
    {
        const int found = continueFastScan(scan, scratch.found.data(), capacity);
        corners.insert(corners.end(), scratch.found.begin(), scratch.found.begin() + found);
    }
}

void detectCorners(const Mat& image, const Rect& region, int threshold, std::vector<Corner>& corners)
{
    FastScratch scratch;
    const int RADIUS = 3;
    const Rect wanted = region & Rect(RADIUS, RADIUS, image.cols - 2 * RADIUS, image.rows - 2 * RADIUS);
    if (wanted.empty())
        return;
    const std::vector<Range> columns(1, Range(wanted.x, wanted.x + wanted.width));
    detectCorners(image, Range(wanted.y, wanted.y + wanted.height), columns, threshold, corners, scratch);
}

int cornerScore(const uchar* p, size_t pixelStep)
{
    return cpu_baseline::scoreOfPixel(p, ptrdiff_t(pixelStep));
}

static void neighborCornerScores(const uchar* p, ptrdiff_t step, int scores[3][3])
{
    CV_CPU_DISPATCH(neighborScores, (p, step, scores), CV_CPU_DISPATCH_MODES_ALL);
}

void cornerScores3x3(const Mat& image, int x, int y, int scores[3][3])
{
    const int RADIUS = 4, LANES = 16;  // vectors read on to the right
    if (x >= RADIUS && y >= RADIUS && x + LANES + RADIUS < image.cols && y + RADIUS < image.rows)
    {
        neighborCornerScores(image.ptr(y) + x, ptrdiff_t(image.step), scores);
        return;
    }
    PatchBuffer buffer;
    const Patch patch = patchAround(image, x, y, RADIUS, buffer);
    for (int dy = -1; dy <= 1; dy++)
    {
        for (int dx = -1; dx <= 1; dx++)
            scores[dy + 1][dx + 1] = cornerScore(patch.center + dy * patch.step + dx, size_t(patch.step));
    }
}

}  // namespace stages
}  // namespace aqorb
}  // namespace cv
