// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// The alignment of patches: a vector has a number of several matches, one in each lane. So each match is computed in
// the same order on every CPU, however many lanes there are.

#include "lanes.hpp"
#include "refinement.hpp"

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

// The places of one patch of each lane.
struct Places
{
    const uchar* origins[LANES];
    int steps[LANES];
    float x[LANES], y[LANES], right[LANES], bottom[LANES];
};

// Sample (u, v) lies at (x + xu * u + xv * v, y + yu * u + yv * v).
struct AffineMap
{
    // Moves the samples of the lanes that are not set to the origin.
    void keep(const Floats& lanes)
    {
        for (Floats* number : {&x, &y, &xu, &xv, &yu, &yv})
            *number = v_and(lanes, *number);
    }
    Floats determinant() const { return minus(v_mul(xu, yv), xv, yu); }

    Floats x, y, xu, xv, yu, yv;
};

// The lanes in which all samples up to a radius lie inside of the image. Numbers that are not finite do not.
CV_ALWAYS_INLINE Floats isInside(const AffineMap& map, const Places& places, int radius)
{
    const Floats reachX = v_mul(all(float(radius)), v_add(v_abs(map.xu), v_abs(map.xv)));
    const Floats reachY = v_mul(all(float(radius)), v_add(v_abs(map.yu), v_abs(map.yv)));
    return v_and(v_and(v_gt(v_sub(map.x, reachX), all(0)), v_gt(load(places.right), v_add(map.x, reachX))),
                 v_and(v_gt(v_sub(map.y, reachY), all(0)), v_gt(load(places.bottom), v_add(map.y, reachY))));
}

// Samples (u, v) of all lanes for u from -RADIUS to RADIUS, bilinearly.
template <int RADIUS>
CV_ALWAYS_INLINE void sampleRow(const Places& places, const AffineMap& map, int v, float* samples)
{
    const int COUNT = (2 * RADIUS + 1) * LANES;
    CV_DECL_ALIGNED(CACHE_LINE) float fractionsX[COUNT], fractionsY[COUNT];
    CV_DECL_ALIGNED(CACHE_LINE) int offsets[COUNT];
    CV_DECL_ALIGNED(CACHE_LINE) unsigned squares[COUNT];  // of 2 x 2 pixels
    const Floats rowX = plus(map.x, map.xv, all(float(v))), rowY = plus(map.y, map.yv, all(float(v)));
    for (int u = -RADIUS, i = 0; u <= RADIUS; u++, i += LANES)
    {
        const Floats x = plus(rowX, map.xu, all(float(u))), y = plus(rowY, map.yu, all(float(u)));
        const Ints column = v_trunc(x), row = v_trunc(y);
        v_store(offsets + i, v_add(v_mul(row, load(places.steps)), column));
        v_store(fractionsX + i, v_sub(x, v_cvt_f32(column)));
        v_store(fractionsY + i, v_sub(y, v_cvt_f32(row)));
    }
    for (int lane = 0; lane < LANES; lane++)
    {
        const uchar* const origin = places.origins[lane];
        const ptrdiff_t step = places.steps[lane];
        for (int i = lane; i < COUNT; i += LANES)
        {
            const uchar* const upper = origin + offsets[i];
            const uchar* const lower = upper + step;
            squares[i] = unsigned(upper[0] | upper[1] << 8) | unsigned(lower[0] | lower[1] << 8) << 16;
        }
    }
    for (int i = 0; i < COUNT; i += LANES)
    {
        const Floats x = load(fractionsX + i), y = load(fractionsY + i);
        const Floats a = byteOf<0>(squares + i), b = byteOf<1>(squares + i);
        const Floats c = byteOf<2>(squares + i), d = byteOf<3>(squares + i);
        const Floats upper = plus(a, x, v_sub(b, a)), lower = plus(c, x, v_sub(d, c));
        v_store(samples + i, plus(upper, y, v_sub(lower, upper)));
    }
}

const int SIDE = 2 * PATCH_RADIUS + 1, WIDE = SIDE + 2;
const float SAMPLES = SIDE * SIDE;
const int UNKNOWNS = 6;  // of the affine map: the factors of u and v and the shift, in x and then in y

// The first patch of each lane, and the normal equations of its alignment. The derivative by an unknown is dx or dy,
// times u, v or 1.
struct Template
{
    // A sample less the mean, and what follows it by LANES each: dx and dy, which are twice the derivatives.
    const float* at(int u, int v) const { return samples[(v + PATCH_RADIUS) * SIDE + u + PATCH_RADIUS][0]; }

    void sample(const Places& places, const AffineMap& map)
    {
        CV_DECL_ALIGNED(CACHE_LINE) float wide[WIDE * WIDE * LANES];  // with one more sample on each side
        for (int v = 0; v < WIDE; v++)
            sampleRow<PATCH_RADIUS + 1>(places, map, v - PATCH_RADIUS - 1, wide + v * WIDE * LANES);
        const auto inner = [&](int i) { return wide + ((i / SIDE + 1) * WIDE + i % SIDE + 1) * LANES; };
        Floats sum = all(0);
        for (int i = 0; i < SIDE * SIDE; i++)
            sum = v_add(sum, load(inner(i)));
        mean = v_mul(sum, all(1 / SAMPLES));
        for (int i = 0; i < SIDE * SIDE; i++)
        {
            const float* const p = inner(i);
            v_store(samples[i][0], v_sub(load(p), mean));
            v_store(samples[i][1], v_sub(load(p + LANES), load(p - LANES)));
            v_store(samples[i][2], v_sub(load(p + WIDE * LANES), load(p - WIDE * LANES)));
        }
    }

    // Makes the normal equations, from which gain and bias are eliminated.
    void prepare()
    {
        squares = all(0);
        clear(gradients);
        clear(withSample);
        for (auto& row : lower)
            clear(row);
        for (int v = -PATCH_RADIUS; v <= PATCH_RADIUS; v++)
        {
            for (int u = -PATCH_RADIUS; u <= PATCH_RADIUS; u++)
            {
                const float* const p = at(u, v);
                const Floats t = load(p), x = load(p + LANES), y = load(p + 2 * LANES);
                const Floats byU = all(float(u)), byV = all(float(v));
                const Floats derivatives[] = {v_mul(x, byU), v_mul(x, byV), x,
                                              v_mul(y, byU), v_mul(y, byV), y};
                squares = plus(squares, t, t);
                for (int i = 0; i < UNKNOWNS; i++)
                {
                    gradients[i] = v_add(gradients[i], derivatives[i]);
                    withSample[i] = plus(withSample[i], derivatives[i], t);
                    for (int j = 0; j <= i; j++)
                        lower[i][j] = plus(lower[i][j], derivatives[i], derivatives[j]);
                }
            }
        }
        for (int i = 0; i < UNKNOWNS; i++)
        {
            const Floats byBias = v_mul(gradients[i], all(1 / SAMPLES)),
                         byGain = v_div(withSample[i], squares);
            for (int j = 0; j <= i; j++)
                lower[i][j] = minus(minus(lower[i][j], byBias, gradients[j]), byGain, withSample[j]);
        }
        decompose();
    }

    // Cholesky's decomposition L D L^T.
    void decompose()
    {
        for (int i = 0; i < UNKNOWNS; i++)
        {
            for (int j = 0; j < i; j++)
                for (int k = 0; k < j; k++)
                    lower[i][j] = minus(lower[i][j], lower[i][k], lower[j][k]);  // L D as yet
            for (int k = 0; k < i; k++)
            {
                const Floats withD = lower[i][k];
                lower[i][k] = v_mul(withD, inverses[k]);
                lower[i][i] = minus(lower[i][i], withD, lower[i][k]);
            }
            inverses[i] = v_div(all(1), lower[i][i]);
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

    CV_DECL_ALIGNED(CACHE_LINE) float samples[SIDE * SIDE][3][LANES];
    Floats mean, squares;              // squares: the sum of those of the samples
    Floats gradients[UNKNOWNS];        // the sums of the derivatives
    Floats withSample[UNKNOWNS];       // the sums of the derivatives times the samples
    Floats lower[UNKNOWNS][UNKNOWNS];  // L, below the diagonal
    Floats inverses[UNKNOWNS];         // of the elements of D
};

// Sums over the second patch.
struct PatchSums
{
    void add(const Template& first, const Places& places, const AffineMap& map)
    {
        Floats sum = all(0);
        squares = withSample = all(0);
        clear(right);
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
                withSample = plus(withSample, s, load(p));
                const Floats byX = v_mul(s, load(p + LANES)), byY = v_mul(s, load(p + 2 * LANES));
                x = v_add(x, byX);
                y = v_add(y, byY);
                xu = plus(xu, byX, all(float(u)));
                yu = plus(yu, byY, all(float(u)));
            }
            const Floats row[] = {xu, v_mul(x, all(float(v))), x, yu, v_mul(y, all(float(v))), y};
            for (int i = 0; i < UNKNOWNS; i++)
                right[i] = v_add(right[i], row[i]);
        }
        mean = v_mul(sum, all(1 / SAMPLES));
        squares = minus(squares, sum, mean);
    }

    // The right side of the normal equations, with the patch scaled to the norm of the first one.
    void eliminate(const Template& first)
    {
        // Twice, as the derivatives are.
        const Floats scale = v_mul(all(2), v_sqrt(v_div(first.squares, squares)));
        const Floats gain = v_div(withSample, first.squares);
        for (int i = 0; i < UNKNOWNS; i++)
        {
            const Floats rest = minus(minus(right[i], first.gradients[i], mean), first.withSample[i], gain);
            right[i] = v_mul(scale, rest);
        }
    }

    Floats mean, squares;    // mean: less that of the first patch; squares: the sum of those less the mean
    Floats withSample;       // the sum of the products with the samples of the first patch
    Floats right[UNKNOWNS];  // the sums of the products with its derivatives
};

// The map after the inverse of a change: changed so, the first patch would look as the second one does.
CV_ALWAYS_INLINE AffineMap composeInverse(const AffineMap& map, const Floats* change)
{
    const Floats a = v_add(all(1), change[0]), b = change[1], c = change[3], d = v_add(all(1), change[4]);
    const Floats inverse = v_div(all(1), minus(v_mul(a, d), b, c));
    AffineMap changed;
    changed.xu = v_mul(inverse, minus(v_mul(map.xu, d), map.xv, c));
    changed.xv = v_mul(inverse, minus(v_mul(map.xv, a), map.xu, b));
    changed.yu = v_mul(inverse, minus(v_mul(map.yu, d), map.yv, c));
    changed.yv = v_mul(inverse, minus(v_mul(map.yv, a), map.yu, b));
    changed.x = minus(minus(map.x, changed.xu, change[2]), changed.xv, change[5]);
    changed.y = minus(minus(map.y, changed.yu, change[2]), changed.yv, change[5]);
    return changed;
}

// Aligns the patches of LANES matches. Lanes that cannot be aligned go on with the pixels at the origin.
void alignLanes(const PatchPair* const* pairs, Alignment* alignments)
{
    const int STEPS = 3;
    Places places[2];
    CV_DECL_ALIGNED(CACHE_LINE) float spacings[LANES], maps[4][LANES];
    for (int lane = 0; lane < LANES; lane++)
    {
        const PatchPair& pair = *pairs[lane];
        for (int i = 0; i < 2; i++)
        {
            const PatchPlace& place = i == 0 ? pair.first : pair.second;
            places[i].origins[lane] = place.origin;
            places[i].steps[lane] = place.step;
            places[i].x[lane] = place.x;
            places[i].y[lane] = place.y;
            places[i].right[lane] = place.right;
            places[i].bottom[lane] = place.bottom;
        }
        spacings[lane] = pair.spacing;
        for (int i = 0; i < 4; i++)
            maps[i][lane] = pair.map[i];
    }
    const Floats spacing = load(spacings), minSquares = all(MIN_PATCH_VARIANCE * SAMPLES);
    AffineMap map = {load(places[0].x), load(places[0].y), spacing, all(0), all(0), spacing};
    Floats isAligned = isInside(map, places[0], PATCH_RADIUS + 1);
    map.keep(isAligned);
    Template first;
    first.sample(places[0], map);
    first.prepare();
    isAligned = v_and(isAligned, v_gt(first.squares, minSquares));

    const AffineMap start = {load(places[1].x), load(places[1].y), load(maps[0]),
                             load(maps[1]),     load(maps[2]),     load(maps[3])};
    map = start;
    PatchSums second;
    for (int step = 0; step < STEPS; step++)
    {
        isAligned = v_and(isAligned, isInside(map, places[1], PATCH_RADIUS));
        map.keep(isAligned);
        second.add(first, places[1], map);
        second.eliminate(first);
        first.solve(second.right);
        map = composeInverse(map, second.right);
    }
    isAligned = v_and(isAligned, isInside(map, places[1], PATCH_RADIUS));

    const Floats x = v_sub(map.x, start.x), y = v_sub(map.y, start.y);
    const Floats before = v_abs(start.determinant()), after = v_abs(map.determinant());
    const Floats maxShift = v_mul(all(MAX_PATCH_SHIFT * MAX_PATCH_SHIFT), before);
    isAligned = v_and(isAligned, v_gt(second.squares, minSquares));
    isAligned = v_and(isAligned, v_gt(maxShift, plus(v_mul(x, x), y, y)));
    isAligned = v_and(isAligned, v_and(v_gt(v_mul(all(MAX_AREA_CHANGE), before), after),
                                       v_gt(v_mul(all(MAX_AREA_CHANGE), after), before)));
    const Floats norms = v_sqrt(v_mul(first.squares, second.squares));
    CV_DECL_ALIGNED(CACHE_LINE) float found[4][LANES];
    v_store(found[0], map.x);
    v_store(found[1], map.y);
    v_store(found[2], v_div(second.withSample, norms));
    v_store(found[3], v_and(isAligned, all(1)));
    for (int lane = 0; lane < LANES; lane++)
        alignments[lane] = {found[0][lane], found[1][lane],
                            found[3][lane] == 1 ? found[2][lane] : NOT_ALIGNED};
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
