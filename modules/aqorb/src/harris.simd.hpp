// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "harris.hpp"
#include "simd_compat.hpp"

namespace cv
{
namespace aqorb
{
namespace stages
{
CV_CPU_OPTIMIZATION_NAMESPACE_BEGIN

//! The harrisResponses of corners. The 3 pixels around each, and the 6 to its right, must be readable.
void harrisOfCorners(const uchar* image, ptrdiff_t step, const Corner* corners, int count,
                     RankedCorner* ranked);

#ifndef CV_CPU_OPTIMIZATION_DECLARATIONS_ONLY

namespace
{

// The sums over the 5x5 block of the products of the Sobel derivatives, as whole numbers.
struct BlockSums
{
    int xx, yy, xy, unused;
};

#if CV_AVX512_SKX && CV_SIMD_WIDTH == 64
#define AQORB_WIDE(name) _mm512_##name
const int AT_ONCE = 4;
typedef __m512i WideVector;
CV_ALWAYS_INLINE WideVector eachBytes(const uchar* const* p, ptrdiff_t offset)
{
    __m512i bytes = _mm512_broadcastq_epi64(_mm_loadl_epi64(reinterpret_cast<const __m128i*>(p[0] + offset)));
    for (int i = 1; i < AT_ONCE; i++)
        bytes = _mm512_mask_broadcastq_epi64(
            bytes, __mmask8(3 << (2 * i)), _mm_loadl_epi64(reinterpret_cast<const __m128i*>(p[i] + offset)));
    return bytes;
}
CV_ALWAYS_INLINE WideVector inEach(const __m128i& v)
{
    return _mm512_broadcast_i32x4(v);
}
CV_ALWAYS_INLINE WideVector both(const WideVector& a, const WideVector& b)
{
    return _mm512_and_si512(a, b);
}
#elif CV_AVX2 && CV_SIMD_WIDTH == 32
#define AQORB_WIDE(name) _mm256_##name
const int AT_ONCE = 2;
typedef __m256i WideVector;
CV_ALWAYS_INLINE WideVector eachBytes(const uchar* const* p, ptrdiff_t offset)
{
    return _mm256_inserti128_si256(
        _mm256_castsi128_si256(_mm_loadl_epi64(reinterpret_cast<const __m128i*>(p[0] + offset))),
        _mm_loadl_epi64(reinterpret_cast<const __m128i*>(p[1] + offset)), 1);
}
CV_ALWAYS_INLINE WideVector inEach(const __m128i& v)
{
    return _mm256_broadcastsi128_si256(v);
}
CV_ALWAYS_INLINE WideVector both(const WideVector& a, const WideVector& b)
{
    return _mm256_and_si256(a, b);
}
#endif

#if defined(AQORB_WIDE) || (CV_SIMD && CV_SIMD_WIDTH == 16)

// One row of the window of 7 x 7 pixels around each corner, in eight lanes for each corner. The first five lanes hold
// the horizontal difference and the horizontal smoothing, the others 0.
struct WindowRows
{
    v_int16 difference, smooth;
};

#ifdef AQORB_WIDE
// Loads eight pixels for each corner, the first at p + offset.
CV_ALWAYS_INLINE WindowRows loadRows(const uchar* const* p, ptrdiff_t offset)
{
    const WideVector bytes = eachBytes(p, offset);
    // Pairs of bytes, of which maddubs makes one lane each: left and middle, right and left.
    const WideVector leftMiddle = AQORB_WIDE(shuffle_epi8)(
        bytes, inEach(_mm_setr_epi8(0, 1, 1, 2, 2, 3, 3, 4, 4, 5, -1, -1, -1, -1, -1, -1)));
    const WideVector rightLeft = AQORB_WIDE(shuffle_epi8)(
        bytes, inEach(_mm_setr_epi8(2, 0, 3, 1, 4, 2, 5, 3, 6, 4, -1, -1, -1, -1, -1, -1)));
    WindowRows rows;
    rows.difference = v_int16(AQORB_WIDE(maddubs_epi16)(rightLeft, AQORB_WIDE(set1_epi16)(short(0xff01))));
    rows.smooth =
        v_int16(AQORB_WIDE(add_epi16)(AQORB_WIDE(maddubs_epi16)(leftMiddle, AQORB_WIDE(set1_epi16)(0x0201)),
                                      both(rightLeft, AQORB_WIDE(set1_epi16)(0x00ff))));
    return rows;
}

// Adds up the four lanes of each corner.
CV_ALWAYS_INLINE void addLanes(const v_int32& xx, const v_int32& yy, const v_int32& xy, BlockSums* sums)
{
    const WideVector x = AQORB_WIDE(add_epi32)(AQORB_WIDE(unpacklo_epi32)(xx.val, yy.val),
                                               AQORB_WIDE(unpackhi_epi32)(xx.val, yy.val));
    const WideVector y = AQORB_WIDE(add_epi32)(AQORB_WIDE(unpacklo_epi32)(xy.val, xy.val),
                                               AQORB_WIDE(unpackhi_epi32)(xy.val, xy.val));
    const WideVector all =
        AQORB_WIDE(add_epi32)(AQORB_WIDE(unpacklo_epi64)(x, y), AQORB_WIDE(unpackhi_epi64)(x, y));
    v_store(reinterpret_cast<int*>(sums), v_int32(all));
}
#undef AQORB_WIDE
#else
const int AT_ONCE = 1;
CV_ALWAYS_INLINE WindowRows loadRows(const uchar* const* p, ptrdiff_t offset)
{
    const uchar* q = p[0] + offset;
    const v_int16 left = v_reinterpret_as_s16(vx_load_expand(q));
    const v_int16 middle = v_reinterpret_as_s16(vx_load_expand(q + 1));
    const v_int16 right = v_reinterpret_as_s16(vx_load_expand(q + 2));
    const v_int16 inBlock(-1, -1, -1, -1, -1, 0, 0, 0);
    WindowRows rows;
    rows.difference = v_and(v_sub(right, left), inBlock);
    rows.smooth = v_and(v_add(v_add(left, right), v_add(middle, middle)), inBlock);
    return rows;
}
CV_ALWAYS_INLINE void addLanes(const v_int32& xx, const v_int32& yy, const v_int32& xy, BlockSums* sums)
{
    sums->xx = v_reduce_sum(xx);
    sums->yy = v_reduce_sum(yy);
    sums->xy = v_reduce_sum(xy);
}
#endif

void sumBlocks(const uchar* const* centers, ptrdiff_t step, BlockSums* sums)
{
    v_int32 xx = vx_setzero_s32(), yy = vx_setzero_s32(), xy = vx_setzero_s32();
    const ptrdiff_t first = -3 * step - 3;
    WindowRows above = loadRows(centers, first), rows = loadRows(centers, first + step);
    for (int i = 2; i < 7; i++)
    {
        const WindowRows below = loadRows(centers, first + i * step);
        const v_int16 Ix =
            v_add(v_add(above.difference, below.difference), v_add(rows.difference, rows.difference));
        const v_int16 Iy = v_sub(below.smooth, above.smooth);
        xx = v_dotprod_fast(Ix, Ix, xx);
        yy = v_dotprod_fast(Iy, Iy, yy);
        xy = v_dotprod_fast(Ix, Iy, xy);
        above = rows;
        rows = below;
    }
    addLanes(xx, yy, xy, sums);
}

#else

const int AT_ONCE = 1;

void sumBlocks(const uchar* const* centers, ptrdiff_t step, BlockSums* sums)
{
    BlockSums s = {0, 0, 0, 0};
    for (int dy = -2; dy <= 2; dy++)
    {
        for (int dx = -2; dx <= 2; dx++)
        {
            const uchar* q = centers[0] + dy * step + dx;
            const int Ix = (q[1] - q[-1]) * 2 + (q[-step + 1] - q[-step - 1]) + (q[step + 1] - q[step - 1]);
            const int Iy =
                (q[step] - q[-step]) * 2 + (q[step - 1] - q[-step - 1]) + (q[step + 1] - q[-step + 1]);
            s.xx += Ix * Ix;
            s.yy += Iy * Iy;
            s.xy += Ix * Iy;
        }
    }
    *sums = s;
}

#endif

CV_ALWAYS_INLINE float responseOf(int a, int b, int c)
{
    const float K = 0.04f, SCALE = 1.f / ((1 << 2) * 5 * 255.f);
    // These are the operations of cv::ORB in its order, as every rounding counts.
    return (float(a) * b - float(c) * c - K * (float(a) + b) * (float(a) + b)) *
           (SCALE * SCALE * SCALE * SCALE);
}

}  // namespace

void harrisOfCorners(const uchar* image, ptrdiff_t step, const Corner* corners, int count,
                     RankedCorner* ranked)
{
    for (int i = 0; i < count; i += AT_ONCE)
    {
        const uchar* centers[AT_ONCE];
        BlockSums sums[AT_ONCE];
        const int last = count - 1 - i;  // the last corner also fills the lanes that are left over
        for (int j = 0; j < AT_ONCE; j++)
        {
            const Corner& corner = corners[i + (j < last ? j : last)];
            centers[j] = image + corner.y * step + corner.x;
        }
        sumBlocks(centers, step, sums);
        for (int j = 0; j < AT_ONCE && j <= last; j++)
        {
            const RankedCorner corner = {corners[i + j].x, corners[i + j].y,
                                         responseOf(sums[j].xx, sums[j].yy, sums[j].xy)};
            ranked[i + j] = corner;
        }
    }
}

#endif  // CV_CPU_OPTIMIZATION_DECLARATIONS_ONLY

CV_CPU_OPTIMIZATION_NAMESPACE_END
}  // namespace stages
}  // namespace aqorb
}  // namespace cv
