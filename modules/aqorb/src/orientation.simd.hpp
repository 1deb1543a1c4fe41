// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "orientation.hpp"
#include "simd_compat.hpp"

namespace cv
{
namespace aqorb
{
namespace stages
{
CV_CPU_OPTIMIZATION_NAMESPACE_BEGIN

/** The moments of a circular patch around pixels.
 @param inside the pixels around which all of the patch can be read: weights.radius pixels around them, and
 weights.width - weights.radius to their right. The moments around other pixels are left as they are. */
void momentsAround(const uchar* image, ptrdiff_t step, const PatchWeights& weights, const PatchRegion& inside,
                   const FeaturePoint* points, size_t count, Moments* moments);

#ifndef CV_CPU_OPTIMIZATION_DECLARATIONS_ONLY

namespace
{

#if CV_AVX2
CV_ALWAYS_INLINE __m256i loadBytes(const void* p)
{
    return _mm256_loadu_si256(static_cast<const __m256i*>(p));
}
#endif

inline void momentsAt(const uchar* center, ptrdiff_t step, const PatchWeights& weights, int& m10, int& m01)
{
    m10 = m01 = 0;
    // The rows above and below the middle one share their weights. The middle one comes first, alone.
    const uchar* const middle = center - weights.radius;
    int x = 0;
#if CV_SIMD
    const ptrdiff_t apart = weights.rowStep * step;
    const int rows = weights.radius / weights.rowStep;
#endif
#if CV_AVX2
    // Products of bytes. A pair of them is at most 2 * 31 * 255, so 16 bits hold the pairs of two rows.
    __m256i sum10 = _mm256_setzero_si256(), sum01 = sum10;
    const __m256i one = _mm256_set1_epi16(1);
    for (; x < weights.width; x += 32)
    {
        const uchar *above = middle + x, *below = above;
        const schar *wu = weights.u[0] + x, *wv = weights.v[0] + x;
        const __m256i ofMiddle = _mm256_maddubs_epi16(loadBytes(above), loadBytes(wu));
        sum10 = _mm256_add_epi32(sum10, _mm256_madd_epi16(ofMiddle, one));
        for (int row = 0; row < rows; row++)
        {
            above -= apart;
            below += apart;
            wu += weights.rowStep * PatchWeights::MAX_WIDTH;
            wv += weights.rowStep * PatchWeights::MAX_WIDTH;
            const __m256i a = loadBytes(above), b = loadBytes(below), u = loadBytes(wu), v = loadBytes(wv);
            const __m256i of10 = _mm256_add_epi16(_mm256_maddubs_epi16(a, u), _mm256_maddubs_epi16(b, u));
            const __m256i of01 = _mm256_sub_epi16(_mm256_maddubs_epi16(b, v), _mm256_maddubs_epi16(a, v));
            sum10 = _mm256_add_epi32(sum10, _mm256_madd_epi16(of10, one));
            sum01 = _mm256_add_epi32(sum01, _mm256_madd_epi16(of01, one));
        }
    }
    // The sums of both, side by side.
    __m256i both = _mm256_hadd_epi32(sum10, sum01);
    both = _mm256_hadd_epi32(both, both);
    const __m128i sums = _mm_add_epi32(_mm256_castsi256_si128(both), _mm256_extracti128_si256(both, 1));
    m10 = _mm_cvtsi128_si32(sums);
    m01 = _mm_extract_epi32(sums, 1);
#elif CV_SIMD
    const int LANES = AQORB_LANES(v_int16);
    v_int32 sum10 = vx_setzero_s32(), sum01 = vx_setzero_s32();
    for (; x < weights.width; x += LANES)
    {
        const uchar *above = middle + x, *below = above;
        const schar *wu = weights.u[0] + x, *wv = weights.v[0] + x;
        sum10 = v_dotprod_fast(v_reinterpret_as_s16(vx_load_expand(above)), vx_load_expand(wu), sum10);
        for (int row = 0; row < rows; row++)
        {
            above -= apart;
            below += apart;
            wu += weights.rowStep * PatchWeights::MAX_WIDTH;
            wv += weights.rowStep * PatchWeights::MAX_WIDTH;
            const v_int16 a = v_reinterpret_as_s16(vx_load_expand(above)),
                          b = v_reinterpret_as_s16(vx_load_expand(below));
            sum10 = v_dotprod_fast(v_add(a, b), vx_load_expand(wu), sum10);
            sum01 = v_dotprod_fast(v_sub(b, a), vx_load_expand(wv), sum01);
        }
    }
    m10 = v_reduce_sum(sum10);
    m01 = v_reduce_sum(sum01);
#endif
    for (; x < weights.width; x++)
    {
        m10 += middle[x] * weights.u[0][x];
        for (int v = weights.rowStep; v <= weights.radius; v += weights.rowStep)
        {
            const int above = middle[x - v * step], below = middle[x + v * step];
            m10 += (above + below) * weights.u[v][x];
            m01 += (below - above) * weights.v[v][x];
        }
    }
}

}  // namespace

void momentsAround(const uchar* image, ptrdiff_t step, const PatchWeights& weights, const PatchRegion& inside,
                   const FeaturePoint* points, size_t count, Moments* moments)
{
    for (size_t i = 0; i < count; i++)
    {
        const FeaturePoint& p = points[i];
        if (inside.left <= p.x && p.x < inside.right && inside.top <= p.y && p.y < inside.bottom)
            momentsAt(image + p.y * step + p.x, step, weights, moments[i].m10, moments[i].m01);
    }
}

#endif  // CV_CPU_OPTIMIZATION_DECLARATIONS_ONLY

CV_CPU_OPTIMIZATION_NAMESPACE_END
}  // namespace stages
}  // namespace aqorb
}  // namespace cv
