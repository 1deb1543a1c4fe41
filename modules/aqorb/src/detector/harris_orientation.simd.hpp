// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// Kernels of the Harris response, for several corners at once, and of the moments.

#include "detector/harris_orientation.hpp"
#include "common/simd_compat.hpp"

namespace cv
{
namespace aqorb
{
CV_CPU_OPTIMIZATION_NAMESPACE_BEGIN

//! harrisResponses. The 3 pixels around each corner, and the 6 to its right, must be readable.
void cornerResponses(const uchar* image, ptrdiff_t step, const Corner* corners, int count,
                     CornerResponse* responses);

//! Moments of a circular patch around pixels. The weights.radius pixels around each pixel, and the weights.width -
//! weights.radius to its right, must be readable.
void momentsAround(const uchar* image, ptrdiff_t step, const PatchWeights& weights,
                   const FeaturePoint* points, int count, Moments* moments);

#ifndef CV_CPU_OPTIMIZATION_DECLARATIONS_ONLY

namespace
{

// Sums of products of Sobel derivatives over the 5x5 block, as whole numbers.
struct BlockSums
{
    int xx, yy, xy, unused;
};

#if CV_SIMD

const int AT_ONCE = CV_SIMD_WIDTH / 16;  // one corner for each 128 bits

// One row of the 7x7 window around each corner, in eight lanes per corner. The first five lanes hold the horizontal
// difference and the horizontal smoothing.
struct WindowRows
{
    v_int16 difference, smooth;
};

CV_ALWAYS_INLINE WindowRows loadRows(const uchar* const* p, ptrdiff_t offset)
{
    const v_int16 left = expandEach(p, offset), middle = expandEach(p, offset + 1),
                  right = expandEach(p, offset + 2);
    return {v_sub(right, left), v_add(v_add(left, right), v_add(middle, middle))};
}

void sumBlocks(const uchar* const* centers, ptrdiff_t step, BlockSums* sums)
{
    static const short IN_BLOCK[32] = {-1, -1, -1, -1, -1, 0, 0, 0, -1, -1, -1, -1, -1, 0, 0, 0,
                                       -1, -1, -1, -1, -1, 0, 0, 0, -1, -1, -1, -1, -1, 0, 0, 0};
    const v_int16 inBlock = vx_load(IN_BLOCK);
    v_int32 xx = vx_setzero_s32(), yy = xx, xy = xx;
    const ptrdiff_t first = -3 * step - 3;
    WindowRows above = loadRows(centers, first), rows = loadRows(centers, first + step);
    for (int i = 2; i < 7; i++)
    {
        const WindowRows below = loadRows(centers, first + i * step);
        const v_int16 Ix =
            v_and(v_add(v_add(above.difference, below.difference), v_add(rows.difference, rows.difference)),
                  inBlock);
        const v_int16 Iy = v_and(v_sub(below.smooth, above.smooth), inBlock);
        xx = v_dotprod_fast(Ix, Ix, xx);
        yy = v_dotprod_fast(Iy, Iy, yy);
        xy = v_dotprod_fast(Ix, Iy, xy);
        above = rows;
        rows = below;
    }
    // Transposes four lanes of each sum into four lanes with all sums, for each corner.
    v_int32 first4, second4, third4, fourth4;
    v_transpose4x4(xx, yy, xy, vx_setzero_s32(), first4, second4, third4, fourth4);
    v_store(reinterpret_cast<int*>(sums), v_add(v_add(first4, second4), v_add(third4, fourth4)));
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
    // cv::ORB's operations in cv::ORB's order: each rounding counts.
    return (float(a) * b - float(c) * c - K * (float(a) + b) * (float(a) + b)) *
           (SCALE * SCALE * SCALE * SCALE);
}

}  // namespace

void cornerResponses(const uchar* image, ptrdiff_t step, const Corner* corners, int count,
                     CornerResponse* responses)
{
    for (int i = 0; i < count; i += AT_ONCE)
    {
        const uchar* centers[AT_ONCE];
        BlockSums sums[AT_ONCE];
        const int last = count - 1 - i;  // the last corner fills the remaining lanes
        for (int j = 0; j < AT_ONCE; j++)
        {
            const Corner& corner = corners[i + (j < last ? j : last)];
            centers[j] = image + corner.y * step + corner.x;
        }
        sumBlocks(centers, step, sums);
        for (int j = 0; j < AT_ONCE && j <= last; j++)
            responses[i + j] = {corners[i + j].x, corners[i + j].y,
                                responseOf(sums[j].xx, sums[j].yy, sums[j].xy)};
    }
}

namespace
{

#if CV_SIMD

CV_ALWAYS_INLINE v_int16 expand(const uchar* p)
{
    return v_reinterpret_as_s16(vx_load_expand(p));
}

CV_ALWAYS_INLINE Moments momentsOf(const uchar* center, ptrdiff_t step, const PatchWeights& weights)
{
    v_int32 m10 = vx_setzero_s32(), m01 = m10;
    for (int x = 0; x < weights.width; x += AQORB_LANES(v_int16))
    {
        const uchar *above = center - weights.radius + x, *below = above;
        m10 = v_dotprod_fast(expand(above), vx_load(weights.u[0] + x), m10);
        for (int v = weights.rowStep; v <= weights.radius; v += weights.rowStep)
        {
            above -= weights.rowStep * step;
            below += weights.rowStep * step;
            const v_int16 a = expand(above), b = expand(below);
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

void momentsAround(const uchar* image, ptrdiff_t step, const PatchWeights& weights,
                   const FeaturePoint* points, int count, Moments* moments)
{
    for (int i = 0; i < count; i++)
        moments[i] = momentsOf(image + points[i].y * step + points[i].x, step, weights);
}

#endif  // CV_CPU_OPTIMIZATION_DECLARATIONS_ONLY

CV_CPU_OPTIMIZATION_NAMESPACE_END
}  // namespace aqorb
}  // namespace cv
