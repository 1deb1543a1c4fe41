// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// Kernels of the scan: scores of rows, their corners, and non-maximum suppression.

#include "detector/fast.hpp"
#ifndef CV_CPU_OPTIMIZATION_DECLARATIONS_ONLY
#include "detector/fast_score.hpp"
#endif

#include <cstring>

namespace cv
{
namespace aqorb
{

CV_CPU_OPTIMIZATION_NAMESPACE_BEGIN

//! Pixels per block in an image with `columns` columns whose circles lie inside: a wide vector, a narrow vector, or
//! one pixel.
int blockWidthFor(int columns);

//! Continues a scan up to row `end`, exclusive and at most area.bottom.
void continueScan(const ScanArea& area, ScanScores& kept, ScanCorners& corners, int end);

/** Removes corners of low score from corners.found and from the score plane.
 @param first first block to examine
 @param dropped highest score to remove, by column
 @return number of corners left; corners.foundCount becomes the number of blocks that still have corners */
int dropCorners(ScanCorners& corners, int blockWidth, int first, const uchar* dropped);

//! cornerScores3x3 at p. The 5 pixels around p must be readable.
void neighborScores(const uchar* p, ptrdiff_t step, int scores[3][3]);

/** Writes the corners without a better corner within SUPPRESS_RADIUS.
 @param blocks blocks of the corners, and two more readable blocks
 @param scores row of the first block in the score plane
 @param kept room for all corners and one more
 @return number of corners written */
int writeKept(const CornerBlock* blocks, int cornerCount, const uchar* scores, ptrdiff_t step, Corner* kept);

#ifndef CV_CPU_OPTIMIZATION_DECLARATIONS_ONLY

namespace
{

CV_ALWAYS_INLINE uchar* scoresOf(const ScanScores& kept, int y)
{
    return kept.rows + (y & (SCAN_ROWS - 1)) * kept.step;
}

// Scores the blocks of a row: a FAST score above the threshold, 1 to 255, else 0. Lists the blocks that have a score
// and returns their number.
template <typename Vectors> int scoreRow(const ScanArea& area, const ScanScores& kept, int y)
{
    typedef typename Vectors::V V;
    const uchar* row = area.image + y * area.step;
    const ptrdiff_t step = area.step;
    uchar* scores = scoresOf(kept, y);
    int* list = kept.listed[y & 1];
    const V zero = Vectors::all(0), limit = Vectors::all(area.threshold);
    int possible = 0, count = 0;
    // Each arc contains one end of both axes of the circle, so these four pixels rule out most blocks. If most blocks
    // of the row above have a corner, the test would cost more than it saves.
    const bool skipTest = 4 * kept.listedCount[(y - 1) & 1] > 3 * area.blockCount;
    const ScanBlock* const blocks = area.blocks;
    const int blockCount = area.blockCount;
    for (int i = 0; i < blockCount; i++)
    {
        list[possible] = i;
        if (skipTest)
        {
            possible++;
            continue;
        }
        const int x = blocks[i].x;
        const uchar* p = row + x;
        const V v = Vectors::load(p), up = Vectors::load(p - 3 * step), down = Vectors::load(p + 3 * step),
                left = Vectors::load(p - 3), right = Vectors::load(p + 3);
        // Stored last: after an earlier store compilers load the pixels again.
        Vectors::store(scores + x, zero);
        const V bright = Min::of(Max::of(up, down), Max::of(left, right));
        const V dark = Max::of(Min::of(up, down), Min::of(left, right));
        const V bound = Max::of(Vectors::above(bright, v), Vectors::above(v, dark));
        possible += Vectors::anyGreater(bound, limit);
    }
    for (int i = 0; i < possible; i++)
    {
        const int x = blocks[list[i]].x;
        const uchar* p = row + x;
        const Extremes<Vectors> best = bestArc(Circle<Vectors>(p, step));
        const V v = Vectors::load(p);
        const V score = Max::of(Vectors::above(best.darkest, v), Vectors::above(v, best.brightest));
        list[count] = list[i];
        count += Vectors::storeGreater(scores + x, score, limit) != 0;
    }
    return count;
}

// Finds the corners of a row: pixels with a higher score than their eight neighbours. Writes their scores to the score
// plane and their blocks to out.found.
template <typename Vectors>
void suppressRow(const ScanArea& area, const ScanScores& kept, ScanCorners& out, int y)
{
    typedef typename Vectors::V V;
    const uchar *scores = scoresOf(kept, y), *above = scoresOf(kept, y - 1), *below = scoresOf(kept, y + 1);
    uchar* corners = out.plane + (y - out.planeTop) * out.planeStep;
    const int end = area.blocks[area.blockCount - 1].x + area.blockWidth;
    std::memset(corners + area.blocks[0].x - SUPPRESS_MARGIN, 0,
                end - area.blocks[0].x + 2 * SUPPRESS_MARGIN);
    const int* const listed = kept.listed[y & 1];
    const int listedCount = kept.listedCount[y & 1];
    const ScanBlock* const blocks = area.blocks;
    uint64* const strong = out.strong;
    const uchar* const mask = area.mask ? area.mask + y * area.maskStep : 0;
    const V strongest = Vectors::all(area.strongThreshold);
    CornerBlock* found = out.found + out.foundCount;
    for (int i = 0; i < listedCount; i++)
    {
        const ScanBlock& block = blocks[listed[i]];
        const int x = block.x;
        const uchar *s = scores + x, *u = above + x, *d = below + x;
        const V score = Vectors::load(s);
        const V over = Max::of(Max::of(Vectors::load(u - 1), Vectors::load(u)), Vectors::load(u + 1));
        V under = Max::of(Max::of(Vectors::load(d - 1), Vectors::load(d)), Vectors::load(d + 1));
        if (mask)
            under = Max::of(under, Vectors::whereZero(Vectors::load(mask + x)));
        const V beside = Max::of(Vectors::load(s - 1), Vectors::load(s + 1));
        const uint64 columns =
            Vectors::storeGreater(corners + x, score, Max::of(Max::of(over, under), beside));
        strong[listed[i]] |= columns & Vectors::maskGreater(score, strongest);
        // The plane also has corners outside the wanted columns. dropCorners clears these.
        found->x = x;
        found->y = y;
        found->columns = columns & block.wanted;
        found += columns != 0;
    }
    out.foundCount = int(found - out.found);
}

template <typename Vectors>
void scanRows(const ScanArea& area, ScanScores& kept, ScanCorners& corners, int end)
{
    // Columns and rows where the circle lies inside the image.
    const int left = FAST_RADIUS, right = area.width - FAST_RADIUS, bottom = area.height - FAST_RADIUS;
    for (; kept.nextRow <= end; kept.nextRow++)
    {
        const int y = kept.nextRow;
        const bool isScored = y >= FAST_RADIUS && y < bottom;
        uchar* const scores = scoresOf(kept, y);
        scores[left - 1] = scores[right] = 0;
        if (!isScored)
            std::memset(scores + left, 0, right - left);
        kept.listedCount[y & 1] = isScored ? scoreRow<Vectors>(area, kept, y) : 0;
        if (y > area.top)
            suppressRow<Vectors>(area, kept, corners, y - 1);
    }
}

template <typename Vectors> int dropFromBlocks(ScanCorners& out, int first, const uchar* dropped)
{
    CornerBlock* left = out.found + first;
    int corners = 0;
    for (int i = first; i < out.foundCount; i++)
    {
        CornerBlock block = out.found[i];
        uchar* scores = out.plane + (block.y - out.planeTop) * out.planeStep + block.x;
        block.columns &=
            Vectors::storeGreater(scores, Vectors::load(scores), Vectors::load(dropped + block.x));
        corners += bitCount(block.columns);
        *left = block;
        left += block.columns != 0;
    }
    out.foundCount = int(left - out.found);
    return corners;
}

}  // namespace

int blockWidthFor(int columns)
{
    return columns >= Wide::count() ? Wide::count() : columns >= Narrow::count() ? Narrow::count() : 1;
}

void continueScan(const ScanArea& area, ScanScores& kept, ScanCorners& corners, int end)
{
    if (area.blockWidth == Wide::count())
        scanRows<Wide>(area, kept, corners, end);
    else if (area.blockWidth == Narrow::count())
        scanRows<Narrow>(area, kept, corners, end);
    else
        scanRows<Single>(area, kept, corners, end);
}

int dropCorners(ScanCorners& corners, int blockWidth, int first, const uchar* dropped)
{
    return blockWidth == Wide::count()     ? dropFromBlocks<Wide>(corners, first, dropped)
           : blockWidth == Narrow::count() ? dropFromBlocks<Narrow>(corners, first, dropped)
                                           : dropFromBlocks<Single>(corners, first, dropped);
}

void neighborScores(const uchar* p, ptrdiff_t step, int scores[3][3])
{
    const uchar* const q = p - step - 1;
#if CV_SIMD
    const Extremes<Narrow> best = bestArc(ThreeRows(q, step));
    uchar darkest[16], brightest[16];
    Narrow::store(darkest, best.darkest);
    Narrow::store(brightest, best.brightest);
#endif
    for (int row = 0; row < 3; row++)
    {
        for (int i = 0; i < 3; i++)
        {
            const uchar* const pixel = q + row * step + i;
#if CV_SIMD
            const int dark = darkest[4 * row + i], bright = brightest[4 * row + i];
#else
            const Extremes<Single> best = bestArc(Circle<Single>(pixel, step));
            const int dark = best.darkest, bright = best.brightest;
#endif
            scores[row][i] = Max::of(dark - *pixel, *pixel - bright);
        }
    }
}

namespace
{

// Whether a better corner lies within SUPPRESS_RADIUS.
CV_ALWAYS_INLINE bool isSuppressed(const uchar* p, ptrdiff_t step)
{
    const int RADIUS = SUPPRESS_RADIUS;
#if CV_SIMD128
    const uchar* q = p - RADIUS;
    // Saturating subtraction of 255 clears lanes outside the window. Subtraction of 1 makes equal scores lose: pixels
    // after p in raster order suppress it only by a higher score.
    const v_uint8x16 rowOffsets(0, 0, 0, 255, 1, 1, 1, 255, 255, 255, 255, 255, 255, 255, 255, 255);
    const v_uint8x16 aboveOffsets(0, 0, 0, 0, 0, 0, 0, 255, 255, 255, 255, 255, 255, 255, 255, 255);
    const v_uint8x16 belowOffsets(1, 1, 1, 1, 1, 1, 1, 255, 255, 255, 255, 255, 255, 255, 255, 255);
    const ptrdiff_t up = -step;
    const v_uint8x16 above = v_max(v_max(v_load(q + 3 * up), v_load(q + 2 * up)), v_load(q + up));
    const v_uint8x16 below = v_max(v_max(v_load(q + 3 * step), v_load(q + 2 * step)), v_load(q + step));
    const v_uint8x16 best =
        v_max(v_sub(v_load(q), rowOffsets), v_max(v_sub(above, aboveOffsets), v_sub(below, belowOffsets)));
    const v_uint8x16 score = v_setall_u8(*p);
    return v_check_any(v_eq(v_min(best, score), score));
#else
    for (int y = -RADIUS; y <= RADIUS; y++)
    {
        for (int x = -RADIUS; x <= RADIUS; x++)
        {
            const bool isBefore = y < 0 || (y == 0 && x < 0);  // better even at the same score
            if (p[y * step + x] > *p - isBefore)
                return true;
        }
    }
    return false;
#endif
}

}  // namespace

int writeKept(const CornerBlock* blocks, int cornerCount, const uchar* scores, ptrdiff_t step, Corner* kept)
{
    const int top = blocks->y;
    uint64 columns = blocks[0].columns, next = blocks[1].columns;
    Corner* out = kept;
    // No branches: the CPU can predict neither the number of corners in a block nor their suppression.
    for (int i = 0; i < cornerCount; i++)
    {
        const int x = blocks->x + trailingZeros(columns), y = blocks->y;
        const uchar* p = scores + (y - top) * step + x;
        *out = {x, y, *p - 1};
        out += !isSuppressed(p, step);
        columns &= columns - 1;
        const bool wasLast = columns == 0;
        columns |= next & (uint64(0) - wasLast);
        blocks += wasLast;
        next = blocks[1].columns;  // loaded early, to hide the latency
    }
    return int(out - kept);
}

#endif  // CV_CPU_OPTIMIZATION_DECLARATIONS_ONLY

CV_CPU_OPTIMIZATION_NAMESPACE_END

}  // namespace aqorb
}  // namespace cv
