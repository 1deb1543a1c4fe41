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

typedef __m256i Row;  // pixels or weights
typedef __m256i Sums;

CV_ALWAYS_INLINE int lanesOfRow()
{
    return 32;
}
CV_ALWAYS_INLINE Row loadRow(const void* p)
{
    return _mm256_loadu_si256(static_cast<const __m256i*>(p));
}
CV_ALWAYS_INLINE Row emptyRow()
{
    return _mm256_setzero_si256();
}
CV_ALWAYS_INLINE Sums noSums()
{
    return _mm256_setzero_si256();
}
// Products of bytes. A pair of them is at most 2 * 31 * 255, so 16 bits hold the pairs of two rows.
CV_ALWAYS_INLINE void add(const Row& above, const Row& below, const Row& u, const Row& v, Sums& sum10,
                          Sums& sum01)
{
    const __m256i one = _mm256_set1_epi16(1);
    const __m256i of10 = _mm256_add_epi16(_mm256_maddubs_epi16(above, u), _mm256_maddubs_epi16(below, u));
    const __m256i of01 = _mm256_sub_epi16(_mm256_maddubs_epi16(below, v), _mm256_maddubs_epi16(above, v));
    sum10 = _mm256_add_epi32(sum10, _mm256_madd_epi16(of10, one));
    sum01 = _mm256_add_epi32(sum01, _mm256_madd_epi16(of01, one));
}
CV_ALWAYS_INLINE Moments reduce(const Sums& sum10, const Sums& sum01)
{
    __m256i both = _mm256_hadd_epi32(sum10, sum01);  // side by side
    both = _mm256_hadd_epi32(both, both);
    const __m128i sums = _mm_add_epi32(_mm256_castsi256_si128(both), _mm256_extracti128_si256(both, 1));
    const Moments moments = {_mm_cvtsi128_si32(sums), _mm_extract_epi32(sums, 1)};
    return moments;
}

#elif CV_SIMD

typedef v_int16 Row;  // pixels or weights
typedef v_int32 Sums;

CV_ALWAYS_INLINE int lanesOfRow()
{
    return AQORB_LANES(v_int16);
}
CV_ALWAYS_INLINE Row loadRow(const uchar* p)
{
    return v_reinterpret_as_s16(vx_load_expand(p));
}
CV_ALWAYS_INLINE Row loadRow(const schar* p)
{
    return vx_load_expand(p);
}
CV_ALWAYS_INLINE Row emptyRow()
{
    return vx_setzero_s16();
}
CV_ALWAYS_INLINE Sums noSums()
{
    return vx_setzero_s32();
}
CV_ALWAYS_INLINE void add(const Row& above, const Row& below, const Row& u, const Row& v, Sums& sum10,
                          Sums& sum01)
{
    sum10 = v_dotprod_fast(v_add(above, below), u, sum10);
    sum01 = v_dotprod_fast(v_sub(below, above), v, sum01);
}
CV_ALWAYS_INLINE Moments reduce(const Sums& sum10, const Sums& sum01)
{
    const Moments moments = {v_reduce_sum(sum10), v_reduce_sum(sum01)};
    return moments;
}

#endif

#if CV_SIMD

// Two patches at a time share the loads of the weights.
inline void momentsOfTwo(const uchar* first, const uchar* second, ptrdiff_t step, const PatchWeights& weights,
                         Moments& ofFirst, Moments& ofSecond)
{
    // The rows above and below the middle one share their weights. The middle one comes first, alone.
    const ptrdiff_t apart = weights.rowStep * step, weightsApart = weights.rowStep * PatchWeights::MAX_WIDTH;
    const int rows = weights.radius / weights.rowStep;
    const ptrdiff_t toSecond = second - first;
    const Row none = emptyRow();
    Sums first10 = noSums(), first01 = first10, second10 = first10, second01 = first10;
    for (int x = 0; x < weights.width; x += lanesOfRow())
    {
        const uchar *above = first - weights.radius + x, *below = above;
        const schar *wu = weights.u[0] + x, *wv = weights.v[0] + x;
        add(loadRow(above), none, loadRow(wu), loadRow(wv), first10, first01);
        add(loadRow(above + toSecond), none, loadRow(wu), loadRow(wv), second10, second01);
        for (int row = 0; row < rows; row++)
        {
            above -= apart;
            below += apart;
            wu += weightsApart;
            wv += weightsApart;
            const Row u = loadRow(wu), v = loadRow(wv);
            add(loadRow(above), loadRow(below), u, v, first10, first01);
            add(loadRow(above + toSecond), loadRow(below + toSecond), u, v, second10, second01);
        }
    }
    ofFirst = reduce(first10, first01);
    ofSecond = reduce(second10, second01);
}

#else

inline Moments momentsOfOne(const uchar* center, ptrdiff_t step, const PatchWeights& weights)
{
    Moments moments = {0, 0};
    for (int u = -weights.radius; u <= weights.radius; u++)
    {
        moments.m10 += center[u] * weights.u[0][u + weights.radius];
        for (int v = weights.rowStep; v <= weights.radius; v += weights.rowStep)
        {
            const int above = center[u - v * step], below = center[u + v * step];
            moments.m10 += (above + below) * weights.u[v][u + weights.radius];
            moments.m01 += (below - above) * weights.v[v][u + weights.radius];
        }
    }
    return moments;
}
inline void momentsOfTwo(const uchar* first, const uchar* second, ptrdiff_t step, const PatchWeights& weights,
                         Moments& ofFirst, Moments& ofSecond)
{
    ofFirst = momentsOfOne(first, step, weights);
    ofSecond = momentsOfOne(second, step, weights);
}

#endif

}  // namespace

void momentsAround(const uchar* image, ptrdiff_t step, const PatchWeights& weights, const PatchRegion& inside,
                   const FeaturePoint* points, size_t count, Moments* moments)
{
    const auto isInside = [&](const FeaturePoint& p)
    { return inside.left <= p.x && p.x < inside.right && inside.top <= p.y && p.y < inside.bottom; };
    for (size_t i = 0; i < count; i++)
    {
        if (!isInside(points[i]))
            continue;
        // A patch without a partner is measured twice.
        const size_t first = i, second = i + 1 < count && isInside(points[i + 1]) ? ++i : i;
        const FeaturePoint &p = points[first], &q = points[second];
        momentsOfTwo(image + p.y * step + p.x, image + q.y * step + q.x, step, weights, moments[first],
                     moments[second]);
    }
}

#endif  // CV_CPU_OPTIMIZATION_DECLARATIONS_ONLY

CV_CPU_OPTIMIZATION_NAMESPACE_END
}  // namespace stages
}  // namespace aqorb
}  // namespace cv
