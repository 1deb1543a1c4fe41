// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "blur.hpp"
#include "simd_compat.hpp"

#include <cmath>

namespace cv
{
namespace aqorb
{
namespace stages
{
CV_CPU_OPTIMIZATION_NAMESPACE_BEGIN

//! exactBlur at p, around which 4 pixels must be readable. The taps are those of the centre and of the pixels 1, 2 and
//! 3 off it.
uchar exactBlurAt(const uchar* p, ptrdiff_t step, const float* taps);

/** approximateBlur of a tile.
 @param source the first pixel of the tile; 3 pixels around the tile must be readable
 @param taps those of the row pass, then those of the column pass; of the centre and of the pixels 1, 2 and 3 off it */
void blurTile(const uchar* source, ptrdiff_t step, int width, int height, const ushort taps[2][4],
              ushort* blurred, ptrdiff_t blurredStep);

#ifndef CV_CPU_OPTIMIZATION_DECLARATIONS_ONLY

uchar exactBlurAt(const uchar* p, ptrdiff_t step, const float* taps)
{
    float rows[8];
#if CV_AVX2
    // The row pass for all seven rows at once, column by column.
    const uchar* q = p - 3 * step - 3;
    __m128i row[7];
    for (int i = 0; i < 7; i++)
        row[i] = _mm_loadl_epi64(reinterpret_cast<const __m128i*>(q + i * step));
    const __m128i rows01 = _mm_unpacklo_epi8(row[0], row[1]), rows23 = _mm_unpacklo_epi8(row[2], row[3]),
                  rows45 = _mm_unpacklo_epi8(row[4], row[5]),
                  row6 = _mm_unpacklo_epi8(row[6], _mm_setzero_si128());
    const __m128i upper03 = _mm_unpacklo_epi16(rows01, rows23), upper47 = _mm_unpackhi_epi16(rows01, rows23),
                  lower03 = _mm_unpacklo_epi16(rows45, row6), lower47 = _mm_unpackhi_epi16(rows45, row6);
    const __m128i columns[4] = {_mm_unpacklo_epi32(upper03, lower03), _mm_unpackhi_epi32(upper03, lower03),
                                _mm_unpacklo_epi32(upper47, lower47), _mm_unpackhi_epi32(upper47, lower47)};
    __m256 sums = _mm256_setzero_ps();
    for (int i = 0; i < 7; i++)
    {
        const __m128i column = i & 1 ? _mm_srli_si128(columns[i / 2], 8) : columns[i / 2];
        const __m256 pixels = _mm256_cvtepi32_ps(_mm256_cvtepu8_epi32(column));
        const __m256 tap = _mm256_set1_ps(taps[i < 3 ? 3 - i : i - 3]);
        sums = i == 0 ? _mm256_mul_ps(tap, pixels) : _mm256_fmadd_ps(tap, pixels, sums);
    }
    _mm256_storeu_ps(rows, sums);
#else
    for (int i = 0; i < 7; i++)
    {
        const uchar* q = p + (i - 3) * step;
        float sum = taps[3] * q[-3];
        sum = std::fma(taps[2], float(q[-2]), sum);
        sum = std::fma(taps[1], float(q[-1]), sum);
        sum = std::fma(taps[0], float(q[0]), sum);
        sum = std::fma(taps[1], float(q[1]), sum);
        sum = std::fma(taps[2], float(q[2]), sum);
        rows[i] = std::fma(taps[3], float(q[3]), sum);
    }
#endif
    float sum = taps[0] * rows[3];
    sum = std::fma(rows[4] + rows[2], taps[1], sum);
    sum = std::fma(rows[5] + rows[1], taps[2], sum);
    sum = std::fma(rows[6] + rows[0], taps[3], sum);
    return uchar(cvRound(sum));  // the taps add up to 1, so the sum needs no saturation
}

namespace
{

// The 16-bit arithmetic of approximateBlur: on neighbouring pixels at once and, for narrow images, on one pixel.
#if CV_SIMD
struct ManyPixels
{
    typedef v_uint16 V;
    static CV_ALWAYS_INLINE V all(ushort value) { return vx_setall_u16(value); }
    static CV_ALWAYS_INLINE V load(const uchar* p) { return vx_load_expand(p); }
    static CV_ALWAYS_INLINE void store(ushort* p, const V& a) { v_store(p, a); }
    static CV_ALWAYS_INLINE V add(const V& a, const V& b) { return v_add(a, b); }
    static CV_ALWAYS_INLINE V upperHalf(const V& a, const V& b) { return v_mul_hi(a, b); }
    template <int BITS> static CV_ALWAYS_INLINE V shifted(const V& a) { return v_shl<BITS>(a); }
    static CV_ALWAYS_INLINE V average(const V& a, const V& b)  // rounded up
    {
#if CV_AVX512_SKX && CV_SIMD_WIDTH == 64
        return v_uint16(_mm512_avg_epu16(a.val, b.val));
#elif CV_AVX2 && CV_SIMD_WIDTH == 32
        return v_uint16(_mm256_avg_epu16(a.val, b.val));
#elif CV_SSE2 && CV_SIMD_WIDTH == 16
        return v_uint16(_mm_avg_epu16(a.val, b.val));
#elif CV_NEON && CV_SIMD_WIDTH == 16
        return v_uint16(vrhaddq_u16(a.val, b.val));
#else
        return v_sub(v_or(a, b), v_shr<1>(v_xor(a, b)));
#endif
    }
};
#endif
struct OnePixel
{
    typedef unsigned V;
    static CV_ALWAYS_INLINE V all(ushort value) { return value; }
    static CV_ALWAYS_INLINE V load(const uchar* p) { return *p; }
    static CV_ALWAYS_INLINE void store(ushort* p, V a) { *p = ushort(a); }
    static CV_ALWAYS_INLINE V add(V a, V b) { return a + b; }
    static CV_ALWAYS_INLINE V upperHalf(V a, V b) { return (a * b) >> 16; }
    template <int BITS> static CV_ALWAYS_INLINE V shifted(V a) { return a << BITS; }
    static CV_ALWAYS_INLINE V average(V a, V b) { return (a + b + 1) >> 1; }
};

template <typename T> struct Taps
{
    explicit CV_ALWAYS_INLINE Taps(const ushort* taps)
        : t0(T::all(taps[0])),
          t1(T::all(taps[1])),
          t2(T::all(taps[2])),
          t3(T::all(taps[3])),
          center(T::all(2))
    {
    }
    typedef typename T::V V;
    CV_ALWAYS_INLINE V sum(const V& a0, const V& a1, const V& a2, const V& a3) const
    {
        return T::add(T::add(T::add(T::upperHalf(a0, t0), T::upperHalf(a1, t1)),
                             T::add(T::upperHalf(a2, t2), T::upperHalf(a3, t3))),
                      center);
    }
    CV_ALWAYS_INLINE V ofRow(const uchar* p) const
    {
        return sum(T::template shifted<8>(T::load(p)),
                   T::template shifted<6>(T::add(T::load(p - 1), T::load(p + 1))),
                   T::template shifted<6>(T::add(T::load(p - 2), T::load(p + 2))),
                   T::template shifted<6>(T::add(T::load(p - 3), T::load(p + 3))));
    }
    V t0, t1, t2, t3, center;
};

// Blurs a column of lanes from top to bottom, so that the seven rows it needs stay in registers.
template <typename T>
CV_ALWAYS_INLINE void blurColumn(const uchar* p, ptrdiff_t step, int height, const Taps<T>& row,
                                 const Taps<T>& column, ushort* out, ptrdiff_t outStep)
{
    typedef typename T::V V;
    V r0 = row.ofRow(p - 3 * step), r1 = row.ofRow(p - 2 * step), r2 = row.ofRow(p - step), r3 = row.ofRow(p),
      r4 = row.ofRow(p + step), r5 = row.ofRow(p + 2 * step);
    p += 3 * step;
    for (int y = 0; y < height; y++, p += step, out += outStep)
    {
        const V r6 = row.ofRow(p);
        T::store(out, column.sum(r3, T::average(r4, r2), T::average(r5, r1), T::average(r6, r0)));
        r0 = r1, r1 = r2, r2 = r3, r3 = r4, r4 = r5, r5 = r6;
    }
}

}  // namespace

void blurTile(const uchar* source, ptrdiff_t step, int width, int height, const ushort taps[2][4],
              ushort* blurred, ptrdiff_t blurredStep)
{
    int x = 0;
#if CV_SIMD
    const int LANES = AQORB_LANES(v_uint16);
    const Taps<ManyPixels> row(taps[0]), column(taps[1]);
    while (width >= LANES && x < width)
    {
        blurColumn(source + x, step, height, row, column, blurred + x, blurredStep);
        x = x + LANES == width       ? width
            : x + 2 * LANES <= width ? x + LANES
                                     : width - LANES;  // the last vector overlaps
    }
#endif
    const Taps<OnePixel> rowOfOne(taps[0]), columnOfOne(taps[1]);
    for (; x < width; x++)
        blurColumn(source + x, step, height, rowOfOne, columnOfOne, blurred + x, blurredStep);
}

#endif  // CV_CPU_OPTIMIZATION_DECLARATIONS_ONLY

CV_CPU_OPTIMIZATION_NAMESPACE_END
}  // namespace stages
}  // namespace aqorb
}  // namespace cv
