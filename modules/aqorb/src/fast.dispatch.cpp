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

static int writeWantedCorners(const WeakCorners* weak, int count, FastScratch& scratch, Corner* corners)
{
    const ScanBlock* blocks = scratch.blocks.data();
    const uint64* wanted = scratch.wanted.data();
    const uchar* scores = scratch.rowOfScores(0);
    CV_CPU_DISPATCH(writeWanted, (weak, count, blocks, wanted, scores, scratch.scoreStep, corners),
                    CV_CPU_DISPATCH_MODES_ALL);
}

// The pixels of a block in a range of columns, a bit for each; none of them stands for a pixel before `first`.
static uint64 columnsOf(int x, int width, const Range& columns, int first)
{
    const int begin = std::max(std::max(columns.start, x), first), end = std::min(columns.end, x + width);
    return begin < end ? (~uint64(0) >> (64 - (end - begin))) << (begin - x) : 0;
}

// Covers columns, and one around, with blocks inside `pixels`.
static void coverWithBlocks(const Range& columns, const Range& pixels, int width,
                            std::vector<ScanBlock>& blocks)
{
    blocks.clear();
    const int end = std::min(columns.end + 1, pixels.end);
    for (int x = std::max(columns.start - 1, pixels.start), next; x < end; x = next)
    {
        // The last one may overlap.
        const int first = std::min(x, pixels.end - width);
        const ScanBlock block = {first, columnsOf(first, width, columns, x)};
        blocks.push_back(block);
        next = first + width;
    }
}

template <typename T> static void makeRoom(std::vector<T>& elements, size_t count)
{
    if (elements.size() < count)
        elements.resize(count);
}

// Room for the scores of rows of the image, each with a margin. The blocks' scores are aligned, but the last's.
static void layOutScores(int imageWidth, const Range& rows, FastScratch& scratch)
{
    const size_t rowBytes = alignSize(size_t(imageWidth) + 2 * SCAN_MARGIN, SCAN_ALIGNMENT);
    makeRoom(scratch.scores, (size_t(rows.size()) + 1) * rowBytes + 2 * SCAN_ALIGNMENT);
    const int first = scratch.blocks[0].x;
    uchar* aligned = alignPtr(scratch.scores.data() + SCAN_MARGIN + first, SCAN_ALIGNMENT);
    scratch.firstScore = aligned - first - scratch.scores.data();
    scratch.firstRow = rows.start;
    scratch.scoreStep = ptrdiff_t(rowBytes);
}

// How many corners a number of blocks may have.
static size_t mostCorners(size_t blocks, int width)
{
    return blocks * ((width + 1) / 2) + SCAN_OVERSHOOT;
}

void detectCorners(const Mat& image, const Rect& region, Thresholds thresholds, std::vector<Corner>& corners,
                   FastScratch& scratch)
{
    scratch.weakCount = scratch.weakTaken = 0;
    const int RADIUS = 3;  // of the circle
    const Rect pixels(RADIUS, RADIUS, image.cols - 2 * RADIUS, image.rows - 2 * RADIUS);
    const Rect wanted = region & pixels;
    if (pixels.width <= 0 || wanted.empty())
        return;

    int widths[2];
    widthsOfScan(widths);
    const int width = std::min(pixels.width, pixels.width >= widths[0] ? widths[0] : widths[1]);
    scratch.blockWidth = width;
    coverWithBlocks(Range(wanted.x, wanted.x + wanted.width), Range(pixels.x, pixels.x + pixels.width), width,
                    scratch.blocks);
    const size_t blockCount = scratch.blocks.size();
    layOutScores(image.cols, Range(wanted.y - 1, wanted.y + wanted.height + 1), scratch);
    makeRoom(scratch.listed, 2 * blockCount);
    makeRoom(scratch.weak, size_t(wanted.height) * blockCount + 1);
    const size_t ROWS = 4;  // that there is room for, whatever they hold
    makeRoom(scratch.found, ROWS * mostCorners(blockCount, width));

    FastScan scan;
    scan.image = image.ptr();
    scan.step = ptrdiff_t(image.step);
    scan.strongThreshold = std::min(std::max(thresholds.ini, 1), 255);  // as suppression needs scores > 0
    scan.threshold = std::min(std::max(thresholds.min, 1), scan.strongThreshold);
    scan.top = wanted.y;
    scan.bottom = wanted.y + wanted.height;
    scan.scoredTop = std::max(scan.top - 1, pixels.y);
    scan.scoredBottom = std::min(scan.bottom + 1, pixels.y + pixels.height);
    scan.left = pixels.x;
    scan.right = pixels.x + pixels.width;
    scan.y = scan.top - 1;
    scan.blocks = scratch.blocks.data();
    scan.blockCount = int(blockCount);
    scan.blockWidth = width;
    scan.scores = scratch.rowOfScores(scan.top - 1);
    scan.scoreStep = scratch.scoreStep;
    for (int i = 0; i < 2; i++)
    {
        scan.listed[i] = scratch.listed.data() + i * blockCount;
        scan.listedCount[i] = 0;
    }
    scan.weak = scratch.weak.data();
    scan.weakCount = 0;
    while (scan.y <= scan.bottom)
    {
        const int found = continueFastScan(scan, scratch.found.data(), int(scratch.found.size()));
        corners.insert(corners.end(), scratch.found.begin(), scratch.found.begin() + found);
    }
    scratch.weakCount = scan.weakCount;
}

void detectCorners(const Mat& image, const Rect& region, int threshold, std::vector<Corner>& corners)
{
    FastScratch scratch;
    const Thresholds thresholds = {threshold, threshold};
    detectCorners(image, region, thresholds, corners, scratch);
}

void takeWeakCorners(const Range& rows, const std::vector<Range>& columns, std::vector<Corner>& corners,
                     FastScratch& scratch)
{
    const int width = scratch.blockWidth;
    while (scratch.weakTaken < scratch.weakCount && scratch.weak[scratch.weakTaken].y < rows.start)
        scratch.weakTaken++;
    int end = scratch.weakTaken;
    while (end < scratch.weakCount && scratch.weak[end].y < rows.end)
        end++;
    if (end == scratch.weakTaken || columns.empty())
        return;

    scratch.wanted.assign(scratch.blocks.size(), 0);
    size_t run = 0;
    for (size_t i = 0; i < scratch.blocks.size(); i++)
    {
        const int x = scratch.blocks[i].x;
        while (run < columns.size() && columns[run].end <= x)
            run++;
        for (size_t j = run; j < columns.size() && columns[j].start < x + width; j++)
            scratch.wanted[i] |= columnsOf(x, width, columns[j], x);
    }
    const int atOnce = int(scratch.blocks.size());
    for (int next; scratch.weakTaken < end; scratch.weakTaken = next)
    {
        next = std::min(scratch.weakTaken + atOnce, end);
        const int found = writeWantedCorners(&scratch.weak[scratch.weakTaken], next - scratch.weakTaken,
                                             scratch, scratch.found.data());
        corners.insert(corners.end(), scratch.found.begin(), scratch.found.begin() + found);
    }
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
