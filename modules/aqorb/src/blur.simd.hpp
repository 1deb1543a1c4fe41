// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "blur.hpp"
#include "simd_compat.hpp"

#include <cmath>
#include <cstring>

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

namespace
{

// a * b + c, rounded once. The C library's function for this is slow where the processor has no such instruction, and in
// that of MinGW it rounds twice.
CV_ALWAYS_INLINE float multiplyAdd(float a, float b, float c)
{
#if defined(FP_FAST_FMAF) || defined(__FMA__) || defined(__ARM_FEATURE_FMA)
    return std::fma(a, b, c);
#else
    // The product of two floats is exact in a double. If the sum is not, its last bit is made odd on the side of what was
    // cut off, and then stands for it: the double has more than two bits more than twice those of a float, so it cannot
    // be taken for a number midway between two floats, nor for a float.
    const double product = double(a) * b, sum = product + c;
    const double added = sum - product, error = (product - (sum - added)) + (c - added);
    if (error == 0)
        return float(sum);
    int64 bits;
    std::memcpy(&bits, &sum, sizeof(bits));
    if (bits % 2 == 0)
        bits += (error > 0) == (sum > 0) ? 1 : -1;
    double odd;
    std::memcpy(&odd, &bits, sizeof(odd));
    return float(odd);
#endif
}

}  // namespace

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
        sum = multiplyAdd(taps[2], float(q[-2]), sum);
        sum = multiplyAdd(taps[1], float(q[-1]), sum);
        sum = multiplyAdd(taps[0], float(q[0]), sum);
        sum = multiplyAdd(taps[1], float(q[1]), sum);
        sum = multiplyAdd(taps[2], float(q[2]), sum);
        rows[i] = multiplyAdd(taps[3], float(q[3]), sum);
    }
#endif
    float sum = taps[0] * rows[3];
    sum = multiplyAdd(rows[4] + rows[2], taps[1], sum);
    sum = multiplyAdd(rows[5] + rows[1], taps[2], sum);
    sum = multiplyAdd(rows[6] + rows[0], taps[3], sum);
    return uchar(cvRound(sum));  // the taps add up to 1, so the sum needs no saturation
}

namespace
{

// The arithmetic of approximateBlur: on neighbouring pixels at once and, for narrow images, on one pixel.
#if CV_NEON
// NEON multiplies to 32 bits and adds in the same instruction, so a pass rounds down once, at its end. Hence the error is
// smaller than that of products of 16 bits, and the bounds hold all the more.
struct ManyPixels
{
    typedef v_uint16 V;
    static CV_ALWAYS_INLINE V all(ushort value) { return vx_setall_u16(value); }
    static CV_ALWAYS_INLINE void store(ushort* p, const V& a) { v_store(p, a); }
    static CV_ALWAYS_INLINE void loadRow(const uchar* p, V& center, V& pair1, V& pair2, V& pair3)
    {
        center = V(vshll_n_u8(vld1_u8(p), 2));
        pair1 = V(vaddl_u8(vld1_u8(p - 1), vld1_u8(p + 1)));
        pair2 = V(vaddl_u8(vld1_u8(p - 2), vld1_u8(p + 2)));
        pair3 = V(vaddl_u8(vld1_u8(p - 3), vld1_u8(p + 3)));
    }
    static CV_ALWAYS_INLINE V average(const V& a, const V& b) { return V(vrhaddq_u16(a.val, b.val)); }
    template <int SHIFT>
    static CV_ALWAYS_INLINE V weighted(const V& a0, const V& a1, const V& a2, const V& a3, const V& t0,
                                       const V& t1, const V& t2, const V& t3)
    {
        const uint32x4_t low = addLow(addLow(addLow(vdupq_n_u32(0), a0, t0), a1, t1), a2, t2);
        const uint32x4_t high = addHigh(addHigh(addHigh(vdupq_n_u32(0), a0, t0), a1, t1), a2, t2);
        return V(
            vcombine_u16(vshrn_n_u32(addLow(low, a3, t3), SHIFT), vshrn_n_u32(addHigh(high, a3, t3), SHIFT)));
    }

private:
    static CV_ALWAYS_INLINE uint32x4_t addLow(const uint32x4_t& sum, const V& a, const V& t)
    {
        return vmlal_u16(sum, vget_low_u16(a.val), vget_low_u16(t.val));
    }
    static CV_ALWAYS_INLINE uint32x4_t addHigh(const uint32x4_t& sum, const V& a, const V& t)
    {
#if defined(__aarch64__)
        return vmlal_high_u16(sum, a.val, t.val);
#else
        return vmlal_u16(sum, vget_high_u16(a.val), vget_high_u16(t.val));
#endif
    }
};
struct OnePixel
{
    typedef unsigned V;
    static CV_ALWAYS_INLINE V all(ushort value) { return value; }
    static CV_ALWAYS_INLINE void store(ushort* p, V a) { *p = ushort(a); }
    static CV_ALWAYS_INLINE void loadRow(const uchar* p, V& center, V& pair1, V& pair2, V& pair3)
    {
        center = V(p[0]) << 2;
        pair1 = V(p[-1] + p[1]);
        pair2 = V(p[-2] + p[2]);
        pair3 = V(p[-3] + p[3]);
    }
    static CV_ALWAYS_INLINE V average(V a, V b) { return (a + b + 1) >> 1; }
    template <int SHIFT> static CV_ALWAYS_INLINE V weighted(V a0, V a1, V a2, V a3, V t0, V t1, V t2, V t3)
    {
        return (a0 * t0 + a1 * t1 + a2 * t2 + a3 * t3) >> SHIFT;
    }
};
#else
#if CV_SIMD
struct ManyPixels
{
    typedef v_uint16 V;
    static CV_ALWAYS_INLINE V all(ushort value) { return vx_setall_u16(value); }
    static CV_ALWAYS_INLINE void store(ushort* p, const V& a) { v_store(p, a); }
    template <int>
    static CV_ALWAYS_INLINE V weighted(const V& a0, const V& a1, const V& a2, const V& a3, const V& t0,
                                       const V& t1, const V& t2, const V& t3)
    {
        return add(add(v_mul_hi(a0, t0), v_mul_hi(a1, t1)), add(v_mul_hi(a2, t2), v_mul_hi(a3, t3)));
    }
#if CV_AVX512_SKX && CV_SIMD_WIDTH == 64
#define AQORB_WIDE(name) _mm512_##name
    // The bytes from p - 3 on that the pixels of each eight lanes need, in 128 bits each.
    static CV_ALWAYS_INLINE __m512i eachBytes(const uchar* p)
    {
        const __m512i bytes = _mm512_maskz_loadu_epi8((uint64(1) << 38) - 1, p - 3);
        return _mm512_permutexvar_epi64(_mm512_setr_epi64(0, 1, 1, 2, 2, 3, 3, 4), bytes);
    }
    static CV_ALWAYS_INLINE __m512i inEach(const __m128i& v)
    {
        return _mm512_broadcast_i32x4(v);
    }
#elif CV_AVX2 && CV_SIMD_WIDTH == 32
#define AQORB_WIDE(name) _mm256_##name
    static CV_ALWAYS_INLINE __m256i eachBytes(const uchar* p)
    {
        // The upper ones are two bytes further up, because these are the last that are readable.
        const __m128i lower = _mm_loadu_si128(reinterpret_cast<const __m128i*>(p - 3));
        const __m128i upper = _mm_loadu_si128(reinterpret_cast<const __m128i*>(p + 3));
        return _mm256_inserti128_si256(_mm256_castsi128_si256(lower), upper, 1);
    }
    static CV_ALWAYS_INLINE __m256i inEach(const __m128i& bytes)
    {
        return _mm256_inserti128_si256(_mm256_castsi128_si256(bytes), _mm_add_epi8(bytes, _mm_set1_epi8(2)),
                                       1);
    }
#endif
#ifdef AQORB_WIDE
    // A shuffle makes pairs of bytes of the two pixels, and maddubs adds each pair up.
    static CV_ALWAYS_INLINE void loadRow(const uchar* p, V& center, V& pair1, V& pair2, V& pair3)
    {
        const char Z = -128;  // makes a zero
        const auto bytes = eachBytes(p);
        const auto sixtyFour = AQORB_WIDE(set1_epi8)(64);
        center = V(AQORB_WIDE(shuffle_epi8)(
            bytes, inEach(_mm_setr_epi8(Z, 3, Z, 4, Z, 5, Z, 6, Z, 7, Z, 8, Z, 9, Z, 10))));
        pair1 = V(AQORB_WIDE(maddubs_epi16)(
            AQORB_WIDE(shuffle_epi8)(bytes,
                                     inEach(_mm_setr_epi8(2, 4, 3, 5, 4, 6, 5, 7, 6, 8, 7, 9, 8, 10, 9, 11))),
            sixtyFour));
        pair2 = V(AQORB_WIDE(maddubs_epi16)(
            AQORB_WIDE(shuffle_epi8)(
                bytes, inEach(_mm_setr_epi8(1, 5, 2, 6, 3, 7, 4, 8, 5, 9, 6, 10, 7, 11, 8, 12))),
            sixtyFour));
        pair3 = V(AQORB_WIDE(maddubs_epi16)(
            AQORB_WIDE(shuffle_epi8)(
                bytes, inEach(_mm_setr_epi8(0, 6, 1, 7, 2, 8, 3, 9, 4, 10, 5, 11, 6, 12, 7, 13))),
            sixtyFour));
    }
#undef AQORB_WIDE
#else
    static CV_ALWAYS_INLINE void loadRow(const uchar* p, V& center, V& pair1, V& pair2, V& pair3)
    {
        center = v_shl<8>(vx_load_expand(p));
        pair1 = v_shl<6>(add(vx_load_expand(p - 1), vx_load_expand(p + 1)));
        pair2 = v_shl<6>(add(vx_load_expand(p - 2), vx_load_expand(p + 2)));
        pair3 = v_shl<6>(add(vx_load_expand(p - 3), vx_load_expand(p + 3)));
    }
#endif
    static CV_ALWAYS_INLINE V average(const V& a, const V& b)  // rounded up
    {
#if CV_AVX512_SKX && CV_SIMD_WIDTH == 64
        return v_uint16(_mm512_avg_epu16(a.val, b.val));
#elif CV_AVX2 && CV_SIMD_WIDTH == 32
        return v_uint16(_mm256_avg_epu16(a.val, b.val));
#elif CV_SSE2 && CV_SIMD_WIDTH == 16
        return v_uint16(_mm_avg_epu16(a.val, b.val));
#else
        return v_sub(v_or(a, b), v_shr<1>(v_xor(a, b)));
#endif
    }

private:
    // All sums fit into 16 bits.
    static CV_ALWAYS_INLINE V add(const V& a, const V& b)
    {
        return v_add_wrap(a, b);
    }
};
#endif
struct OnePixel
{
    typedef unsigned V;
    static CV_ALWAYS_INLINE V all(ushort value) { return value; }
    static CV_ALWAYS_INLINE void loadRow(const uchar* p, V& center, V& pair1, V& pair2, V& pair3)
    {
        center = V(p[0]) << 8;
        pair1 = V(p[-1] + p[1]) << 6;
        pair2 = V(p[-2] + p[2]) << 6;
        pair3 = V(p[-3] + p[3]) << 6;
    }
    static CV_ALWAYS_INLINE void store(ushort* p, V a) { *p = ushort(a); }
    static CV_ALWAYS_INLINE V average(V a, V b) { return (a + b + 1) >> 1; }
    template <int> static CV_ALWAYS_INLINE V weighted(V a0, V a1, V a2, V a3, V t0, V t1, V t2, V t3)
    {
        return ((a0 * t0) >> 16) + ((a1 * t1) >> 16) + ((a2 * t2) >> 16) + ((a3 * t3) >> 16);
    }
};
#endif

template <typename T> struct Taps
{
    typedef typename T::V V;
    explicit CV_ALWAYS_INLINE Taps(const ushort* taps)
        : t0(T::all(taps[0])), t1(T::all(taps[1])), t2(T::all(taps[2])), t3(T::all(taps[3]))
    {
    }
    CV_ALWAYS_INLINE V ofRow(const uchar* p) const
    {
        V center, pair1, pair2, pair3;
        T::loadRow(p, center, pair1, pair2, pair3);
        return T::template weighted<10>(center, pair1, pair2, pair3, t0, t1, t2, t3);
    }
    CV_ALWAYS_INLINE V ofColumn(const V& center, const V& mean1, const V& mean2, const V& mean3) const
    {
        return T::template weighted<16>(center, mean1, mean2, mean3, t0, t1, t2, t3);
    }
    V t0, t1, t2, t3;
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
        T::store(out, column.ofColumn(r3, T::average(r4, r2), T::average(r5, r1), T::average(r6, r0)));
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
