// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// Samples of the patches of several matches, one match in each lane of a vector. Only the kernel of the alignment
// includes this file: all names have internal linkage, see types.hpp.

#ifndef OPENCV_AQORB_PATCH_SAMPLES_HPP
#define OPENCV_AQORB_PATCH_SAMPLES_HPP

#include "refinement/alignment.hpp"
#include "refinement/lanes.hpp"

namespace cv
{
namespace aqorb
{
namespace
{

// Windows of one patch for each lane.
struct Windows
{
    void set(int lane, const LevelWindow& window)
    {
        origins[lane] = window.origin;
        steps[lane] = window.step;
        x[lane] = window.x;
        y[lane] = window.y;
        left[lane] = window.left;
        top[lane] = window.top;
        right[lane] = window.right;
        bottom[lane] = window.bottom;
    }

    const uchar* origins[LANES];
    int steps[LANES];
    float x[LANES], y[LANES], left[LANES], top[LANES], right[LANES], bottom[LANES];
};

// Affine map: sample (u, v) lies at (x + xu * u + xv * v, y + yu * u + yv * v).
struct AffineMap
{
    // Moves the samples of all other lanes to the origin.
    void keep(const Floats& lanes)
    {
        Floats* const numbers[] = {&x, &y, &xu, &xv, &yu, &yv};
        for (Floats* number : numbers)
            *number = v_and(lanes, *number);
    }
    Floats determinant() const { return minus(v_mul(xu, yv), xv, yu); }

    Floats x, y, xu, xv, yu, yv;
};

// Lanes in which all samples up to a radius lie inside the image. Infinite and NaN positions lie outside.
CV_ALWAYS_INLINE Floats isInside(const AffineMap& map, const Windows& windows, int radius)
{
    const Floats reachX = v_mul(all(float(radius)), v_add(v_abs(map.xu), v_abs(map.xv)));
    const Floats reachY = v_mul(all(float(radius)), v_add(v_abs(map.yu), v_abs(map.yv)));
    const Floats isInsideX = v_and(v_gt(v_sub(map.x, reachX), load(windows.left)),
                                   v_gt(load(windows.right), v_add(map.x, reachX)));
    const Floats isInsideY = v_and(v_gt(v_sub(map.y, reachY), load(windows.top)),
                                   v_gt(load(windows.bottom), v_add(map.y, reachY)));
    return v_and(isInsideX, isInsideY);
}

// Samples of all lanes in a row of a patch, for u from -RADIUS to RADIUS.
template <int RADIUS> struct SampleRow
{
    enum
    {
        COUNT = (2 * RADIUS + 1) * LANES
    };

    // Reads the pixels around each sample.
    void fetch(const Windows& windows, const AffineMap& map, int v)
    {
        CV_DECL_ALIGNED(CACHE_LINE) int offsets[COUNT];
        const Floats rowX = plus(map.x, map.xv, all(float(v))), rowY = plus(map.y, map.yv, all(float(v)));
        for (int u = -RADIUS, i = 0; u <= RADIUS; u++, i += LANES)
        {
            const Floats x = plus(rowX, map.xu, all(float(u))), y = plus(rowY, map.yu, all(float(u)));
            const Ints column = v_trunc(x), row = v_trunc(y);
            v_store(offsets + i, v_add(v_mul(row, load(windows.steps)), column));
            v_store(fractionsX + i, v_sub(x, v_cvt_f32(column)));
            v_store(fractionsY + i, v_sub(y, v_cvt_f32(row)));
        }
        for (int lane = 0; lane < LANES; lane++)
        {
            const uchar* const upper = windows.origins[lane];
            const uchar* const lower = upper + windows.steps[lane];
            for (int i = lane; i < COUNT; i += LANES)
            {
                const uchar *const a = upper + offsets[i], *const c = lower + offsets[i];
                quads[i] = unsigned(a[0] | a[1] << 8) | unsigned(c[0] | c[1] << 8) << 16;
            }
        }
    }

    // Interpolates a sample bilinearly.
    Floats at(int u) const
    {
        const int i = (u + RADIUS) * LANES;
        const Floats x = load(fractionsX + i), y = load(fractionsY + i);
        const Floats a = byteOf<0>(quads + i), b = byteOf<1>(quads + i);
        const Floats c = byteOf<2>(quads + i), d = byteOf<3>(quads + i);
        const Floats upper = plus(a, x, v_sub(b, a)), lower = plus(c, x, v_sub(d, c));
        return plus(upper, y, v_sub(lower, upper));
    }

    CV_DECL_ALIGNED(CACHE_LINE) float fractionsX[COUNT], fractionsY[COUNT];
    CV_DECL_ALIGNED(CACHE_LINE) unsigned quads[COUNT];  // 2 x 2 pixels each
};

// Calls use(v, row) for each row of a patch. Rows are fetched one ahead: a vector load waits until the narrower stores
// before it have reached the cache.
template <int RADIUS, typename Use>
CV_ALWAYS_INLINE void forEachRow(const Windows& windows, const AffineMap& map, const Use& use)
{
    SampleRow<RADIUS> rows[2];
    rows[0].fetch(windows, map, -RADIUS);
    for (int v = -RADIUS; v <= RADIUS; v++)
    {
        if (v < RADIUS)
            rows[(v + 1 + RADIUS) % 2].fetch(windows, map, v + 1);
        use(v, rows[(v + RADIUS) % 2]);
    }
}

CV_ALWAYS_INLINE float lesser(float a, float b)
{
    return a < b ? a : b;
}
CV_ALWAYS_INLINE float greater(float a, float b)
{
    return a > b ? a : b;
}

// Prefetches the pixels of a patch. Without it the kernel waits for a tenth to a quarter of its time.
inline void prefetch(const LevelWindow& window, float spacing)
{
#if defined(__GNUC__)
    const float reach = (PATCH_RADIUS + 1) * spacing;
    const int first = int(greater(window.top, window.y - reach)),
              last = int(lesser(window.bottom, window.y + reach));
    const uchar* row = window.origin + ptrdiff_t(first) * window.step;
    const int left = int(greater(window.left, window.x - reach)),
              right = int(lesser(window.right, window.x + reach));
    for (int y = first; y <= last; y++, row += window.step)
    {
        __builtin_prefetch(row + left, 0, 2);
        __builtin_prefetch(row + right, 0, 2);
    }
#else
    CV_UNUSED(window);
    CV_UNUSED(spacing);
#endif
}

}  // namespace
}  // namespace aqorb
}  // namespace cv

#endif
