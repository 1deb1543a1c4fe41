// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#ifndef OPENCV_AQORB_FAST_SCORE_HPP
#define OPENCV_AQORB_FAST_SCORE_HPP

#include "simd_compat.hpp"

// The FAST score of pixels, for the kernels in fast.simd.hpp: on vectors of different widths, and on a single pixel.

namespace cv
{
namespace aqorb
{

CV_CPU_OPTIMIZATION_NAMESPACE_BEGIN

namespace
{

struct Min
{
    template <typename V> static CV_ALWAYS_INLINE V of(const V& a, const V& b) { return v_min(a, b); }
    static CV_ALWAYS_INLINE int of(int a, int b) { return a < b ? a : b; }
};
struct Max
{
    template <typename V> static CV_ALWAYS_INLINE V of(const V& a, const V& b) { return v_max(a, b); }
    static CV_ALWAYS_INLINE int of(int a, int b) { return a > b ? a : b; }
};

// A single pixel, where vectors do not fit or there are none.
struct Single
{
    typedef int V;
    static CV_ALWAYS_INLINE int count() { return 1; }
    static CV_ALWAYS_INLINE V load(const uchar* p) { return *p; }
    static CV_ALWAYS_INLINE void store(uchar* p, V a) { *p = uchar(a); }
    static CV_ALWAYS_INLINE V all(int value) { return value; }
    static CV_ALWAYS_INLINE V above(V a, V b) { return a > b ? a - b : 0; }
    static CV_ALWAYS_INLINE uint64 maskGreater(V a, V b) { return a > b; }
    static CV_ALWAYS_INLINE bool anyGreater(V a, V b) { return a > b; }
    static CV_ALWAYS_INLINE uint64 storeGreater(uchar* p, V a, V b)
    {
        *p = uchar(a > b ? a : 0);
        return a > b;
    }
    static CV_ALWAYS_INLINE V whereZero(V a) { return a == 0 ? 255 : 0; }
};
#if CV_SIMD
template <typename Vector> struct Lanes
{
    typedef Vector V;
    static CV_ALWAYS_INLINE int count() { return AQORB_LANES(V); }
    static CV_ALWAYS_INLINE void store(uchar* p, const V& a) { v_store(p, a); }
    // The difference where it is positive, else 0.
    static CV_ALWAYS_INLINE V above(const V& a, const V& b) { return v_sub(a, b); }
    static CV_ALWAYS_INLINE uint64 maskGreater(const V& a, const V& b) { return greaterLanes(a, b); }
    static CV_ALWAYS_INLINE bool anyGreater(const V& a, const V& b) { return anyLaneGreater(a, b); }
    // Stores a where it is greater than b, else 0. Returns the lanes in which it is greater.
    static CV_ALWAYS_INLINE uint64 storeGreater(uchar* p, const V& a, const V& b)
    {
        v_store(p, v_and(a, v_gt(a, b)));
        return greaterLanes(a, b);
    }
    static CV_ALWAYS_INLINE V whereZero(const V& a) { return v_eq(a, v_xor(a, a)); }
};
// The widest vectors, and narrow ones for images into which these do not fit.
struct Wide : Lanes<v_uint8>
{
    static CV_ALWAYS_INLINE V load(const uchar* p) { return vx_load(p); }
    static CV_ALWAYS_INLINE V all(int value) { return vx_setall_u8(uchar(value)); }
};
struct Narrow : Lanes<v_uint8x16>
{
    static CV_ALWAYS_INLINE V load(const uchar* p) { return v_load(p); }
    static CV_ALWAYS_INLINE V all(int value) { return v_setall_u8(uchar(value)); }
};
#else
typedef Single Wide, Narrow;
#endif

// The deciding pixels of a set: its darkest one, for sets brighter than the centre, and its brightest one, for darker
// sets.
template <typename Vectors> struct Sides
{
    typedef typename Vectors::V V;
    CV_ALWAYS_INLINE Sides(V bright_, V dark_)  // by value: with references GCC writes all of them to memory
        : bright(bright_), dark(dark_)
    {
    }
    V bright, dark;
};

// The pixels around a centre.
template <typename Vectors> struct Around
{
    CV_ALWAYS_INLINE Around(const uchar* center_, ptrdiff_t step_) : center(center_), step(step_) {}
    CV_ALWAYS_INLINE Sides<Vectors> at(int x, int y) const
    {
        const typename Vectors::V pixel = Vectors::load(center + y * step + x);
        return Sides<Vectors>(pixel, pixel);
    }
    const uchar* center;
    ptrdiff_t step;
};

// The union of two sets.
template <typename Vectors>
CV_ALWAYS_INLINE Sides<Vectors> both(const Sides<Vectors>& a, const Sides<Vectors>& b)
{
    return Sides<Vectors>(Min::of(a.bright, b.bright), Max::of(a.dark, b.dark));
}
// The better one of two sets.
template <typename Vectors>
CV_ALWAYS_INLINE Sides<Vectors> either(const Sides<Vectors>& a, const Sides<Vectors>& b)
{
    return Sides<Vectors>(Max::of(a.bright, b.bright), Min::of(a.dark, b.dark));
}
// The best of the 16 arcs of 9 pixels on the circle of 16 around p. Neighbouring arcs share work. With & for both, |
// for either, and numbers that go round the circle, let
//   pair(i) = pixel(2 i + 1) & pixel(2 i + 2)
//   ends(i) = pixel(2 i) | pixel(2 i + 9)
//   rest(i) = pair(2 i) & ends(2 i) | pair(2 i + 4) & ends(2 i + 1)
// Of the two arcs that begin at 2 i and 2 i + 1, the better one is pair(i) & pair(i + 1) & pair(i + 2) & pair(i + 3) &
// ends(i). So of the four arcs from 4 i on, the best one is
//   four(i) = pair(2 i + 1) & pair(2 i + 2) & pair(2 i + 3) & rest(i).
// The eight arcs from 8 i on have pair(4 i + 3) in common: four0 to four3 leave it out, and eight0 and eight1 add it.
template <typename Vectors> CV_ALWAYS_INLINE Sides<Vectors> bestArc(const Around<Vectors>& p)
{
    typedef Sides<Vectors> S;
    // The order is made by hand so that few vectors are needed at a time. With 16 registers (AVX2) compilers would save
    // and restore more of them if the formulas stood here one after the other.
    const S x2 = p.at(2, 2), x11 = p.at(-3, -1), x8 = p.at(0, -3), x1 = p.at(1, 3);
    const S ends1 = either(x2, x11);
    const S ends4 = either(x8, x1);
    const S x10 = p.at(-2, -2), x3 = p.at(3, 1);
    const S ends5 = either(x10, x3);
    const S pair0 = both(x1, x2);
    const S rest2b = both(pair0, ends5);
    const S x9 = p.at(-1, -3);
    const S pair4 = both(x9, x10);
    const S rest2a = both(pair4, ends4);
    const S x12 = p.at(-3, 0);
    const S pair5 = both(x11, x12);
    const S rest2 = either(rest2a, rest2b);
    const S rest0b = both(pair4, ends1);
    const S pairs45 = both(pair4, pair5);
    const S x0 = p.at(0, 3);
    const S ends0 = either(x0, x9);
    const S rest0 = either(both(pair0, ends0), rest0b);
    const S x13 = p.at(-3, 1), x14 = p.at(-2, 2);
    const S pair6 = both(x13, x14);
    const S four2 = both(both(pair5, pair6), rest2);
    const S x5 = p.at(3, -1), x6 = p.at(2, -2);
    const S pair2 = both(x5, x6);
    const S x4 = p.at(3, 0);
    const S pair1 = both(x3, x4);
    const S pairs01 = both(pair0, pair1);
    const S four0 = both(both(pair1, pair2), rest0);
    const S ends2 = either(x4, x13);
    const S rest1a = both(pair2, ends2);
    const S x15 = p.at(-1, 3);
    const S ends3 = either(x6, x15);
    const S rest1 = either(rest1a, both(pair6, ends3));
    const S four1 = both(pairs45, rest1);
    const S fours01 = either(four0, four1);
    const S pair7 = both(x15, x0);
    const S ends6 = either(x12, x5);
    const S rest3a = both(pair6, ends6);
    const S x7 = p.at(1, -3);
    const S pair3 = both(x7, x8);
    const S eight0 = both(pair3, fours01);
    const S ends7 = either(x14, x7);
    const S rest3 = either(rest3a, both(pair2, ends7));
    const S four3 = both(pairs01, rest3);
    const S eight1 = both(pair7, either(four2, four3));
    return either(eight0, eight1);
}

}  // namespace

CV_CPU_OPTIMIZATION_NAMESPACE_END

}  // namespace aqorb
}  // namespace cv

#endif
