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
CV_CPU_OPTIMIZATION_NAMESPACE_BEGIN

/** The moments of a circular patch around pixels.
 @param inside the pixels around which all of the patch can be read: weights.radius pixels around them, and
 weights.width - weights.radius to their right. The moments around other pixels are left as they are. */
void momentsAround(const uchar* image, ptrdiff_t step, const PatchWeights& weights, const PatchRegion& inside,
                   const FeaturePoint* points, size_t count, Moments* moments);

#ifndef CV_CPU_OPTIMIZATION_DECLARATIONS_ONLY

namespace
{

#if CV_SIMD

CV_ALWAYS_INLINE v_int16 load(const uchar* p)
{
    return v_reinterpret_as_s16(vx_load_expand(p));
}

CV_ALWAYS_INLINE Moments momentsOf(const uchar* center, ptrdiff_t step, const PatchWeights& weights)
{
    v_int32 m10 = vx_setzero_s32(), m01 = m10;
    for (int x = 0; x < weights.width; x += AQORB_LANES(v_int16))
    {
        const uchar *above = center - weights.radius + x, *below = above;
        m10 = v_dotprod_fast(load(above), vx_load(weights.u[0] + x), m10);
        for (int v = weights.rowStep; v <= weights.radius; v += weights.rowStep)
        {
            above -= weights.rowStep * step;
            below += weights.rowStep * step;
            const v_int16 a = load(above), b = load(below);
            m10 = v_dotprod_fast(v_add(a, b), vx_load(weights.u[v] + x), m10);
            m01 = v_dotprod_fast(v_sub(b, a), vx_load(weights.v[v] + x), m01);
        }
    }
    return {v_reduce_sum(m10), v_reduce_sum(m01)};
}

#else

// Without vectors there are no PatchWeights.
inline Moments momentsOf(const uchar*, ptrdiff_t, const PatchWeights&)
{
    return Moments();
}

#endif

}  // namespace

void momentsAround(const uchar* image, ptrdiff_t step, const PatchWeights& weights, const PatchRegion& inside,
                   const FeaturePoint* points, size_t count, Moments* moments)
{
    for (size_t i = 0; i < count; i++)
    {
        const FeaturePoint& p = points[i];
        if (inside.left <= p.x && p.x < inside.right && inside.top <= p.y && p.y < inside.bottom)
            moments[i] = momentsOf(image + p.y * step + p.x, step, weights);
    }
}

#endif  // CV_CPU_OPTIMIZATION_DECLARATIONS_ONLY

CV_CPU_OPTIMIZATION_NAMESPACE_END
}  // namespace aqorb
}  // namespace cv
