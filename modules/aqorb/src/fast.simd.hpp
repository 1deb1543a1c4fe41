// This file is part of the aqorb project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.

#include "kernels.hpp"
#include "simd_compat.hpp"

#include <cstring>

// Raw pointers and plain structs only: a file compiled for an ISA must not emit functions that others
// may link to.

namespace cv
{
namespace aqorb
{
namespace stages
{

CV_CPU_OPTIMIZATION_NAMESPACE_BEGIN

//! How many pixels a block may have, the widest first; the last is 1, which serves where the others do not fit.
void scanWidths(int widths[SCAN_WIDTHS]);

//! Continues a scan until the rows before `end`, at most scan.bottom, are done.
void continueScan(FastScan& scan, int end);

/** Drops corners, from the blocks found last and from the plane.
 @param first of the found blocks
 @param floors by column: the scores that are too low
 @return number of corners left; scan.foundCount is that of the blocks that have any */
int dropCorners(FastScan& scan, int first, const uchar* floors);

/** cornerScore of the pixels (-1 .. 1, -1 .. 1) around p.
 @param lane 0 to 13, the place of column -1 in vectors of 16; 3 pixels around these must be readable */
void neighborScores(const uchar* p, ptrdiff_t step, int lane, int scores[3][3]);

#ifndef CV_CPU_OPTIMIZATION_DECLARATIONS_ONLY

namespace
{

// min for the bright side, max for the dark one
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

// The circle's pixels of all lanes, clockwise or not does not matter.
template <typename V> struct Circle
{
    V at[16];
};

// The `Outer` over the 16 arcs of the `Inner` over their 9 pixels. With odd j, b[j] is over pixels j and
// j + 1 and c[j] over j to j + 3; the arc that begins at k has pixels k + 1 to k + 8 in common with that
// from k + 1, and the two arcs' other pixels are k and k + 9. Arcs from k and k + 4 have c[k + 5] in
// common, too.
template <typename Inner, typename Outer, typename V> CV_ALWAYS_INLINE V bestArc(const Circle<V>& circle)
{
    const V* x = circle.at;
    V b[8], c[8], ends[8];  // of index j = 2 i + 1; ends of k = 2 i
    for (int i = 0; i < 8; i++)
        b[i] = Inner::of(x[2 * i + 1], x[(2 * i + 2) & 15]);
    for (int i = 0; i < 8; i++)
        c[i] = Inner::of(b[i], b[(i + 1) & 7]);
    for (int i = 0; i < 8; i++)
        ends[i] = Outer::of(x[2 * i], x[(2 * i + 9) & 15]);
    V best[4];
    for (int i = 0; i < 4; i++)
    {
        const int k = (i & 1) + (i >> 1) * 4;  // 0, 1, 4, 5: with k + 2 all eight
        best[i] = Inner::of(c[(k + 2) & 7], Outer::of(Inner::of(c[k], ends[k]),
                                                      Inner::of(c[(k + 4) & 7], ends[(k + 2) & 7])));
    }
    return Outer::of(Outer::of(best[0], best[1]), Outer::of(best[2], best[3]));
}

// One pixel, where vectors do not fit or there are none.
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
    // Stores a where it is greater than b, else 0, and returns where it is.
    static CV_ALWAYS_INLINE uint64 storeGreater(uchar* p, const V& a, const V& b)
    {
        v_store(p, v_and(a, v_gt(a, b)));
        return maskGreater(a, b);
    }
};
// The widest vectors, and narrow ones for what these do not fit into.
struct Wide : Lanes<v_uint8>
{
    static CV_ALWAYS_INLINE V load(const uchar* p) { return vx_load(p); }
    static CV_ALWAYS_INLINE V all(int value) { return vx_setall_u8(uchar(value)); }
    static CV_ALWAYS_INLINE V whereZero(const V& a) { return v_eq(a, all(0)); }
#if CV_AVX512_SKX && CV_SIMD_WIDTH == 64
    // Comparisons give masks; vectors made of these would have to be made masks again.
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

// Scores the blocks of a row: the FAST score where it exceeds the threshold, 1 to 255, else 0. Lists the
// blocks that hold a corner and returns their number.
template <typename Vectors> int scoreRow(const FastScan& scan, int y)
{
    typedef typename Vectors::V V;
    const uchar* row = scan.image + y * scan.step;
    const ptrdiff_t step = scan.step;
    uchar* scores = scoresOf(scan, y);
    int* list = scan.listed[y & 1];
    const V zero = Vectors::all(0), limit = Vectors::all(scan.threshold);
    int possible = 0, count = 0;
    // Every arc holds one end of each axis. Mostly few blocks have a pixel where these allow a corner; where most
    // blocks of the row above have one, it is not worth a look.
    const bool mayBeMost = 4 * scan.listedCount[(y - 1) & 1] > 3 * scan.blockCount;
    for (int i = 0; i < scan.blockCount; i++)
    {
        list[possible] = i;
        if (mayBeMost)
        {
            possible++;
            continue;
        }
        const int x = scan.blocks[i].x;
        const uchar* p = row + x;
        const V v = Vectors::load(p), up = Vectors::load(p - 3 * step), down = Vectors::load(p + 3 * step),
                left = Vectors::load(p - 3), right = Vectors::load(p + 3);
        Vectors::store(scores + x, zero);  // here, so that compilers do not load the pixels once more
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

// The corners of a row of scores are those that are higher than their eight neighbours: their scores go to
// the plane, their blocks to those found.
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
        // Also of columns that are not wanted: dropCorners clears these.
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
