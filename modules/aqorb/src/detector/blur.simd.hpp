// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// Kernels of the exact and the approximate blur.

#include "detector/blur.hpp"
#include "common/simd_compat.hpp"

namespace cv
{
namespace aqorb
{
CV_CPU_OPTIMIZATION_NAMESPACE_BEGIN

/** Blurs a tile of BLUR_TILE_WIDTH columns exactly, times 256.
 @param source as for blurTile
 @param taps weights at distances 0 to 3 */
void exactTile(const uchar* source, ptrdiff_t step, int height, const float* taps, ushort* blurred,
               ptrdiff_t blurredStep);

//! exactBlur at p. The 4 pixels around p must be readable.
//! @param taps weights at distances 0 to 3
uchar exactBlurAt(const uchar* p, ptrdiff_t step, const float* taps);

/** Blurs a tile of BLUR_TILE_WIDTH columns approximately.
 @param source first pixel of the tile; the 3 pixels around the tile must be readable
 @param taps weights of the row pass and of the column pass, at distances 0 to 3 */
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

// Weighted sum of seven rows `stride` elements apart, rounded.
CV_ALWAYS_INLINE int exactColumn(const float* rows, int stride, const float* taps)
{
    const float* const r = rows + 3 * stride;
    float sum = taps[0] * r[0];
    sum = multiplyAdd(r[stride] + r[-stride], taps[1], sum);
    sum = multiplyAdd(r[2 * stride] + r[-2 * stride], taps[2], sum);
    sum = multiplyAdd(r[3 * stride] + r[-3 * stride], taps[3], sum);
    // Rounds as cvRound does, in a form that compilers vectorize: floats from 2^23 to 2^24 are whole numbers. The taps
    // add up to 1, so the sum needs no saturation.
    const float WHOLE = 12582912.f;  // 1.5 * 2^23
    return int((sum + WHOLE) - WHOLE);
}

}  // namespace

void exactTile(const uchar* source, ptrdiff_t step, int height, const float* taps, ushort* blurred,
               ptrdiff_t blurredStep)
{
    const int WIDTH = BLUR_TILE_WIDTH, ROWS = 32;  // per pass
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
#if CV_SIMD128 && (CV_FMA3 || (CV_NEON && defined(__aarch64__)))
    // A lane for each of eight rows. Three perfect shuffles transpose 8 x 8 pixels: a vector holds two columns.
    v_uint8x16 columns[4], shuffled[4];
    for (int i = 0; i < 4; i++)
        columns[i] = v_load_halves(p + (2 * i - 3) * step - 3, p + (2 * i - 2) * step - 3);
    for (int i = 0; i < 3; i++)
    {
        v_zip(columns[0], columns[2], shuffled[0], shuffled[1]);
        v_zip(columns[1], columns[3], shuffled[2], shuffled[3]);
        for (int j = 0; j < 4; j++)
            columns[j] = shuffled[j];
    }
    v_float32x4 upper = v_setzero_f32(), lower = v_setzero_f32();
    for (int i = 0; i < 7; i++)
    {
        const v_float32x4 tap = v_setall_f32(taps[i < 3 ? 3 - i : i - 3]);
        const v_uint16x8 column = i % 2 ? v_expand_high(columns[i / 2]) : v_expand_low(columns[i / 2]);
        upper = v_fma(v_cvt_f32(v_reinterpret_as_s32(v_expand_low(column))), tap, upper);
        lower = v_fma(v_cvt_f32(v_reinterpret_as_s32(v_expand_high(column))), tap, lower);
    }
    v_store(rows, upper);
    v_store(rows + 4, lower);
#else
    for (int i = 0; i < 7; i++)
        rows[i] = exactRow(p + (i - 3) * step, taps);
#endif
    return uchar(exactColumn(rows, 1, taps));
}

namespace
{

// Arithmetic of approximateBlur on a vector of neighbouring pixels or, without SIMD, on one pixel. All sums fit into
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

// One operand for each tap: the centre pixel, and sums of the two pixels at distances 1, 2 and 3.
struct Weighed
{
    Pixels terms[4];
};

// Loads pixels of a row times 256, and sums of pairs times 64.
CV_ALWAYS_INLINE Weighed loadRow(const uchar* p)
{
    Weighed row;
#if CV_SIMD
    row.terms[0] = v_shl<8>(vx_load_expand(p));
    row.terms[1] = v_shl<6>(v_add_wrap(vx_load_expand(p - 1), vx_load_expand(p + 1)));
    row.terms[2] = v_shl<6>(v_add_wrap(vx_load_expand(p - 2), vx_load_expand(p + 2)));
    row.terms[3] = v_shl<6>(v_add_wrap(vx_load_expand(p - 3), vx_load_expand(p + 3)));
#else
    row.terms[0] = Pixels(p[0]) << 8;
    row.terms[1] = Pixels(p[-1] + p[1]) << 6;
    row.terms[2] = Pixels(p[-2] + p[2]) << 6;
    row.terms[3] = Pixels(p[-3] + p[3]) << 6;
#endif
    return row;
}

CV_ALWAYS_INLINE Pixels weightedSum(const Weighed& a, const Weighed& taps)
{
#if CV_SIMD
    return v_add_wrap(v_add_wrap(v_mul_hi(a.terms[0], taps.terms[0]), v_mul_hi(a.terms[1], taps.terms[1])),
                      v_add_wrap(v_mul_hi(a.terms[2], taps.terms[2]), v_mul_hi(a.terms[3], taps.terms[3])));
#else
    return ((a.terms[0] * taps.terms[0]) >> 16) + ((a.terms[1] * taps.terms[1]) >> 16) +
           ((a.terms[2] * taps.terms[2]) >> 16) + ((a.terms[3] * taps.terms[3]) >> 16);
#endif
}

CV_ALWAYS_INLINE Weighed allTaps(const ushort* taps)
{
    return {{allPixels(taps[0]), allPixels(taps[1]), allPixels(taps[2]), allPixels(taps[3])}};
}

// Blurs a column of lanes from top to bottom: the seven input rows stay in registers.
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
