// This file is part of the aqorb project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.

#include "kernels.hpp"
#include "simd_compat.hpp"

// Raw pointers and plain structs only: a file compiled for an ISA must not emit functions that others
// may link to.

namespace cv
{
namespace aqorb
{
namespace stages
{

CV_CPU_OPTIMIZATION_NAMESPACE_BEGIN

//! How many pixels a block may have: the widest, and what serves where these do not fit.
void scanWidths(int widths[2]);

/** Continues a scan until it is finished or there is no room for the corners of another row.
 @param capacity at least the number of blocks times half their width, and SCAN_OVERSHOOT
 @return number of strong corners written, in raster order */
int continueScan(FastScan& scan, Corner* corners, int capacity);

/** Writes those of weak corners that are wanted.
 @param wanted by block, as ScanBlock's
 @param scores as FastScan's, but from row 0 on
 @param corners room for half the blocks' width each, and SCAN_OVERSHOOT
 @return number of corners written, in the order given */
int writeWanted(const WeakCorners* weak, int count, const ScanBlock* blocks, const uint64* wanted,
                const uchar* scores, ptrdiff_t scoreStep, Corner* corners);

//! cornerScore of the pixels (-1 .. 1, -1 .. 1) around p. Readable must be 4 around and 20 to the right.
void neighborScores(const uchar* p, ptrdiff_t step, int scores[3][3]);

#ifndef CV_CPU_OPTIMIZATION_DECLARATIONS_ONLY

namespace
{

#if CV_SIMD

// min for the bright side, max for the dark one
struct Least
{
    template <typename V> static CV_ALWAYS_INLINE V of(const V& a, const V& b) { return v_min(a, b); }
};
struct Greatest
{
    template <typename V> static CV_ALWAYS_INLINE V of(const V& a, const V& b) { return v_max(a, b); }
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

// The widest vectors, and narrow ones for what these do not fit into.
struct Wide
{
    typedef v_uint8 V;
    static CV_ALWAYS_INLINE V load(const uchar* p) { return vx_load(p); }
    static CV_ALWAYS_INLINE V all(int value) { return vx_setall_u8(uchar(value)); }
#if CV_AVX512_SKX && CV_SIMD_WIDTH == 64
    // Comparisons give masks; vectors made of these would have to be made masks again.
    static CV_ALWAYS_INLINE bool anyGreater(const V& a, const V& b)
    {
        return _mm512_cmpgt_epu8_mask(a.val, b.val) != 0;
    }
    static CV_ALWAYS_INLINE bool storeGreater(uchar* p, const V& a, const V& b)
    {
        const __mmask64 greater = _mm512_cmpgt_epu8_mask(a.val, b.val);
        _mm512_storeu_si512(p, _mm512_maskz_mov_epi8(greater, a.val));
        return greater != 0;
    }
    static CV_ALWAYS_INLINE uint64 maskGreater(const V& a, const V& b)
    {
        return _mm512_cmpgt_epu8_mask(a.val, b.val);
    }
#else
    static CV_ALWAYS_INLINE bool anyGreater(const V& a, const V& b)
    {
        return v_check_any(v_gt(a, b));
    }
    // Stores a where it is greater than b, else 0; whether it is anywhere.
    static CV_ALWAYS_INLINE bool storeGreater(uchar* p, const V& a, const V& b)
    {
        const V greater = v_gt(a, b);
        v_store(p, v_and(a, greater));
        return v_check_any(greater);
    }
    static CV_ALWAYS_INLINE uint64 maskGreater(const V& a, const V& b)
    {
        return uint64(v_signmask(v_gt(a, b)));  // the caller drops the bits above the lanes
    }
#endif
};
struct Narrow
{
    typedef v_uint8x16 V;
    static CV_ALWAYS_INLINE V load(const uchar* p) { return v_load(p); }
    static CV_ALWAYS_INLINE V all(int value) { return v_setall_u8(uchar(value)); }
    static CV_ALWAYS_INLINE bool anyGreater(const V& a, const V& b) { return v_check_any(v_gt(a, b)); }
    static CV_ALWAYS_INLINE bool storeGreater(uchar* p, const V& a, const V& b)
    {
        const V greater = v_gt(a, b);
        v_store(p, v_and(a, greater));
        return v_check_any(greater);
    }
};

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

#endif

// The score of one pixel, for what is too narrow for vectors.
int scoreOfPixel(const uchar* p, ptrdiff_t step)
{
    const ptrdiff_t offsets[16] = {
        3 * step,  3 * step + 1,  2 * step + 2,  step + 3,  3,  -step + 3, -2 * step + 2, -3 * step + 1,
        -3 * step, -3 * step - 1, -2 * step - 2, -step - 3, -3, step - 3,  2 * step - 2,  3 * step - 1};
    int score = -255;
    for (int first = 0; first < 16; first++)
    {
        int least = 255, greatest = 0;
        for (int i = first; i < first + 9; i++)
        {
            const int v = p[offsets[i & 15]];
            least = v < least ? v : least;
            greatest = v > greatest ? v : greatest;
        }
        score = least - p[0] > score ? least - p[0] : score;
        score = p[0] - greatest > score ? p[0] - greatest : score;
    }
    return score;
}

CV_ALWAYS_INLINE uchar* scoresOf(const FastScan& scan, int y)
{
    return scan.scores + (y - scan.top + 1) * scan.scoreStep;
}

#if CV_SIMD
template <typename Vectors> CV_ALWAYS_INLINE int scoreBlocks(const FastScan& scan, int y)
{
    typedef typename Vectors::V V;
    const uchar* row = scan.image + y * scan.step;
    const ptrdiff_t step = scan.step;
    uchar* scores = scoresOf(scan, y);
    int* list = scan.listed[y & 1];
    const V zero = Vectors::all(0), limit = Vectors::all(scan.threshold);
    int possible = 0, count = 0;
    // Every arc holds one end of each axis. Most blocks have no pixel where these allow a corner.
    for (int i = 0; i < scan.blockCount; i++)
    {
        const int x = scan.blocks[i].x;
        const uchar* p = row + x;
        const V v = Vectors::load(p), up = Vectors::load(p - 3 * step), down = Vectors::load(p + 3 * step),
                left = Vectors::load(p - 3), right = Vectors::load(p + 3);
        v_store(scores + x, zero);  // here, so that compilers do not load the pixels once more
        const V bright = v_min(v_max(up, down), v_max(left, right));
        const V dark = v_max(v_min(up, down), v_min(left, right));
        const V bound = v_max(v_sub(bright, v), v_sub(v, dark));
        list[possible] = i;
        possible += Vectors::anyGreater(bound, limit);
    }
    for (int i = 0; i < possible; i++)
    {
        const int x = scan.blocks[list[i]].x;
        const uchar* p = row + x;
        Circle<V> circle;
        loadCircle<Vectors>(p, step, circle);
        const V v = Vectors::load(p);
        const V bright = v_sub(bestArc<Least, Greatest>(circle), v);
        const V dark = v_sub(v, bestArc<Greatest, Least>(circle));
        list[count] = list[i];
        count += Vectors::storeGreater(scores + x, v_max(bright, dark), limit);
    }
    return count;
}
#endif

// Scores the blocks of a row: the FAST score where it exceeds the threshold, 1 to 255, else 0. Lists the
// blocks that hold a corner and returns their number.
int scoreRow(const FastScan& scan, int y)
{
#if CV_SIMD
    if (scan.blockWidth == AQORB_LANES(Wide::V))
        return scoreBlocks<Wide>(scan, y);
    if (scan.blockWidth == AQORB_LANES(Narrow::V))
        return scoreBlocks<Narrow>(scan, y);
#endif
    uchar* scores = scoresOf(scan, y);
    int count = 0;
    for (int i = 0; i < scan.blockCount; i++)
    {
        const int x = scan.blocks[i].x;
        bool any = false;
        for (int j = 0; j < scan.blockWidth; j++)
        {
            const int score = scoreOfPixel(scan.image + y * scan.step + x + j, scan.step);
            scores[x + j] = uchar(score > scan.threshold ? score : 0);
            any |= score > scan.threshold;
        }
        scan.listed[y & 1][count] = i;
        count += any;
    }
    return count;
}

void clearRow(const FastScan& scan, int y)
{
    uchar* scores = scoresOf(scan, y);
    for (int i = 0; i < scan.blockCount; i++)
    {
        for (int j = 0; j < scan.blockWidth; j++)
            scores[scan.blocks[i].x + j] = 0;
    }
}

// Writes the corners of a block from left to right, and returns the place after them.
CV_ALWAYS_INLINE Corner* writeCorners(uint64 columns, int x, int y, const uchar* scores, Corner* out)
{
    while (columns)
    {
        // Several at once, found or not: how many there are is hard to predict.
        for (int j = 0; j < SCAN_OVERSHOOT; j++)
        {
            const int column = x + trailingZeros(columns | uint64(1) << 63);
            out->x = column;
            out->y = y;
            out->score = scores[column] - 1;
            out += columns != 0;
            columns &= columns - 1;
        }
    }
    return out;
}

// The wanted corners of a row of scores are those that are higher than their eight neighbours. Writes the
// strong ones, from left to right, and notes the others.
int suppressRow(FastScan& scan, int y, Corner* corners)
{
    const uchar *scores = scoresOf(scan, y), *above = scores - scan.scoreStep,
                *below = scores + scan.scoreStep;
    const int* listed = scan.listed[y & 1];
    Corner* out = corners;
    WeakCorners* weak = scan.weak + scan.weakCount;
#if CV_SIMD
    const v_uint8 strongest = vx_setall_u8(uchar(scan.strongThreshold));
#endif
    const ScanBlock* blocks = scan.blocks;
    const int count = scan.listedCount[y & 1];
    for (int i = 0; i < count; i++)
    {
        const int x = blocks[listed[i]].x;
        const uchar *s = scores + x, *u = above + x, *d = below + x;
#if CV_SIMD
        const v_uint8 score = vx_load(s);
        const v_uint8 beside = v_max(vx_load(s - 1), vx_load(s + 1));
        const v_uint8 over = v_max(v_max(vx_load(u - 1), vx_load(u)), vx_load(u + 1));
        const v_uint8 under = v_max(v_max(vx_load(d - 1), vx_load(d)), vx_load(d + 1));
        uint64 highest = Wide::maskGreater(score, v_max(beside, v_max(over, under)));
        const uint64 strong = Wide::maskGreater(score, strongest);
#else
        uint64 highest = 0, strong = 0;
        for (int j = 0; j < scan.blockWidth; j++)
        {
            const bool is = s[j] > s[j - 1] && s[j] > s[j + 1] && s[j] > u[j - 1] && s[j] > u[j] &&
                            s[j] > u[j + 1] && s[j] > d[j - 1] && s[j] > d[j] && s[j] > d[j + 1];
            highest |= uint64(is) << j;
            strong |= uint64(s[j] > scan.strongThreshold) << j;
        }
#endif
        highest &= blocks[listed[i]].wanted;
        const uint64 others = highest & ~strong;
        const WeakCorners found = {listed[i], y, others};
        *weak = found;
        weak += others != 0;
        out = writeCorners(highest & strong, x, y, scores, out);
    }
    scan.weakCount = int(weak - scan.weak);
    return int(out - corners);
}

}  // namespace

void scanWidths(int widths[2])
{
#if CV_SIMD
    widths[0] = AQORB_LANES(Wide::V);
    widths[1] = AQORB_LANES(Narrow::V);
#else
    widths[0] = widths[1] = 16;
#endif
}

int continueScan(FastScan& scan, Corner* corners, int capacity)
{
    const int perRow = scan.blockCount * ((scan.blockWidth + 1) / 2) + SCAN_OVERSHOOT;
    int found = 0;
    for (; scan.y <= scan.bottom && found + perRow <= capacity; scan.y++)
    {
        const int y = scan.y;
        scoresOf(scan, y)[scan.left - 1] = scoresOf(scan, y)[scan.right] = 0;
        if (y >= scan.scoredTop && y < scan.scoredBottom)
        {
            scan.listedCount[y & 1] = scoreRow(scan, y);
        }
        else
        {
            clearRow(scan, y);
            scan.listedCount[y & 1] = 0;
        }
        if (y > scan.top)
            found += suppressRow(scan, y - 1, corners + found);
    }
    return found;
}

int writeWanted(const WeakCorners* weak, int count, const ScanBlock* blocks, const uint64* wanted,
                const uchar* scores, ptrdiff_t scoreStep, Corner* corners)
{
    Corner* out = corners;
    for (int i = 0; i < count; i++)
    {
        const int block = weak[i].block, y = weak[i].y;
        out = writeCorners(weak[i].columns & wanted[block], blocks[block].x, y, scores + y * scoreStep, out);
    }
    return int(out - corners);
}

void neighborScores(const uchar* p, ptrdiff_t step, int scores[3][3])
{
    for (int row = 0; row < 3; row++)
    {
        const uchar* q = p + (row - 1) * step - 1;
#if CV_SIMD
        Circle<v_uint8x16> circle;
        loadCircle<Narrow>(q, step, circle);
        uchar bright[16], dark[16];
        v_store(bright, bestArc<Least, Greatest>(circle));
        v_store(dark, bestArc<Greatest, Least>(circle));
        for (int i = 0; i < 3; i++)
        {
            const int b = bright[i] - q[i], d = q[i] - dark[i];
            scores[row][i] = b > d ? b : d;
        }
#else
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
