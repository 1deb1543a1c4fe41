// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "fast.hpp"
#include "simd_compat.hpp"

#include <cstring>

namespace cv
{
namespace aqorb
{
namespace stages
{

CV_CPU_OPTIMIZATION_NAMESPACE_BEGIN

//! How many pixels a block may have, the widest first. The last is 1, for images that are too narrow for the others.
void scanWidths(int widths[SCAN_WIDTHS]);

//! Continues a scan up to the row before `end`, which is at most scan.bottom.
void continueScan(FastScan& scan, int end);

/** Removes corners whose scores are too low from the blocks found and from the plane.
 @param first block to look at
 @param floors by column: the highest score that is too low
 @return number of corners left; scan.foundCount becomes the number of blocks that have any */
int dropCorners(FastScan& scan, int first, const uchar* floors);

/** The scores of cornerScores3x3 for p and its neighbours.
 @param lane 0 to 13, the lane of the left neighbour in vectors of 16 pixels; 3 pixels around these must be readable */
void neighborScores(const uchar* p, ptrdiff_t step, int lane, int scores[3][3]);

#ifndef CV_CPU_OPTIMIZATION_DECLARATIONS_ONLY

namespace
{

// The score of the bright side takes the least of an arc and the greatest of all arcs; that of the dark side is the
// other way round.
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

// The pixels of the circle for all lanes. The sense of rotation does not matter.
template <typename V> struct Circle
{
    V at[16];
};

// Takes `Inner` over the 9 pixels of each arc, and `Outer` over the 16 arcs. Neighbouring arcs share work: the arcs
// that begin at k and at k + 1 have pixels k + 1 to k + 8 in common and differ in the pixels k and k + 9 only. For odd
// indices j, b[j] is `Inner` over pixels j and j + 1, and c[j] over j to j + 3. The arcs from k and from k + 4 have
// c[k + 5] in common.
template <typename Inner, typename Outer, typename V> CV_ALWAYS_INLINE V bestArc(const Circle<V>& circle)
{
    const V* x = circle.at;
    V b[8], c[8], ends[8];  // b and c of j = 2 i + 1, ends of k = 2 i
    for (int i = 0; i < 8; i++)
        b[i] = Inner::of(x[2 * i + 1], x[(2 * i + 2) & 15]);
    for (int i = 0; i < 8; i++)
        c[i] = Inner::of(b[i], b[(i + 1) & 7]);
    for (int i = 0; i < 8; i++)
        ends[i] = Outer::of(x[2 * i], x[(2 * i + 9) & 15]);
    V best[4];
    for (int i = 0; i < 4; i++)
    {
        const int k = (i & 1) + (i >> 1) * 4;  // 0, 1, 4, 5; with k + 2 these are all eight
        best[i] = Inner::of(c[(k + 2) & 7], Outer::of(Inner::of(c[k], ends[k]),
                                                      Inner::of(c[(k + 4) & 7], ends[(k + 2) & 7])));
    }
    return Outer::of(Outer::of(best[0], best[1]), Outer::of(best[2], best[3]));
}

// A single pixel, where vectors do not fit or there are none.
struct Single
{
    typedef int V;
    static CV_ALWAYS_INLINE V load(const uchar* p) { return *p; }
    static CV_ALWAYS_INLINE void store(uchar* p, V a) { *p = uchar(a); }
    static CV_ALWAYS_INLINE V all(int value) { return value; }
    static CV_ALWAYS_INLINE V above(V a, V b) { return a > b ? a - b : 0; }
    static CV_ALWAYS_INLINE uint64 maskGreater(V a, V b) { return a > b; }
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
    static CV_ALWAYS_INLINE void store(uchar* p, const V& a) { v_store(p, a); }
    // The difference where it is positive, else 0.
    static CV_ALWAYS_INLINE V above(const V& a, const V& b) { return v_sub(a, b); }
    static CV_ALWAYS_INLINE uint64 maskGreater(const V& a, const V& b) { return signBits(v_gt(a, b)); }
    // Stores a where it is greater than b, else 0. Returns the lanes in which it is greater.
    static CV_ALWAYS_INLINE uint64 storeGreater(uchar* p, const V& a, const V& b)
    {
        v_store(p, v_and(a, v_gt(a, b)));
        return maskGreater(a, b);
    }
};
// The widest vectors, and narrow ones for images into which these do not fit.
struct Wide : Lanes<v_uint8>
{
    static CV_ALWAYS_INLINE V load(const uchar* p) { return vx_load(p); }
    static CV_ALWAYS_INLINE V all(int value) { return vx_setall_u8(uchar(value)); }
    static CV_ALWAYS_INLINE V whereZero(const V& a) { return v_eq(a, all(0)); }
#if CV_AVX512_SKX && CV_SIMD_WIDTH == 64
    // Comparisons give masks here. The generic code would make vectors of them, and then masks again.
    static CV_ALWAYS_INLINE uint64 maskGreater(const V& a, const V& b)
    {
        return _mm512_cmpgt_epu8_mask(a.val, b.val);
    }
    static CV_ALWAYS_INLINE uint64 storeGreater(uchar* p, const V& a, const V& b)
    {
        const __mmask64 greater = _mm512_cmpgt_epu8_mask(a.val, b.val);
        _mm512_storeu_si512(p, _mm512_maskz_mov_epi8(greater, a.val));
        return greater;
    }
#endif
};
struct Narrow : Lanes<v_uint8x16>
{
    static CV_ALWAYS_INLINE V load(const uchar* p) { return v_load(p); }
    static CV_ALWAYS_INLINE V all(int value) { return v_setall_u8(uchar(value)); }
    static CV_ALWAYS_INLINE V whereZero(const V& a) { return v_eq(a, all(0)); }
};
#endif

template <typename Vectors>
CV_ALWAYS_INLINE void loadCircle(const uchar* p, ptrdiff_t step, Circle<typename Vectors::V>& circle)
{
    const uchar *d1 = p + step, *d2 = d1 + step, *d3 = d2 + step, *u1 = p - step, *u2 = u1 - step,
                *u3 = u2 - step;
    typename Vectors::V* x = circle.at;
    x[0] = Vectors::load(d3);
    x[1] = Vectors::load(d3 + 1);
    x[2] = Vectors::load(d2 + 2);
    x[3] = Vectors::load(d1 + 3);
    x[4] = Vectors::load(p + 3);
    x[5] = Vectors::load(u1 + 3);
    x[6] = Vectors::load(u2 + 2);
    x[7] = Vectors::load(u3 + 1);
    x[8] = Vectors::load(u3);
    x[9] = Vectors::load(u3 - 1);
    x[10] = Vectors::load(u2 - 2);
    x[11] = Vectors::load(u1 - 3);
    x[12] = Vectors::load(p - 3);
    x[13] = Vectors::load(d1 - 3);
    x[14] = Vectors::load(d2 - 2);
    x[15] = Vectors::load(d3 - 1);
}

CV_ALWAYS_INLINE int scoreOfPixel(const uchar* p, ptrdiff_t step)
{
    Circle<int> circle;
    loadCircle<Single>(p, step, circle);
    return Greatest::of(bestArc<Least, Greatest>(circle) - *p, *p - bestArc<Greatest, Least>(circle));
}

CV_ALWAYS_INLINE uchar* scoresOf(const FastScan& scan, int y)
{
    return scan.scores + (y & (SCAN_ROWS - 1)) * scan.scoreStep;
}

// Scores the blocks of a row: the FAST score, 1 to 255, where it exceeds the threshold, else 0. Lists the blocks that
// have a score and returns their number.
template <typename Vectors> int scoreRow(const FastScan& scan, int y)
{
    typedef typename Vectors::V V;
    const uchar* row = scan.image + y * scan.step;
    const ptrdiff_t step = scan.step;
    uchar* scores = scoresOf(scan, y);
    int* list = scan.listed[y & 1];
    const V zero = Vectors::all(0), limit = Vectors::all(scan.threshold);
    int possible = 0, count = 0;
    // Every arc contains one end of each axis of the circle, and these four pixels rule out most blocks. Where most
    // blocks of the row above have a corner the test is skipped, as it would cost more than it saves.
    const bool skipTest = 4 * scan.listedCount[(y - 1) & 1] > 3 * scan.blockCount;
    for (int i = 0; i < scan.blockCount; i++)
    {
        list[possible] = i;
        if (skipTest)
        {
            possible++;
            continue;
        }
        const int x = scan.blocks[i].x;
        const uchar* p = row + x;
        const V v = Vectors::load(p), up = Vectors::load(p - 3 * step), down = Vectors::load(p + 3 * step),
                left = Vectors::load(p - 3), right = Vectors::load(p + 3);
        Vectors::store(
            scores + x,
            zero);  // stored here, because compilers would load the pixels again after a store further up
        const V bright = Least::of(Greatest::of(up, down), Greatest::of(left, right));
        const V dark = Greatest::of(Least::of(up, down), Least::of(left, right));
        const V bound = Greatest::of(Vectors::above(bright, v), Vectors::above(v, dark));
        possible += Vectors::maskGreater(bound, limit) != 0;
    }
    for (int i = 0; i < possible; i++)
    {
        const int x = scan.blocks[list[i]].x;
        const uchar* p = row + x;
        Circle<V> circle;
        loadCircle<Vectors>(p, step, circle);
        const V v = Vectors::load(p);
        const V bright = Vectors::above(bestArc<Least, Greatest>(circle), v);
        const V dark = Vectors::above(v, bestArc<Greatest, Least>(circle));
        list[count] = list[i];
        count += Vectors::storeGreater(scores + x, Greatest::of(bright, dark), limit) != 0;
    }
    return count;
}

template <typename Vectors> void clearRow(const FastScan& scan, int y)
{
    for (int i = 0; i < scan.blockCount; i++)
        Vectors::store(scoresOf(scan, y) + scan.blocks[i].x, Vectors::all(0));
}

// Finds the corners of a row, whose scores are higher than those of their eight neighbours. The scores go to the plane
// and the blocks to those found.
template <typename Vectors> void suppressRow(FastScan& scan, int y)
{
    typedef typename Vectors::V V;
    const uchar *scores = scoresOf(scan, y), *above = scoresOf(scan, y - 1), *below = scoresOf(scan, y + 1);
    uchar* corners = scan.plane + (y - scan.top) * scan.planeStep;
    const int end = scan.blocks[scan.blockCount - 1].x + scan.blockWidth;
    std::memset(corners + scan.blocks[0].x - SUPPRESS_MARGIN, 0,
                end - scan.blocks[0].x + 2 * SUPPRESS_MARGIN);
    const int* listed = scan.listed[y & 1];
    const V strongest = Vectors::all(scan.strongThreshold);
    CornerBlock* found = scan.found + scan.foundCount;
    for (int i = 0; i < scan.listedCount[y & 1]; i++)
    {
        const ScanBlock& block = scan.blocks[listed[i]];
        const int x = block.x;
        const uchar *s = scores + x, *u = above + x, *d = below + x;
        const V score = Vectors::load(s);
        const V beside = Greatest::of(Vectors::load(s - 1), Vectors::load(s + 1));
        const V over =
            Greatest::of(Greatest::of(Vectors::load(u - 1), Vectors::load(u)), Vectors::load(u + 1));
        const V under =
            Greatest::of(Greatest::of(Vectors::load(d - 1), Vectors::load(d)), Vectors::load(d + 1));
        V around = Greatest::of(beside, Greatest::of(over, under));
        if (scan.mask)
            around =
                Greatest::of(around, Vectors::whereZero(Vectors::load(scan.mask + y * scan.maskStep + x)));
        const uint64 columns = Vectors::storeGreater(corners + x, score, around);
        scan.strong[listed[i]] |= columns & Vectors::maskGreater(score, strongest);
        // The plane has got corners in columns that are not wanted, too. dropCorners clears them.
        found->x = x;
        found->y = y;
        found->columns = columns & block.wanted;
        found += columns != 0;
    }
    scan.foundCount = int(found - scan.found);
}

template <typename Vectors> void scanRows(FastScan& scan, int end)
{
    for (; scan.y <= end; scan.y++)
    {
        const int y = scan.y;
        scoresOf(scan, y)[scan.left - 1] = scoresOf(scan, y)[scan.right] = 0;
        if (y >= scan.scoredTop && y < scan.scoredBottom)
        {
            scan.listedCount[y & 1] = scoreRow<Vectors>(scan, y);
        }
        else
        {
            clearRow<Vectors>(scan, y);
            scan.listedCount[y & 1] = 0;
        }
        if (y > scan.top)
            suppressRow<Vectors>(scan, y - 1);
    }
}

template <typename Vectors> int dropFromBlocks(FastScan& scan, int first, const uchar* floors)
{
    CornerBlock* left = scan.found + first;
    int corners = 0;
    for (int i = first; i < scan.foundCount; i++)
    {
        CornerBlock block = scan.found[i];
        uchar* scores = scan.plane + (block.y - scan.top) * scan.planeStep + block.x;
        block.columns &=
            Vectors::storeGreater(scores, Vectors::load(scores), Vectors::load(floors + block.x));
        corners += countBits(block.columns);
        *left = block;
        left += block.columns != 0;
    }
    scan.foundCount = int(left - scan.found);
    return corners;
}

}  // namespace

void scanWidths(int widths[SCAN_WIDTHS])
{
    widths[0] = widths[1] = widths[2] = 1;
#if CV_SIMD
    widths[0] = AQORB_LANES(Wide::V);
    widths[1] = AQORB_LANES(Narrow::V);
#endif
}

void continueScan(FastScan& scan, int end)
{
#if CV_SIMD
    if (scan.blockWidth == AQORB_LANES(Wide::V))
        return scanRows<Wide>(scan, end);
    if (scan.blockWidth == AQORB_LANES(Narrow::V))
        return scanRows<Narrow>(scan, end);
#endif
    scanRows<Single>(scan, end);
}

int dropCorners(FastScan& scan, int first, const uchar* floors)
{
#if CV_SIMD
    if (scan.blockWidth == AQORB_LANES(Wide::V))
        return dropFromBlocks<Wide>(scan, first, floors);
    if (scan.blockWidth == AQORB_LANES(Narrow::V))
        return dropFromBlocks<Narrow>(scan, first, floors);
#endif
    return dropFromBlocks<Single>(scan, first, floors);
}

void neighborScores(const uchar* p, ptrdiff_t step, int lane, int scores[3][3])
{
    for (int row = 0; row < 3; row++)
    {
        const uchar* q = p + (row - 1) * step - 1;
#if CV_SIMD
        Circle<v_uint8x16> circle;
        loadCircle<Narrow>(q - lane, step, circle);
        uchar bright[16], dark[16];
        v_store(bright, bestArc<Least, Greatest>(circle));
        v_store(dark, bestArc<Greatest, Least>(circle));
        for (int i = 0; i < 3; i++)
            scores[row][i] = Greatest::of(bright[lane + i] - q[i], q[i] - dark[lane + i]);
#else
        (void)lane;
        for (int i = 0; i < 3; i++)
            scores[row][i] = scoreOfPixel(q + i, step);
#endif
    }
}

#endif  // CV_CPU_OPTIMIZATION_DECLARATIONS_ONLY

CV_CPU_OPTIMIZATION_NAMESPACE_END

}  // namespace stages
}  // namespace aqorb
}  // namespace cv
