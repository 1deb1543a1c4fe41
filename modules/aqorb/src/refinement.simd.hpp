// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// The alignment of patches: a vector has a number of several matches, one in each lane. So each match is computed in
// the same order on every CPU, however many lanes there are.

#include "refinement.hpp"
#include "simd_compat.hpp"

namespace cv
{
namespace aqorb
{
CV_CPU_OPTIMIZATION_NAMESPACE_BEGIN

//! As alignPatches.
void alignByLanes(const PatchPair* pairs, int count, Alignment* alignments);

#ifndef CV_CPU_OPTIMIZATION_DECLARATIONS_ONLY

namespace
{

#if CV_SIMD

typedef v_float32 Floats;
const int LANES = CV_SIMD_WIDTH / 4;

CV_ALWAYS_INLINE Floats all(float a)
{
    return vx_setall_f32(a);
}
CV_ALWAYS_INLINE Floats load(const float* a)
{
    return vx_load(a);
}
// The whole part of positive numbers, and the rest.
CV_ALWAYS_INLINE v_int32 wholePart(Floats& a)
{
    const v_int32 whole = v_trunc(a);
    a = v_sub(a, v_cvt_f32(whole));
    return whole;
}
CV_ALWAYS_INLINE void storeOffsets(const v_int32& x, const v_int32& y, const int* steps, int* offsets)
{
    v_store(offsets, v_add(v_mul(y, vx_load(steps)), x));
}
// Byte I of each number.
template <int I> CV_ALWAYS_INLINE Floats byteOf(const unsigned* numbers)
{
    const v_uint32 shifted = v_shr<8 * I>(vx_load(numbers));
    return v_cvt_f32(v_reinterpret_as_s32(v_and(shifted, vx_setall_u32(255))));
}
// OpenCV's division and root are approximate on 32-bit ARM.
CV_ALWAYS_INLINE Floats quotient(const Floats& a, const Floats& b)
{
#if CV_NEON && !defined(__aarch64__) && !defined(_M_ARM64)
    float numerators[LANES], denominators[LANES];
    v_store(numerators, a);
    v_store(denominators, b);
    for (int i = 0; i < LANES; i++)
        numerators[i] /= denominators[i];
    return vx_load(numerators);
#else
    return v_div(a, b);
#endif
}
CV_ALWAYS_INLINE Floats root(const Floats& a)
{
#if CV_NEON && !defined(__aarch64__) && !defined(_M_ARM64)
    float values[LANES];
    v_store(values, a);
    for (int i = 0; i < LANES; i++)
        values[i] = std::sqrt(values[i]);
    return vx_load(values);
#else
    return v_sqrt(a);
#endif
}

#else

// One lane, where there are no vectors. A comparison gives 1 or 0.
typedef float Floats;
const int LANES = 1;

CV_ALWAYS_INLINE float all(float a)
{
    return a;
}
CV_ALWAYS_INLINE float load(const float* a)
{
    return *a;
}
CV_ALWAYS_INLINE void v_store(float* out, float a)
{
    *out = a;
}
CV_ALWAYS_INLINE float v_add(float a, float b)
{
    return a + b;
}
CV_ALWAYS_INLINE float v_sub(float a, float b)
{
    return a - b;
}
CV_ALWAYS_INLINE float v_mul(float a, float b)
{
    return a * b;
}
CV_ALWAYS_INLINE float v_abs(float a)
{
    return std::abs(a);
}
CV_ALWAYS_INLINE float v_gt(float a, float b)
{
    return a > b;
}
CV_ALWAYS_INLINE float v_and(float a, float b)
{
    return a != 0 ? b : 0;
}
CV_ALWAYS_INLINE float quotient(float a, float b)
{
    return a / b;
}
CV_ALWAYS_INLINE float root(float a)
{
    return std::sqrt(a);
}
CV_ALWAYS_INLINE int wholePart(float& a)
{
    const int whole = int(a);
    a -= float(whole);
    return whole;
}
CV_ALWAYS_INLINE void storeOffsets(int x, int y, const int* steps, int* offsets)
{
    *offsets = y * *steps + x;
}
template <int I> CV_ALWAYS_INLINE float byteOf(const unsigned* numbers)
{
    return float(*numbers >> (8 * I) & 255);
}

#endif

// a * b + c, rounded twice on every CPU.
CV_ALWAYS_INLINE Floats plus(const Floats& c, const Floats& a, const Floats& b)
{
    return v_add(c, v_mul(a, b));
}
CV_ALWAYS_INLINE Floats minus(const Floats& c, const Floats& a, const Floats& b)
{
    return v_sub(c, v_mul(a, b));
}

// The places of one patch of each lane.
struct Places
{
    void set(int lane, const PatchPlace& place)
    {
        origins[lane] = place.origin;
        steps[lane] = place.step;
        x[lane] = place.x;
        y[lane] = place.y;
        right[lane] = place.right;
        bottom[lane] = place.bottom;
    }
    const uchar* origins[LANES];
    int steps[LANES];
    float x[LANES], y[LANES], right[LANES], bottom[LANES];
};

// Sample (u, v) lies at (x + xu * u + xv * v, y + yu * u + yv * v).
struct AffineMap
{
    // Maps the lanes that are not set to the origin.
    void keep(const Floats& lanes)
    {
        for (Floats* number : {&x, &y, &xu, &xv, &yu, &yv})
            *number = v_and(lanes, *number);
    }
    Floats determinant() const { return minus(v_mul(xu, yv), xv, yu); }
    Floats x, y, xu, xv, yu, yv;
};

// The lanes in which a square of samples lies inside of the image, but none where a number is not finite.
template <int RADIUS> CV_ALWAYS_INLINE Floats isInside(const AffineMap& map, const Places& places)
{
    const Floats reachX = v_mul(all(RADIUS), v_add(v_abs(map.xu), v_abs(map.xv)));
    const Floats reachY = v_mul(all(RADIUS), v_add(v_abs(map.yu), v_abs(map.yv)));
    return v_and(v_and(v_gt(v_sub(map.x, reachX), all(0)), v_gt(load(places.right), v_add(map.x, reachX))),
                 v_and(v_gt(v_sub(map.y, reachY), all(0)), v_gt(load(places.bottom), v_add(map.y, reachY))));
}

// Samples (u, v) of all lanes for u from -RADIUS to RADIUS, bilinearly.
template <int RADIUS>
CV_ALWAYS_INLINE void sampleRow(const Places& places, const AffineMap& map, int v, float* samples)
{
    const int COUNT = 2 * RADIUS + 1;
    CV_DECL_ALIGNED(CACHE_LINE) float restX[COUNT * LANES], restY[COUNT * LANES];
    CV_DECL_ALIGNED(CACHE_LINE) int offsets[COUNT * LANES];
    CV_DECL_ALIGNED(CACHE_LINE) unsigned squares[COUNT * LANES];  // of 2 x 2 pixels
    const Floats rowX = plus(map.x, map.xv, all(float(v))), rowY = plus(map.y, map.yv, all(float(v)));
    for (int i = 0; i < COUNT; i++)
    {
        Floats x = plus(rowX, map.xu, all(float(i - RADIUS))), y = plus(rowY, map.yu, all(float(i - RADIUS)));
        storeOffsets(wholePart(x), wholePart(y), places.steps, offsets + i * LANES);
        v_store(restX + i * LANES, x);
        v_store(restY + i * LANES, y);
    }
    for (int i = 0; i < COUNT * LANES; i += LANES)
    {
        for (int lane = 0; lane < LANES; lane++)
        {
            const uchar* const upper = places.origins[lane] + offsets[i + lane];
            const uchar* const lower = upper + places.steps[lane];
            squares[i + lane] = unsigned(upper[0]) | unsigned(upper[1]) << 8 | unsigned(lower[0]) << 16 |
                                unsigned(lower[1]) << 24;
        }
    }
    for (int i = 0; i < COUNT * LANES; i += LANES)
    {
        const Floats x = load(restX + i), y = load(restY + i);
        const Floats a = byteOf<0>(squares + i), b = byteOf<1>(squares + i), c = byteOf<2>(squares + i),
                     d = byteOf<3>(squares + i);
        const Floats upper = plus(a, x, v_sub(b, a)), lower = plus(c, x, v_sub(d, c));
        v_store(samples + i, plus(upper, y, v_sub(lower, upper)));
    }
}

const int SIDE = 2 * PATCH_RADIUS + 1, WIDE = SIDE + 2;
const float SAMPLES = SIDE * SIDE;
const int UNKNOWNS = 6;  // of the affine map: d x / d u, d x / d v, x, and those of y

// The first patch of each lane, with one more sample on each side, and the normal equations of its alignment. Gain and
// bias are eliminated.
struct Template
{
    float samples[WIDE * WIDE * LANES];  // less the mean
    Floats mean, squares;                // the sum of the squares
    Floats gradients[UNKNOWNS];          // the sums of the derivatives
    Floats products[UNKNOWNS];           // the sums of the derivatives times the samples
    Floats lower[UNKNOWNS][UNKNOWNS];    // the Cholesky decomposition L D L^T; of L below the diagonal
    Floats inverses[UNKNOWNS];           // of D

    const float* at(int u, int v) const
    {
        return samples + ((v + PATCH_RADIUS + 1) * WIDE + u + PATCH_RADIUS + 1) * LANES;
    }
    // Central differences.
    Floats dx(const float* p) const { return v_mul(all(0.5f), v_sub(load(p + LANES), load(p - LANES))); }
    Floats dy(const float* p) const
    {
        return v_mul(all(0.5f), v_sub(load(p + WIDE * LANES), load(p - WIDE * LANES)));
    }

    void sample(const Places& places, const AffineMap& map)
    {
        for (int v = 0; v < WIDE; v++)
            sampleRow<PATCH_RADIUS + 1>(places, map, v - PATCH_RADIUS - 1, samples + v * WIDE * LANES);
        Floats sum = all(0);
        for (int v = -PATCH_RADIUS; v <= PATCH_RADIUS; v++)
            for (int u = -PATCH_RADIUS; u <= PATCH_RADIUS; u++)
                sum = v_add(sum, load(at(u, v)));
        mean = v_mul(sum, all(1 / SAMPLES));
        for (int i = 0; i < WIDE * WIDE * LANES; i += LANES)
            v_store(samples + i, v_sub(load(samples + i), mean));
    }

    // Sums over the samples. The derivative by an unknown is dx or dy, times u, v or 1.
    void sum()
    {
        const Floats zero = all(0);
        Floats second[3][6];  // of dx dx, dx dy, dy dy, each times 1, u, v, uu, uv, vv
        Floats first[4][3];   // of dx, dy, dx times the sample, dy times the sample, each times 1, u, v
        for (auto& of : second)
            for (Floats& s : of)
                s = zero;
        for (auto& of : first)
            for (Floats& s : of)
                s = zero;
        squares = zero;
        for (int v = -PATCH_RADIUS; v <= PATCH_RADIUS; v++)
        {
            Floats row2[3][3], row1[4][2];  // times powers of u
            for (auto& of : row2)
                for (Floats& s : of)
                    s = zero;
            for (auto& of : row1)
                for (Floats& s : of)
                    s = zero;
            for (int u = -PATCH_RADIUS; u <= PATCH_RADIUS; u++)
            {
                const float* const p = at(u, v);
                const Floats t = load(p), x = dx(p), y = dy(p), times = all(float(u));
                squares = plus(squares, t, t);
                const Floats seconds[] = {v_mul(x, x), v_mul(x, y), v_mul(y, y)};
                const Floats firsts[] = {x, y, v_mul(x, t), v_mul(y, t)};
                for (int k = 0; k < 3; k++)
                {
                    const Floats byU = v_mul(times, seconds[k]);
                    row2[k][0] = v_add(row2[k][0], seconds[k]);
                    row2[k][1] = v_add(row2[k][1], byU);
                    row2[k][2] = plus(row2[k][2], times, byU);
                }
                for (int k = 0; k < 4; k++)
                {
                    row1[k][0] = v_add(row1[k][0], firsts[k]);
                    row1[k][1] = plus(row1[k][1], times, firsts[k]);
                }
            }
            const Floats times = all(float(v)), square = all(float(v * v));
            for (int k = 0; k < 3; k++)
            {
                second[k][0] = v_add(second[k][0], row2[k][0]);
                second[k][1] = v_add(second[k][1], row2[k][1]);
                second[k][2] = plus(second[k][2], times, row2[k][0]);
                second[k][3] = v_add(second[k][3], row2[k][2]);
                second[k][4] = plus(second[k][4], times, row2[k][1]);
                second[k][5] = plus(second[k][5], square, row2[k][0]);
            }
            for (int k = 0; k < 4; k++)
            {
                first[k][0] = v_add(first[k][0], row1[k][0]);
                first[k][1] = v_add(first[k][1], row1[k][1]);
                first[k][2] = plus(first[k][2], times, row1[k][0]);
            }
        }
        // An unknown is multiplied by u, v or 1; the product of two of them by one of six.
        static const int FACTOR[] = {1, 2, 0}, PRODUCT[3][3] = {{3, 4, 1}, {4, 5, 2}, {1, 2, 0}};
        for (int i = 0; i < UNKNOWNS; i++)
        {
            gradients[i] = first[i / 3][FACTOR[i % 3]];
            products[i] = first[2 + i / 3][FACTOR[i % 3]];
        }
        const Floats inverse = quotient(all(1), squares);
        for (int i = 0; i < UNKNOWNS; i++)
        {
            for (int j = 0; j <= i; j++)
            {
                const Floats sum = second[i / 3 + j / 3][PRODUCT[i % 3][j % 3]];
                const Floats byBias = v_mul(v_mul(gradients[i], gradients[j]), all(1 / SAMPLES));
                const Floats byGain = v_mul(v_mul(products[i], products[j]), inverse);
                lower[i][j] = v_sub(v_sub(sum, byBias), byGain);
            }
        }
    }

    void decompose()
    {
        for (int i = 0; i < UNKNOWNS; i++)
        {
            for (int j = 0; j < i; j++)
                for (int k = 0; k < j; k++)
                    lower[i][j] = minus(lower[i][j], lower[i][k], lower[j][k]);  // L D is in place of L
            for (int k = 0; k < i; k++)
            {
                const Floats scaled = lower[i][k];
                lower[i][k] = v_mul(scaled, inverses[k]);
                lower[i][i] = minus(lower[i][i], scaled, lower[i][k]);
            }
            inverses[i] = quotient(all(1), lower[i][i]);
        }
    }

    void solve(Floats* right) const
    {
        for (int i = 0; i < UNKNOWNS; i++)
            for (int k = 0; k < i; k++)
                right[i] = minus(right[i], lower[i][k], right[k]);
        for (int i = UNKNOWNS - 1; i >= 0; i--)
        {
            right[i] = v_mul(right[i], inverses[i]);
            for (int k = i + 1; k < UNKNOWNS; k++)
                right[i] = minus(right[i], lower[k][i], right[k]);
        }
    }
};

// Sums over the second patch, whose samples are taken less the mean of the template.
struct PatchSums
{
    Floats sum, squares, product;  // product: with the samples of the template
    Floats right[UNKNOWNS];        // with the derivatives

    void add(const Template& first, const Places& places, const AffineMap& map)
    {
        sum = squares = product = all(0);
        for (Floats& r : right)
            r = all(0);
        for (int v = -PATCH_RADIUS; v <= PATCH_RADIUS; v++)
        {
            CV_DECL_ALIGNED(CACHE_LINE) float samples[SIDE * LANES];
            sampleRow<PATCH_RADIUS>(places, map, v, samples);
            Floats x = all(0), y = x, xu = x, yu = x;
            for (int u = -PATCH_RADIUS; u <= PATCH_RADIUS; u++)
            {
                const float* const p = first.at(u, v);
                const Floats s = v_sub(load(samples + (u + PATCH_RADIUS) * LANES), first.mean);
                sum = v_add(sum, s);
                squares = plus(squares, s, s);
                product = plus(product, s, load(p));
                const Floats byX = v_mul(s, first.dx(p)), byY = v_mul(s, first.dy(p));
                x = v_add(x, byX);
                y = v_add(y, byY);
                xu = plus(xu, all(float(u)), byX);
                yu = plus(yu, all(float(u)), byY);
            }
            const Floats row[] = {xu, v_mul(all(float(v)), x), x, yu, v_mul(all(float(v)), y), y};
            for (int i = 0; i < UNKNOWNS; i++)
                right[i] = v_add(right[i], row[i]);
        }
        // Less the mean of the patch itself.
        squares = minus(squares, sum, v_mul(sum, all(1 / SAMPLES)));
    }

    // The right side of the normal equations, from which gain and bias are eliminated, with the patch scaled to the
    // norm of the template.
    void normalize(const Template& first)
    {
        const Floats scale = root(quotient(first.squares, squares));
        const Floats bias = v_mul(sum, all(1 / SAMPLES)), gain = quotient(product, first.squares);
        for (int i = 0; i < UNKNOWNS; i++)
            right[i] =
                v_mul(scale, minus(minus(right[i], first.gradients[i], bias), first.products[i], gain));
    }
};

// The map after the inverse of a change: the first patch, changed so, looks like the second one.
CV_ALWAYS_INLINE void composeInverse(const Floats* change, AffineMap& map)
{
    const Floats a = v_add(all(1), change[0]), b = change[1], c = change[3], d = v_add(all(1), change[4]);
    const Floats inverse = quotient(all(1), minus(v_mul(a, d), b, c));
    const Floats xu = v_mul(inverse, minus(v_mul(map.xu, d), map.xv, c));
    const Floats xv = v_mul(inverse, minus(v_mul(map.xv, a), map.xu, b));
    const Floats yu = v_mul(inverse, minus(v_mul(map.yu, d), map.yv, c));
    const Floats yv = v_mul(inverse, minus(v_mul(map.yv, a), map.yu, b));
    map.x = minus(minus(map.x, xu, change[2]), xv, change[5]);
    map.y = minus(minus(map.y, yu, change[2]), yv, change[5]);
    map.xu = xu;
    map.xv = xv;
    map.yu = yu;
    map.yv = yv;
}

// Aligns the patches of LANES matches. Lanes that cannot be aligned go on with the pixel at the origin.
void alignLanes(const PatchPair* const* pairs, Alignment* alignments)
{
    const int STEPS = 4;
    Places places[2];
    CV_DECL_ALIGNED(CACHE_LINE) float spacings[LANES], maps[4][LANES];
    for (int lane = 0; lane < LANES; lane++)
    {
        places[0].set(lane, pairs[lane]->first);
        places[1].set(lane, pairs[lane]->second);
        spacings[lane] = pairs[lane]->spacing;
        for (int i = 0; i < 4; i++)
            maps[i][lane] = pairs[lane]->map[i];
    }
    const Floats spacing = load(spacings);
    AffineMap map = {load(places[0].x), load(places[0].y), spacing, all(0), all(0), spacing};
    Floats isAligned = isInside<PATCH_RADIUS + 1>(map, places[0]);
    map.keep(isAligned);
    Template first;
    first.sample(places[0], map);
    first.sum();
    first.decompose();
    const Floats minSquares = all(MIN_PATCH_VARIANCE * SAMPLES);
    isAligned = v_and(isAligned, v_gt(first.squares, minSquares));

    map = {load(places[1].x), load(places[1].y), load(maps[0]), load(maps[1]), load(maps[2]), load(maps[3])};
    const AffineMap start = map;
    PatchSums sums;
    for (int step = 0;; step++)
    {
        isAligned = v_and(isAligned, isInside<PATCH_RADIUS>(map, places[1]));
        map.keep(isAligned);
        sums.add(first, places[1], map);
        if (step == STEPS)
            break;
        sums.normalize(first);
        first.solve(sums.right);
        composeInverse(sums.right, map);
    }
    isAligned = v_and(isAligned, v_gt(sums.squares, minSquares));

    const Floats x = v_sub(map.x, start.x), y = v_sub(map.y, start.y);
    const Floats before = v_abs(start.determinant()), after = v_abs(map.determinant());
    const Floats maxShift = v_mul(all(MAX_PATCH_SHIFT * MAX_PATCH_SHIFT), before);
    isAligned = v_and(isAligned, v_gt(maxShift, plus(v_mul(x, x), y, y)));
    isAligned = v_and(isAligned, v_and(v_gt(v_mul(all(MAX_AREA_CHANGE), before), after),
                                       v_gt(v_mul(all(MAX_AREA_CHANGE), after), before)));
    const Floats correlation = quotient(sums.product, root(v_mul(first.squares, sums.squares)));
    // Those that are not aligned have 0, and become NOT_ALIGNED.
    CV_DECL_ALIGNED(CACHE_LINE) float results[4][LANES];
    v_store(results[0], map.x);
    v_store(results[1], map.y);
    v_store(results[2], v_and(isAligned, correlation));
    v_store(results[3], v_and(isAligned, all(1)));
    for (int lane = 0; lane < LANES; lane++)
        alignments[lane] = {results[0][lane], results[1][lane],
                            results[3][lane] != 0 ? results[2][lane] : NOT_ALIGNED};
}

}  // namespace

void alignByLanes(const PatchPair* pairs, int count, Alignment* alignments)
{
    for (int i = 0; i < count; i += LANES)
    {
        const PatchPair* ofLanes[LANES];
        Alignment found[LANES];
        for (int lane = 0; lane < LANES; lane++)
            ofLanes[lane] = pairs + (i + lane < count ? i + lane : count - 1);
        alignLanes(ofLanes, found);
        for (int lane = 0; lane < LANES && i + lane < count; lane++)
            alignments[i + lane] = found[lane];
    }
}

#endif  // CV_CPU_OPTIMIZATION_DECLARATIONS_ONLY

CV_CPU_OPTIMIZATION_NAMESPACE_END
}  // namespace aqorb
}  // namespace cv
