// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#ifndef OPENCV_AQORB_FAST_SCORE_HPP
#define OPENCV_AQORB_FAST_SCORE_HPP

#include "simd_compat.hpp"
#include "types.hpp"

// The FAST score of pixels, for the kernels in fast.simd.hpp: on vectors of different widths, and on a single pixel.

namespace cv
{
namespace aqorb
{
namespace stages
{

CV_CPU_OPTIMIZATION_NAMESPACE_BEGIN

// Whether bestArc keeps all it needs in registers, of which these processors have 32, and others 16.
#if CV_AVX512_SKX || defined(__aarch64__)
#define AQORB_MANY_REGISTERS 1
#else
#define AQORB_MANY_REGISTERS 0
#endif

namespace
{

struct Least
{
    template <typename V> static CV_ALWAYS_INLINE V of(const V& a, const V& b) { return v_min(a, b); }
    static CV_ALWAYS_INLINE int of(int a, int b) { return a < b ? a : b; }
};
struct Greatest
{
    template <typename V> static CV_ALWAYS_INLINE V of(const V& a, const V& b) { return v_max(a, b); }
    static CV_ALWAYS_INLINE int of(int a, int b) { return a > b ? a : b; }
};

// A single pixel, where vectors do not fit or there are none.
struct Single
{
    typedef int V;
    static CV_ALWAYS_INLINE V load(const uchar* p, ptrdiff_t = 0) { return *p; }
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
    static CV_ALWAYS_INLINE uint64 storeGreatest(uchar* p, V a, V b, V c, V d, V e)
    {
        return storeGreater(p, a, Greatest::of(Greatest::of(b, c), Greatest::of(d, e)));
    }
    static CV_ALWAYS_INLINE V whereZero(V a) { return a == 0 ? 255 : 0; }
    static CV_ALWAYS_INLINE V greatestOtherwise(V a, V b) { return Greatest::of(a, b); }
    static CV_ALWAYS_INLINE V greaterThan(V, V a, V b) { return Greatest::of(a, b); }
    static CV_ALWAYS_INLINE V greaterEnd(V, V a, V b) { return Greatest::of(a, b); }
};
#if CV_SIMD
template <typename Vector> struct Lanes
{
    typedef Vector V;
    static CV_ALWAYS_INLINE void store(uchar* p, const V& a) { v_store(p, a); }
    // The difference where it is positive, else 0.
    static CV_ALWAYS_INLINE V above(const V& a, const V& b) { return v_sub(a, b); }
    static CV_ALWAYS_INLINE uint64 maskGreater(const V& a, const V& b) { return signBits(v_gt(a, b)); }
    static CV_ALWAYS_INLINE bool anyGreater(const V& a, const V& b)
    {
#if CV_NEON
        return anyBit(v_gt(a, b));  // on NEON it takes long to collect a bit of each lane
#else
        return maskGreater(a, b) != 0;
#endif
    }
    // Stores a where it is greater than b, else 0. Returns the lanes in which it is greater.
    static CV_ALWAYS_INLINE uint64 storeGreater(uchar* p, const V& a, const V& b)
    {
        v_store(p, v_and(a, v_gt(a, b)));
        return maskGreater(a, b);
    }
    // The same where a is greater than all others.
    static CV_ALWAYS_INLINE uint64 storeGreatest(uchar* p, const V& a, const V& b, const V& c, const V& d,
                                                 const V& e)
    {
        return storeGreater(p, a, v_max(v_max(b, c), v_max(d, e)));
    }
    // The same as Greatest::of, for processors that have free units for other instructions: by other instructions,
    // and for a pair of which the lesser one is known. The latter differs for the ends of arcs, see bestArc.
    static CV_ALWAYS_INLINE V greatestOtherwise(const V& a, const V& b)
    {
        return v_max(a, b);
    }
    static CV_ALWAYS_INLINE V greaterThan(const V&, const V& a, const V& b)
    {
        return v_max(a, b);
    }
    static CV_ALWAYS_INLINE V greaterEnd(const V&, const V& a, const V& b)
    {
        return v_max(a, b);
    }
};
// The widest vectors, and narrow ones for images into which these do not fit.
struct Wide : Lanes<v_uint8>
{
    static CV_ALWAYS_INLINE V load(const uchar* p, ptrdiff_t = 0) { return vx_load(p); }
    static CV_ALWAYS_INLINE V all(int value) { return vx_setall_u8(uchar(value)); }
    static CV_ALWAYS_INLINE V whereZero(const V& a) { return v_eq(a, all(0)); }
#if CV_AVX512_SKX && CV_SIMD_WIDTH == 64
    // Comparisons give masks here. The generic code would make vectors of them, and then masks again.
    static CV_ALWAYS_INLINE uint64 maskGreater(const V& a, const V& b)
    {
        return _mm512_cmpgt_epu8_mask(a.val, b.val);
    }
    static CV_ALWAYS_INLINE bool anyGreater(const V& a, const V& b)
    {
        return maskGreater(a, b) != 0;
    }
    static CV_ALWAYS_INLINE uint64 storeGreater(uchar* p, const V& a, const V& b)
    {
        const __mmask64 greater = _mm512_cmpgt_epu8_mask(a.val, b.val);
        _mm512_storeu_si512(p, _mm512_maskz_mov_epi8(greater, a.val));
        return greater;
    }
    static CV_ALWAYS_INLINE uint64 storeGreatest(uchar* p, const V& a, const V& b, const V& c, const V& d,
                                                 const V& e)
    {
        __mmask64 greater = _mm512_cmpgt_epu8_mask(a.val, b.val);
        greater = _mm512_mask_cmpgt_epu8_mask(greater, a.val, c.val);
        greater = _mm512_mask_cmpgt_epu8_mask(greater, a.val, d.val);
        greater = _mm512_mask_cmpgt_epu8_mask(greater, a.val, e.val);
        _mm512_storeu_si512(p, _mm512_maskz_mov_epi8(greater, a.val));
        return greater;
    }
    // One of two units does v_min and v_max; the other one would be idle in bestArc.
    static CV_ALWAYS_INLINE V greatestOtherwise(const V& a, const V& b)
    {
        return V(_mm512_mask_mov_epi8(a.val, _mm512_cmpgt_epu8_mask(b.val, a.val), b.val));
    }
    static CV_ALWAYS_INLINE V greaterThan(const V& lesser, const V& a, const V& b)
    {
        const int EXCLUSIVE_OR = 0x96;
        return V(_mm512_ternarylogic_epi32(a.val, b.val, lesser.val, EXCLUSIVE_OR));
    }
    static CV_ALWAYS_INLINE V greaterEnd(const V& lesser, const V& a, const V& b)
    {
        return greaterThan(lesser, a, b);
    }
#elif CV_AVX2 && CV_SIMD_WIDTH == 32
    // Two of three units do v_min and v_max, and all of them v_xor. As this takes two instructions, it pays for half of
    // the pairs only.
    static CV_ALWAYS_INLINE V greaterThan(const V& lesser, const V& a, const V& b)
    {
        return v_xor(v_xor(a, b), lesser);
    }
#endif
};
struct Narrow : Lanes<v_uint8x16>
{
    static CV_ALWAYS_INLINE V load(const uchar* p, ptrdiff_t = 0) { return v_load(p); }
    static CV_ALWAYS_INLINE V all(int value) { return v_setall_u8(uchar(value)); }
    static CV_ALWAYS_INLINE V whereZero(const V& a) { return v_eq(a, all(0)); }
};
#endif

#if CV_AVX512_SKX && CV_SIMD_WIDTH == 64
// 16 neighbouring pixels of three rows, side by side.
struct Rows : Wide
{
    static CV_ALWAYS_INLINE V load(const uchar* p, ptrdiff_t step)
    {
        const __m512i first = _mm512_castsi128_si512(v_load(p).val);
        return V(_mm512_inserti32x4(_mm512_inserti32x4(first, v_load(p + step).val, 1),
                                    v_load(p + 2 * step).val, 2));
    }
};
const int ROWS_AT_ONCE = 3;
#elif CV_SIMD
typedef Narrow Rows;
const int ROWS_AT_ONCE = 1;
#endif

// The pixels around a centre.
template <typename Vectors> struct Around
{
    CV_ALWAYS_INLINE Around(const uchar* center_, ptrdiff_t step_) : center(center_), step(step_) {}
    CV_ALWAYS_INLINE typename Vectors::V at(int x, int y) const
    {
        return Vectors::load(center + y * step + x, step);
    }
    const uchar* center;
    ptrdiff_t step;
};

// What counts of a set of pixels if it is to be brighter than the centre, and if it is to be darker.
template <typename Vectors> struct Sides
{
    typedef typename Vectors::V V;
    CV_ALWAYS_INLINE Sides() {}
    CV_ALWAYS_INLINE Sides(V bright_, V dark_)  // by value: with references GCC writes all of them to memory
        : bright(bright_), dark(dark_)
    {
    }
    V bright, dark;
};

// All pixels of two sets: the brighter they are, the greater is the least of them.
template <typename Vectors>
CV_ALWAYS_INLINE Sides<Vectors> both(const Sides<Vectors>& a, const Sides<Vectors>& b)
{
    return Sides<Vectors>(Least::of(a.bright, b.bright), Greatest::of(a.dark, b.dark));
}
template <typename Vectors>
CV_ALWAYS_INLINE Sides<Vectors> bothOtherwise(const Sides<Vectors>& a, const Sides<Vectors>& b)
{
    return Sides<Vectors>(Least::of(a.bright, b.bright), Vectors::greatestOtherwise(a.dark, b.dark));
}
// The better one of two sets.
template <typename Vectors>
CV_ALWAYS_INLINE Sides<Vectors> either(const Sides<Vectors>& a, const Sides<Vectors>& b)
{
    return Sides<Vectors>(Greatest::of(a.bright, b.bright), Least::of(a.dark, b.dark));
}
// A pair of pixels of which both count, or the better one.
template <typename Vectors, typename V> CV_ALWAYS_INLINE Sides<Vectors> bothPixels(const V& a, const V& b)
{
    const V least = Least::of(a, b);
    return Sides<Vectors>(least, Vectors::greaterThan(least, a, b));
}
template <typename Vectors, typename V> CV_ALWAYS_INLINE Sides<Vectors> eitherPixel(const V& a, const V& b)
{
    const V least = Least::of(a, b);
    return Sides<Vectors>(Vectors::greaterEnd(least, a, b), least);
}

// The best of the 16 arcs of 9 pixels on the circle of 16 around p. Neighbouring arcs share work. Pair i is pixels 2 i + 1 and 2 i + 2. The arcs that
// begin at 2 i and at 2 i + 1 have the pairs i to i + 3 in common and differ in their ends, the pixels 2 i and 2 i + 9.
// Of the four arcs that begin at 4 i to 4 i + 3, all have the pairs 2 i + 1 to 2 i + 3; two of them have pair 2 i and
// ends 2 i besides, the other two pair 2 i + 4 and ends 2 i + 1. The eight arcs from 8 i on share pair 4 i + 3.
template <typename Vectors> CV_ALWAYS_INLINE Sides<Vectors> bestArc(const Around<Vectors>& p)
{
    typedef typename Vectors::V V;
    typedef Sides<Vectors> S;
#if AQORB_MANY_REGISTERS
    const V x[16] = {p.at(0, 3),  p.at(1, 3),  p.at(2, 2),  p.at(3, 1),   p.at(3, 0),   p.at(3, -1),
                     p.at(2, -2), p.at(1, -3), p.at(0, -3), p.at(-1, -3), p.at(-2, -2), p.at(-3, -1),
                     p.at(-3, 0), p.at(-3, 1), p.at(-2, 2), p.at(-1, 3)};
    S pair[8], ends[8], four[4], eight[2];
    for (int i = 0; i < 8; i++)
    {
        pair[i] = bothPixels<Vectors>(x[2 * i + 1], x[(2 * i + 2) & 15]);
        ends[i] = eitherPixel<Vectors>(x[2 * i], x[(2 * i + 9) & 15]);
    }
    for (int i = 0; i < 4; i++)
    {
        const int first = 2 * i + 1 + (i & 1);  // with the next one, the pairs that not all eight arcs share
        four[i] = both(bothOtherwise(pair[first & 7], pair[(first + 1) & 7]),
                       either(bothOtherwise(pair[2 * i], ends[2 * i]),
                              bothOtherwise(pair[(2 * i + 4) & 7], ends[2 * i + 1])));
    }
    for (int i = 0; i < 2; i++)
        eight[i] = both(pair[4 * i + 3], either(four[2 * i], four[2 * i + 1]));
    return either(eight[0], eight[1]);
#else
    // The same, ordered by hand so that as few vectors as possible are needed at a time: with 16 registers compilers
    // would otherwise spend more time on saving and restoring them than on the work itself.
    const V x2 = p.at(2, 2), x11 = p.at(-3, -1), x8 = p.at(0, -3), x1 = p.at(1, 3);
    const S ends1 = eitherPixel<Vectors>(x2, x11);
    const S ends4 = eitherPixel<Vectors>(x8, x1);
    const V x10 = p.at(-2, -2), x3 = p.at(3, 1);
    const S ends5 = eitherPixel<Vectors>(x10, x3);
    const S pair0 = bothPixels<Vectors>(x1, x2);
    const S rest2b = both(pair0, ends5);
    const V x9 = p.at(-1, -3);
    const S pair4 = bothPixels<Vectors>(x9, x10);
    const S rest2a = both(pair4, ends4);
    const V x12 = p.at(-3, 0);
    const S pair5 = bothPixels<Vectors>(x11, x12);
    const S rest2 = either(rest2a, rest2b);
    const S rest0b = both(pair4, ends1);
    const S pairs45 = both(pair4, pair5);
    const V x0 = p.at(0, 3);
    const S ends0 = eitherPixel<Vectors>(x0, x9);
    const S rest0 = either(both(pair0, ends0), rest0b);
    const V x13 = p.at(-3, 1), x14 = p.at(-2, 2);
    const S pair6 = bothPixels<Vectors>(x13, x14);
    const S four2 = both(both(pair5, pair6), rest2);
    const V x5 = p.at(3, -1), x6 = p.at(2, -2);
    const S pair2 = bothPixels<Vectors>(x5, x6);
    const V x4 = p.at(3, 0);
    const S pair1 = bothPixels<Vectors>(x3, x4);
    const S pairs01 = both(pair0, pair1);
    const S four0 = both(both(pair1, pair2), rest0);
    const S ends2 = eitherPixel<Vectors>(x4, x13);
    const S rest1a = both(pair2, ends2);
    const V x15 = p.at(-1, 3);
    const S ends3 = eitherPixel<Vectors>(x6, x15);
    const S rest1 = either(rest1a, both(pair6, ends3));
    const S four1 = both(pairs45, rest1);
    const S fours01 = either(four0, four1);
    const S pair7 = bothPixels<Vectors>(x15, x0);
    const S ends6 = eitherPixel<Vectors>(x12, x5);
    const S rest3a = both(pair6, ends6);
    const V x7 = p.at(1, -3);
    const S pair3 = bothPixels<Vectors>(x7, x8);
    const S eight0 = both(pair3, fours01);
    const S ends7 = eitherPixel<Vectors>(x14, x7);
    const S rest3 = either(rest3a, both(pair2, ends7));
    const S four3 = both(pairs01, rest3);
    const S eight1 = both(pair7, either(four2, four3));
    return either(eight0, eight1);
#endif
}

CV_ALWAYS_INLINE int scoreOfPixel(const uchar* p, ptrdiff_t step)
{
    const Sides<Single> best = bestArc(Around<Single>(p, step));
    return Greatest::of(best.bright - *p, *p - best.dark);
}

}  // namespace

CV_CPU_OPTIMIZATION_NAMESPACE_END

}  // namespace stages
}  // namespace aqorb
}  // namespace cv

#endif
