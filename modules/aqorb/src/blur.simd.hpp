// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// The exact blur of a pixel, and the approximate blur of columns of vectors.

#include "blur.hpp"
#include "simd_compat.hpp"

namespace cv
{
namespace aqorb
{
CV_CPU_OPTIMIZATION_NAMESPACE_BEGIN

/** The exact blur of a tile of BLUR_TILE_WIDTH columns, times 256.
 @param source as for blurTile
 @param taps of the centre, and of the pixels 1, 2 and 3 off it */
void exactTile(const uchar* source, ptrdiff_t step, int height, const float* taps, ushort* blurred,
               ptrdiff_t blurredStep);

//! exactBlur at p, around which 4 pixels must be readable. The taps are those of the centre and of the pixels 1, 2 and
//! 3 off it.
uchar exactBlurAt(const uchar* p, ptrdiff_t step, const float* taps);

/** approximateBlur of a tile of BLUR_TILE_WIDTH columns.
 @param source the first pixel of the tile; 3 pixels around the tile must be readable
 @param taps those of the row pass, then those of the column pass; of the centre and of the pixels 1, 2 and 3 off it */
void blurTile(const uchar* source, ptrdiff_t step, int height, const ushort taps[2][4], ushort* blurred,
              ptrdiff_t blurredStep);

#ifndef CV_CPU_OPTIMIZATION_DECLARATIONS_ONLY

namespace
{

CV_ALWAYS_INLINE float exactRow(const uchar* q, const float* taps)
{
    float sum = taps[3] * q[-3];
    sum = multiplyAdd(taps[2], float(q[-2]), sum);
    sum = multiplyAdd(taps[1], float(q[-1]), sum);
    sum = multiplyAdd(taps[0], float(q[0]), sum);
    sum = multiplyAdd(taps[1], float(q[1]), sum);
    sum = multiplyAdd(taps[2], float(q[2]), sum);
    return multiplyAdd(taps[3], float(q[3]), sum);
}

// Of seven rows `stride` elements apart, rounded.
CV_ALWAYS_INLINE int exactColumn(const float* rows, int stride, const float* taps)
{
    const float* const r = rows + 3 * stride;
    float sum = taps[0] * r[0];
    sum = multiplyAdd(r[stride] + r[-stride], taps[1], sum);
    sum = multiplyAdd(r[2 * stride] + r[-2 * stride], taps[2], sum);
    sum = multiplyAdd(r[3 * stride] + r[-3 * stride], taps[3], sum);
    // As cvRound, but compilers vectorize it: in this range floats are whole numbers. The taps add up to 1, so the sum
    // needs no saturation.
    const float WHOLE = 12582912.f;  // 1.5 * 2^23
    return int((sum + WHOLE) - WHOLE);
}

}  // namespace

void exactTile(const uchar* source, ptrdiff_t step, int height, const float* taps, ushort* blurred,
               ptrdiff_t blurredStep)
{
    const int WIDTH = BLUR_TILE_WIDTH, ROWS = 32;  // at once
    CV_DECL_ALIGNED(CACHE_LINE) float rows[(ROWS + 6) * WIDTH];
    const float t[] = {taps[0], taps[1], taps[2], taps[3]};
    for (int top = 0; top < height; top += ROWS)
    {
        const int count = height - top < ROWS ? height - top : ROWS;
        for (int y = 0; y < count + 6; y++)
            for (int x = 0; x < WIDTH; x++)
                rows[y * WIDTH + x] = exactRow(source + (top + y - 3) * step + x, t);
        for (int y = 0; y < count; y++)
            for (int x = 0; x < WIDTH; x++)
                blurred[(top + y) * blurredStep + x] =
                    ushort(exactColumn(rows + y * WIDTH + x, WIDTH, t) << 8);
    }
}

uchar exactBlurAt(const uchar* p, ptrdiff_t step, const float* taps)
{
    float rows[8];
    for (int i = 0; i < 7; i++)
        rows[i] = exactRow(p + (i - 3) * step, taps);
    return uchar(exactColumn(rows, 1, taps));
}

namespace
{

// The arithmetic of approximateBlur: on neighbouring pixels at once or, without vectors, on one. All sums fit into
// 16 bits.
#if CV_SIMD
typedef v_uint16 Pixels;
#else
typedef unsigned Pixels;
#endif

CV_ALWAYS_INLINE Pixels allPixels(ushort value)
{
#if CV_SIMD
    return vx_setall_u16(value);
#else
    return value;
#endif
}

CV_ALWAYS_INLINE void storePixels(ushort* p, const Pixels& a)
{
#if CV_SIMD
    v_store(p, a);
#else
    *p = ushort(a);
#endif
}

// The operands of the taps: a pixel, and the sums of the pairs of pixels 1, 2 and 3 off it.
struct Weighed
{
    Pixels of[4];
};

// Loads pixels of a row times 256 and the sums of their pairs times 64.
CV_ALWAYS_INLINE Weighed loadRow(const uchar* p)
{
    Weighed row;
#if CV_SIMD
    row.of[0] = v_shl<8>(vx_load_expand(p));
    row.of[1] = v_shl<6>(v_add_wrap(vx_load_expand(p - 1), vx_load_expand(p + 1)));
    row.of[2] = v_shl<6>(v_add_wrap(vx_load_expand(p - 2), vx_load_expand(p + 2)));
    row.of[3] = v_shl<6>(v_add_wrap(vx_load_expand(p - 3), vx_load_expand(p + 3)));
#else
    row.of[0] = Pixels(p[0]) << 8;
    row.of[1] = Pixels(p[-1] + p[1]) << 6;
    row.of[2] = Pixels(p[-2] + p[2]) << 6;
    row.of[3] = Pixels(p[-3] + p[3]) << 6;
#endif
    return row;
}

CV_ALWAYS_INLINE Pixels weightedSum(const Weighed& a, const Weighed& taps)
{
#if CV_SIMD
    return v_add_wrap(v_add_wrap(v_mul_hi(a.of[0], taps.of[0]), v_mul_hi(a.of[1], taps.of[1])),
                      v_add_wrap(v_mul_hi(a.of[2], taps.of[2]), v_mul_hi(a.of[3], taps.of[3])));
#else
    return ((a.of[0] * taps.of[0]) >> 16) + ((a.of[1] * taps.of[1]) >> 16) + ((a.of[2] * taps.of[2]) >> 16) +
           ((a.of[3] * taps.of[3]) >> 16);
#endif
}

CV_ALWAYS_INLINE Weighed allTaps(const ushort* taps)
{
    return {{allPixels(taps[0]), allPixels(taps[1]), allPixels(taps[2]), allPixels(taps[3])}};
}

// Blurs a column of lanes from top to bottom, so that the seven rows it needs stay in registers.
CV_ALWAYS_INLINE void blurColumn(const uchar* p, ptrdiff_t step, int height, const Weighed& rowTaps,
                                 const Weighed& columnTaps, ushort* out, ptrdiff_t outStep)
{
    const auto row = [&](int y) { return weightedSum(loadRow(p + y * step), rowTaps); };
    Pixels r0 = row(-3), r1 = row(-2), r2 = row(-1), r3 = row(0), r4 = row(1), r5 = row(2);
    for (int y = 0; y < height; y++, p += step, out += outStep)
    {
        const Pixels r6 = row(3);
        const Weighed column = {{r3, average(r4, r2), average(r5, r1), average(r6, r0)}};
        storePixels(out, weightedSum(column, columnTaps));
        r0 = r1, r1 = r2, r2 = r3, r3 = r4, r4 = r5, r5 = r6;
    }
}

}  // namespace

void blurTile(const uchar* source, ptrdiff_t step, int height, const ushort taps[2][4], ushort* blurred,
              ptrdiff_t blurredStep)
{
    const int PIXELS = CV_SIMD ? int(sizeof(Pixels) / sizeof(ushort)) : 1;
    const Weighed rowTaps = allTaps(taps[0]), columnTaps = allTaps(taps[1]);
    for (int x = 0; x < BLUR_TILE_WIDTH; x += PIXELS)
        blurColumn(source + x, step, height, rowTaps, columnTaps, blurred + x, blurredStep);
}

#endif  // CV_CPU_OPTIMIZATION_DECLARATIONS_ONLY

CV_CPU_OPTIMIZATION_NAMESPACE_END
}  // namespace aqorb
}  // namespace cv
