// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "corners.hpp"
#include "simd_compat.hpp"

namespace cv
{
namespace aqorb
{
CV_CPU_OPTIMIZATION_NAMESPACE_BEGIN

/** Writes the corners that have no better one within SUPPRESS_RADIUS.
 @param blocks those of the corners, and two more that are readable
 @param scores the scores of the row of the first block, by column, as in ScorePlane
 @param kept has space for all corners and one more
 @return number of corners kept */
int writeKept(const CornerBlock* blocks, int cornerCount, const uchar* scores, ptrdiff_t step, Corner* kept);

#ifndef CV_CPU_OPTIMIZATION_DECLARATIONS_ONLY

namespace
{

// Whether there is a better corner within SUPPRESS_RADIUS.
CV_ALWAYS_INLINE bool isSuppressed(const uchar* p, ptrdiff_t step)
{
    const int RADIUS = SUPPRESS_RADIUS;
#if CV_SIMD128
    // The highest scores of the pixels that come before p in raster order, and after it.
    const uchar* q = p - RADIUS;
    // Subtractions leave 0 outside of the window, and the next lower score where only a higher one counts.
    const v_uint8x16 ofRow(0, 0, 0, 255, 1, 1, 1, 255, 255, 255, 255, 255, 255, 255, 255, 255);
    const v_uint8x16 ofBefore(0, 0, 0, 0, 0, 0, 0, 255, 255, 255, 255, 255, 255, 255, 255, 255);
    const v_uint8x16 ofAfter(1, 1, 1, 1, 1, 1, 1, 255, 255, 255, 255, 255, 255, 255, 255, 255);
    const ptrdiff_t up = -step;
    const v_uint8x16 above = v_max(v_max(v_load(q + 3 * up), v_load(q + 2 * up)), v_load(q + up));
    const v_uint8x16 below = v_max(v_max(v_load(q + 3 * step), v_load(q + 2 * step)), v_load(q + step));
    const v_uint8x16 best =
        v_max(v_sub(v_load(q), ofRow), v_max(v_sub(above, ofBefore), v_sub(below, ofAfter)));
    const v_uint8x16 score = v_setall_u8(*p);
    return v_check_any(v_eq(v_min(best, score), score));
#else
    for (int y = -RADIUS; y <= RADIUS; y++)
    {
        for (int x = -RADIUS; x <= RADIUS; x++)
        {
            const bool isBefore = y < 0 || (y == 0 && x < 0);  // and so better with the same score, too
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
    // There are no branches, because it is hard to predict how many corners a block has and which of them are kept.
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
        next = blocks[1].columns;  // loaded ahead of its use
    }
    return int(out - kept);
}

#endif  // CV_CPU_OPTIMIZATION_DECLARATIONS_ONLY

CV_CPU_OPTIMIZATION_NAMESPACE_END
}  // namespace aqorb
}  // namespace cv
