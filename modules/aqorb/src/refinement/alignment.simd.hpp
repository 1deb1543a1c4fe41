// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// Kernel of the alignment: one match in each lane of a vector. Every CPU computes a match in the same order, whatever
// the number of lanes.

#include "refinement/alignment.hpp"
#include "refinement/patch_samples.hpp"

namespace cv
{
namespace aqorb
{
CV_CPU_OPTIMIZATION_NAMESPACE_BEGIN

/** Aligns patches by three inverse compositional steps (Baker and Matthews 2004). Each step solves for the affine map,
 gain and bias that bring the second patch closest to the first patch. The patches that the last step compares give the
 correlation and the residual: another pass, at the final position, would take time and let pass wrong matches that
 still move. */
void alignByLanes(const LevelPatches* patches, int count, LevelAlignment* alignments);

#ifndef CV_CPU_OPTIMIZATION_DECLARATIONS_ONLY

namespace
{

const int SIDE = 2 * PATCH_RADIUS + 1, WIDE = SIDE + 2;
const float SAMPLES = SIDE * SIDE;
const int UNKNOWNS = 6;  // affine map: factors of u and v and shift, in x and then in y

// First patch of each lane, and the normal equations of its alignment. The derivative by an unknown is dx or dy, times
// u, v or 1.
struct Template
{
    // Deviation of a sample from the mean. Its doubled derivatives by x and y follow, LANES numbers apart.
    const float* at(int u, int v) const { return samples[(v + PATCH_RADIUS) * SIDE + u + PATCH_RADIUS]; }

    void sample(const Windows& windows, const AffineMap& map)
    {
        CV_DECL_ALIGNED(CACHE_LINE) float wide[WIDE * WIDE * LANES];  // one more sample on each side
        float* out = wide;
        forEachRow<PATCH_RADIUS + 1>(windows, map,
                                     [&](int, const SampleRow<PATCH_RADIUS + 1>& row)
                                     {
                                         for (int u = -PATCH_RADIUS - 1; u <= PATCH_RADIUS + 1; u++)
                                         {
                                             v_store(out, row.at(u));
                                             out += LANES;
                                         }
                                     });
        const float* const inner = wide + (WIDE + 1) * LANES;
        Floats sum = all(0);
        for (int v = 0; v < SIDE; v++)
            for (int u = 0; u < SIDE; u++)
                sum = v_add(sum, load(inner + (v * WIDE + u) * LANES));
        mean = v_mul(sum, all(1 / SAMPLES));
        for (int v = 0; v < SIDE; v++)
        {
            for (int u = 0; u < SIDE; u++)
            {
                const float* const p = inner + (v * WIDE + u) * LANES;
                float* const sample = samples[v * SIDE + u];
                v_store(sample, v_sub(load(p), mean));
                v_store(sample + LANES, v_sub(load(p + LANES), load(p - LANES)));
                v_store(sample + 2 * LANES, v_sub(load(p + WIDE * LANES), load(p - WIDE * LANES)));
            }
        }
    }

    // Makes the normal equations, and eliminates gain and bias.
    void prepare()
    {
        squares = all(0);
        clear(gradients);
        clear(withSample);
        for (auto& row : lower)
            clear(row);
        for (int v = -PATCH_RADIUS; v <= PATCH_RADIUS; v++)
            addRow(v);
        for (int i = 0; i < UNKNOWNS; i++)
        {
            const Floats biasFactor = v_mul(gradients[i], all(1 / SAMPLES)),
                         gainFactor = v_div(withSample[i], squares);
            for (int j = 0; j <= i; j++)
                lower[i][j] = minus(minus(lower[i][j], biasFactor, gradients[j]), gainFactor, withSample[j]);
        }
        decompose();
    }

    // Adds the sums of row v.
    void addRow(int v)
    {
        enum
        {
            XX,
            XY,
            YY,
            XT,
            YT,
            X,
            Y,
            PRODUCTS
        };
        Floats sums[PRODUCTS][3];  // sums of each product times 1, u and u * u
        for (auto& row : sums)
            clear(row);
        for (int u = -PATCH_RADIUS; u <= PATCH_RADIUS; u++)
        {
            const float* const p = at(u, v);
            const Floats t = load(p), x = load(p + LANES), y = load(p + 2 * LANES);
            const Floats products[] = {v_mul(x, x), v_mul(x, y), v_mul(y, y), v_mul(x, t), v_mul(y, t), x, y};
            squares = plus(squares, t, t);
            for (int i = 0; i < PRODUCTS; i++)
            {
                sums[i][0] = v_add(sums[i][0], products[i]);
                sums[i][1] = plus(sums[i][1], products[i], all(float(u)));
                if (i <= YY)
                    sums[i][2] = plus(sums[i][2], products[i], all(float(u * u)));
            }
        }
        const int POWERS_OF_U[] = {1, 0, 0, 1, 0, 0}, POWERS_OF_V[] = {0, 1, 0, 0, 1, 0};
        const Floats factors[] = {all(1), all(float(v)), all(float(v * v))};
        for (int i = 0; i < UNKNOWNS; i++)
        {
            const int u = POWERS_OF_U[i];
            const Floats& factor = factors[POWERS_OF_V[i]];
            gradients[i] = plus(gradients[i], sums[X + i / 3][u], factor);
            withSample[i] = plus(withSample[i], sums[XT + i / 3][u], factor);
            for (int j = 0; j <= i; j++)
                lower[i][j] = plus(lower[i][j], sums[XX + i / 3 + j / 3][u + POWERS_OF_U[j]],
                                   factors[POWERS_OF_V[i] + POWERS_OF_V[j]]);
        }
    }

    // Cholesky decomposition L D L^T.
    void decompose()
    {
        for (int i = 0; i < UNKNOWNS; i++)
        {
            for (int j = 0; j < i; j++)
                for (int k = 0; k < j; k++)
                    lower[i][j] = minus(lower[i][j], lower[i][k], lower[j][k]);  // still L D
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

    CV_DECL_ALIGNED(CACHE_LINE) float samples[SIDE * SIDE][3 * LANES];
    Floats mean, squares;              // mean of the patch; sum of squared deviations
    Floats gradients[UNKNOWNS];        // sums of the derivatives
    Floats withSample[UNKNOWNS];       // sums of the derivatives times the samples
    Floats lower[UNKNOWNS][UNKNOWNS];  // L, below the diagonal
    Floats inverses[UNKNOWNS];         // inverses of the elements of D
};

// Sums over the differences between the second patch and the first.
struct PatchSums
{
    void add(const Template& first, const Windows& windows, const AffineMap& map)
    {
        Floats sum = all(0), sumOfSquares = all(0);
        withSample = all(0);
        clear(right);
        const auto addRow = [&](int v, const SampleRow<PATCH_RADIUS>& samples)
        {
            Floats x = all(0), y = x, xu = x, yu = x;
            for (int u = -PATCH_RADIUS; u <= PATCH_RADIUS; u++)
            {
                const float* const p = first.at(u, v);
                const Floats t = load(p), d = v_sub(v_sub(samples.at(u), first.mean), t);
                sum = v_add(sum, d);
                sumOfSquares = plus(sumOfSquares, d, d);
                withSample = plus(withSample, d, t);
                const Floats productX = v_mul(d, load(p + LANES)), productY = v_mul(d, load(p + 2 * LANES));
                x = v_add(x, productX);
                y = v_add(y, productY);
                xu = plus(xu, productX, all(float(u)));
                yu = plus(yu, productY, all(float(u)));
            }
            const Floats row[] = {xu, v_mul(x, all(float(v))), x, yu, v_mul(y, all(float(v))), y};
            for (int i = 0; i < UNKNOWNS; i++)
                right[i] = v_add(right[i], row[i]);
        };
        forEachRow<PATCH_RADIUS>(windows, map, addRow);
        mean = v_mul(sum, all(1 / SAMPLES));
        compare(first, minus(sumOfSquares, sum, mean));
    }

    // Computes what follows from the sums. deviations: sum of squared deviations of the differences from their mean.
    void compare(const Template& first, const Floats& deviations)
    {
        gain = v_div(withSample, first.squares);
        squares = v_add(v_add(first.squares, v_add(withSample, withSample)), deviations);
        const Floats cosine = v_div(v_add(first.squares, withSample), v_sqrt(v_mul(first.squares, squares)));
        // Of patches that hardly differ, 1 - cosine would have few digits.
        const Floats sine = v_div(v_max(minus(deviations, withSample, gain), all(0)), squares);
        distance = v_add(v_div(sine, v_add(all(1), v_abs(cosine))), v_sub(v_abs(cosine), cosine));
    }

    // Computes the right side of the normal equations, with the patch scaled to the norm of the first patch.
    void eliminate(const Template& first)
    {
        // Doubled, like the derivatives.
        const Floats scale = v_mul(all(2), v_sqrt(v_div(first.squares, squares)));
        for (int i = 0; i < UNKNOWNS; i++)
        {
            const Floats residual =
                minus(minus(right[i], first.gradients[i], mean), first.withSample[i], gain);
            right[i] = v_mul(scale, residual);
        }
    }

    Floats mean, gain;       // of the differences: mean, and regression on the first patch
    Floats squares;          // second patch's sum of squared deviations from its mean
    Floats withSample;       // sum of products with the first patch's samples
    Floats distance;         // 1 - correlation of the patches
    Floats right[UNKNOWNS];  // sums of products with the first patch's derivatives
};

// Composes the map with the inverse of an increment (inverse compositional update). With A the matrix of the map, p its
// position, and ((a, b), (c, d)) and t those of the increment: A' = A ((a, b), (c, d))^-1, and p' = p - A' t.
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

// Variance of the position along its worst axis. The covariance of the shift is the inverse of the Hessian times the
// variance of the residual. The rounding of grey values alone has a variance of 1/12 in each image.
Floats worstVariance(const Template& first, const AffineMap& map, const Floats& difference)
{
    Floats columnX[UNKNOWNS], columnY[UNKNOWNS];
    clear(columnX);
    clear(columnY);
    columnX[2] = columnY[5] = all(1);
    first.solve(columnX);
    first.solve(columnY);
    const Floats a = columnX[2], b = columnX[5], c = columnY[5];
    // In pixels of the second image: the map on both sides of the matrix (a, b; b, c).
    const Floats xa = plus(v_mul(map.xu, a), map.xv, b), xb = plus(v_mul(map.xu, b), map.xv, c);
    const Floats ya = plus(v_mul(map.yu, a), map.yv, b), yb = plus(v_mul(map.yu, b), map.yv, c);
    const Floats xx = plus(v_mul(xa, map.xu), xb, map.xv), yy = plus(v_mul(ya, map.yu), yb, map.yv);
    const Floats xy = plus(v_mul(xa, map.yu), xb, map.yv), half = v_mul(all(0.5f), v_sub(xx, yy));
    const Floats worst = plus(v_sqrt(plus(v_mul(half, half), xy, xy)), all(0.5f), v_add(xx, yy));
    // Doubled derivatives make the Hessian four times too large.
    const float ROUNDING = 1 / 6.f, DOUBLED = 4;
    return v_mul(v_mul(all(DOUBLED), worst), v_max(v_mul(difference, all(1 / SAMPLES)), all(ROUNDING)));
}

// Lanes in which the alignment neither shifts the patch too far nor changes its area too much.
CV_ALWAYS_INLINE Floats isWithinLimits(const AffineMap& start, const AffineMap& map)
{
    const Floats x = v_sub(map.x, start.x), y = v_sub(map.y, start.y);
    const Floats before = v_abs(start.determinant()), after = v_abs(map.determinant());
    const Floats maxShift = v_mul(all(MAX_PATCH_SHIFT * MAX_PATCH_SHIFT), before);
    const Floats isSimilar = v_and(v_gt(v_mul(all(MAX_AREA_CHANGE), before), after),
                                   v_gt(v_mul(all(MAX_AREA_CHANGE), after), before));
    return v_and(isSimilar, v_gt(maxShift, plus(v_mul(x, x), y, y)));
}

// Aligns the patches of each lane. Lanes that cannot be aligned continue with the pixels at the origin.
void alignLanes(const LevelPatches* const* patches, LevelAlignment* alignments)
{
    const int STEPS = 3;
    Windows windows[2];
    CV_DECL_ALIGNED(CACHE_LINE) float spacings[LANES], maps[4][LANES];
    for (int lane = 0; lane < LANES; lane++)
    {
        windows[0].set(lane, patches[lane]->first);
        windows[1].set(lane, patches[lane]->second);
        spacings[lane] = patches[lane]->spacing;
        for (int i = 0; i < 4; i++)
            maps[i][lane] = patches[lane]->map[i];
    }
    const Floats spacing = load(spacings), minSquares = all(MIN_PATCH_VARIANCE * SAMPLES);
    AffineMap map = {load(windows[0].x), load(windows[0].y), spacing, all(0), all(0), spacing};
    Floats isAligned = isInside(map, windows[0], PATCH_RADIUS + 1);
    map.keep(isAligned);
    Template first;
    first.sample(windows[0], map);
    first.prepare();
    isAligned = v_and(isAligned, v_gt(first.squares, minSquares));

    const AffineMap start = {load(windows[1].x), load(windows[1].y), load(maps[0]),
                             load(maps[1]),      load(maps[2]),      load(maps[3])};
    map = start;
    PatchSums second;
    for (int step = 0; step < STEPS; step++)
    {
        isAligned = v_and(isAligned, isInside(map, windows[1], PATCH_RADIUS));
        map.keep(isAligned);
        second.add(first, windows[1], map);
        second.eliminate(first);
        first.solve(second.right);
        map = composeInverse(map, second.right);
    }
    isAligned = v_and(isAligned, isInside(map, windows[1], PATCH_RADIUS));

    isAligned = v_and(isAligned, v_gt(second.squares, minSquares));
    isAligned = v_and(isAligned, isWithinLimits(start, map));
    const Floats difference = v_mul(v_mul(all(2), first.squares), second.distance);
    const Floats found[] = {map.x,
                            map.y,
                            map.xu,
                            map.xv,
                            map.yu,
                            map.yv,
                            v_sub(all(1), second.distance),
                            worstVariance(first, map, difference),
                            v_and(isAligned, all(1))};
    CV_DECL_ALIGNED(CACHE_LINE) float numbers[9][LANES];
    for (int i = 0; i < 9; i++)
        v_store(numbers[i], found[i]);
    for (int lane = 0; lane < LANES; lane++)
    {
        const auto number = [&](int i) { return numbers[i][lane]; };
        alignments[lane] = {number(0),
                            number(1),
                            {number(2), number(3), number(4), number(5)},
                            number(8) == 1 ? number(6) : NOT_ALIGNED,
                            number(7)};
    }
}

}  // namespace

void alignByLanes(const LevelPatches* patches, int count, LevelAlignment* alignments)
{
    for (int i = 0; i < count; i += LANES)
    {
        const LevelPatches* lanePatches[LANES];
        LevelAlignment found[LANES];
        for (int lane = 0; lane < LANES; lane++)
            lanePatches[lane] = patches + (i + lane < count ? i + lane : count - 1);
        for (int next = i + LANES; next < i + 2 * LANES && next < count; next++)
        {
            prefetch(patches[next].first, patches[next].spacing);
            prefetch(patches[next].second, patches[next].spacing);
        }
        alignLanes(lanePatches, found);
        for (int lane = 0; lane < LANES && i + lane < count; lane++)
            alignments[i + lane] = found[lane];
    }
}

#endif  // CV_CPU_OPTIMIZATION_DECLARATIONS_ONLY

CV_CPU_OPTIMIZATION_NAMESPACE_END
}  // namespace aqorb
}  // namespace cv
