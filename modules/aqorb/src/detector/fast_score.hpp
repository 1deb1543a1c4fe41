// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#ifndef OPENCV_AQORB_FAST_SCORE_HPP
#define OPENCV_AQORB_FAST_SCORE_HPP

#include "common/simd_compat.hpp"

// FAST score for the kernels in fast.simd.hpp: on vectors of different widths, and on a single pixel.

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

// Operations on a single pixel, for CPUs without vectors and for images narrower than a vector.
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
    // Difference a - b if positive, else 0.
    static CV_ALWAYS_INLINE V above(const V& a, const V& b) { return v_sub(a, b); }
    static CV_ALWAYS_INLINE uint64 maskGreater(const V& a, const V& b) { return greaterLanes(a, b); }
    static CV_ALWAYS_INLINE bool anyGreater(const V& a, const V& b) { return anyLaneGreater(a, b); }
    // Stores a in lanes where a > b, else 0. Returns the bits of these lanes.
    static CV_ALWAYS_INLINE uint64 storeGreater(uchar* p, const V& a, const V& b)
    {
        v_store(p, v_and(a, v_gt(a, b)));
        return greaterLanes(a, b);
    }
    static CV_ALWAYS_INLINE V whereZero(const V& a) { return v_eq(a, v_xor(a, a)); }
};
// The widest vectors, and narrow vectors for narrow images.
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

// The pixel of an arc that decides its score: the darkest pixel of a brighter arc, the brightest pixel of a darker arc.
template <typename Vectors> struct Extremes
{
    typedef typename Vectors::V V;
    // By value: with references GCC writes all of them to memory.
    CV_ALWAYS_INLINE Extremes(V darkest_, V brightest_) : darkest(darkest_), brightest(brightest_) {}
    V darkest, brightest;
};

// Pixels around a centre.
template <typename Vectors> struct Circle
{
    CV_ALWAYS_INLINE Circle(const uchar* center_, ptrdiff_t step_) : center(center_), step(step_) {}
    CV_ALWAYS_INLINE Extremes<Vectors> at(int x, int y) const
    {
        const typename Vectors::V pixel = Vectors::load(center + y * step + x);
        return Extremes<Vectors>(pixel, pixel);
    }
    const uchar* center;
    ptrdiff_t step;
};

#if CV_SIMD
// Circles around four neighbouring pixels in each of three rows.
struct ThreeRows
{
    CV_ALWAYS_INLINE ThreeRows(const uchar* first_, ptrdiff_t step_) : first(first_), step(step_) {}
    // Lane 4 * row + i belongs to pixel i of a row.
    CV_ALWAYS_INLINE v_uint8x16 load(int x, int y) const
    {
        int rows[4] = {};
        for (int row = 0; row < 3; row++)
            std::memcpy(&rows[row], first + (row + y) * step + x, sizeof(int));
        return v_reinterpret_as_u8(v_int32x4(rows[0], rows[1], rows[2], rows[3]));
    }
    CV_ALWAYS_INLINE Extremes<Narrow> at(int x, int y) const
    {
        const v_uint8x16 pixels = load(x, y);
        return Extremes<Narrow>(pixels, pixels);
    }
    const uchar* first;
    ptrdiff_t step;
};
#endif

// Extremes of the union of two arcs.
template <typename Vectors>
CV_ALWAYS_INLINE Extremes<Vectors> both(const Extremes<Vectors>& a, const Extremes<Vectors>& b)
{
    return Extremes<Vectors>(Min::of(a.darkest, b.darkest), Max::of(a.brightest, b.brightest));
}
// Extremes of the better of two arcs.
template <typename Vectors>
CV_ALWAYS_INLINE Extremes<Vectors> either(const Extremes<Vectors>& a, const Extremes<Vectors>& b)
{
    return Extremes<Vectors>(Max::of(a.darkest, b.darkest), Min::of(a.brightest, b.brightest));
}
// Finds the best of the 16 arcs of 9 pixels on the circle of 16 pixels around p. Neighbouring arcs share work. Let &
// mean both, | mean either, and count pixels round the circle:
//   pair(i) = pixel(2 i + 1) & pixel(2 i + 2)
//   end(i) = pixel(2 i) | pixel(2 i + 9)
//   unshared(i) = pair(2 i) & end(2 i) | pair(2 i + 4) & end(2 i + 1)
// Arcs 2 i and 2 i + 1 share four pairs and differ in one end pixel: the better arc is pair(i) & pair(i + 1) &
// pair(i + 2) & pair(i + 3) & end(i). Arcs 4 i to 4 i + 3 share three pairs:
//   bestOfFour(i) = pair(2 i + 1) & pair(2 i + 2) & pair(2 i + 3) & unshared(i)
// Arcs 8 i to 8 i + 7 share pair(4 i + 3): the variables bestOfFour leave it out, and bestOfEight add it.
template <typename Pixels> CV_ALWAYS_INLINE auto bestArc(const Pixels& p) -> decltype(p.at(0, 0))
{
    typedef decltype(p.at(0, 0)) S;
    // This order keeps few vectors alive at a time. With formula after formula, compilers spill more of the 16
    // registers of AVX2.
    const S x2 = p.at(2, 2), x11 = p.at(-3, -1), x8 = p.at(0, -3), x1 = p.at(1, 3);
    const S end1 = either(x2, x11);
    const S end4 = either(x8, x1);
    const S x10 = p.at(-2, -2), x3 = p.at(3, 1);
    const S end5 = either(x10, x3);
    const S pair0 = both(x1, x2);
    const S unshared2b = both(pair0, end5);
    const S x9 = p.at(-1, -3);
    const S pair4 = both(x9, x10);
    const S unshared2a = both(pair4, end4);
    const S x12 = p.at(-3, 0);
    const S pair5 = both(x11, x12);
    const S unshared2 = either(unshared2a, unshared2b);
    const S unshared0b = both(pair4, end1);
    const S pairs45 = both(pair4, pair5);
    const S x0 = p.at(0, 3);
    const S end0 = either(x0, x9);
    const S unshared0 = either(both(pair0, end0), unshared0b);
    const S x13 = p.at(-3, 1), x14 = p.at(-2, 2);
    const S pair6 = both(x13, x14);
    const S bestOfFour2 = both(both(pair5, pair6), unshared2);
    const S x5 = p.at(3, -1), x6 = p.at(2, -2);
    const S pair2 = both(x5, x6);
    const S x4 = p.at(3, 0);
    const S pair1 = both(x3, x4);
    const S pairs01 = both(pair0, pair1);
    const S bestOfFour0 = both(both(pair1, pair2), unshared0);
    const S end2 = either(x4, x13);
    const S unshared1a = both(pair2, end2);
    const S x15 = p.at(-1, 3);
    const S end3 = either(x6, x15);
    const S unshared1 = either(unshared1a, both(pair6, end3));
    const S bestOfFour1 = both(pairs45, unshared1);
    const S bestOfFours01 = either(bestOfFour0, bestOfFour1);
    const S pair7 = both(x15, x0);
    const S end6 = either(x12, x5);
    const S unshared3a = both(pair6, end6);
    const S x7 = p.at(1, -3);
    const S pair3 = both(x7, x8);
    const S bestOfEight0 = both(pair3, bestOfFours01);
    const S end7 = either(x14, x7);
    const S unshared3 = either(unshared3a, both(pair2, end7));
    const S bestOfFour3 = both(pairs01, unshared3);
    const S bestOfEight1 = both(pair7, either(bestOfFour2, bestOfFour3));
    return either(bestOfEight0, bestOfEight1);
}

}  // namespace

CV_CPU_OPTIMIZATION_NAMESPACE_END

}  // namespace aqorb
}  // namespace cv

#endif
