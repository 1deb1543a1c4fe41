// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// Kernel of the descriptor: the tests that the approximate blur decides.

#include "detector/descriptor.hpp"
#include "common/simd_compat.hpp"

namespace cv
{
namespace aqorb
{
CV_CPU_OPTIMIZATION_NAMESPACE_BEGIN

/** Runs the tests of a descriptor that the approximate blur decides.
 @param center pixel of the keypoint in the approximate blur; all rotated points around it must be readable
 @param step elements from row to row
 @param a, b cosine and sine of the direction
 @param descriptor receives 32 bytes; bits of undecided tests are 0
 @param undecided receives one bit per test: 1 if the error bound leaves it open */
void comparePairs(const ushort* center, ptrdiff_t step, float a, float b, const PairTests& tests,
                  uchar* descriptor, uint64 undecided[PairTests::COUNT / 64]);

#ifndef CV_CPU_OPTIMIZATION_DECLARATIONS_ONLY

namespace
{

// Number of points that are rotated, and then fetched, at a time.
const int STEP = 16;

// Rotates points. As in cv::ORB, multiplications and additions are not fused, and ties round to even.
// @param offsets receives the offset of each rotated point from the centre, in elements
CV_ALWAYS_INLINE void rotatePoints(const float* x, const float* y, float a, float b, ptrdiff_t step,
                                   int* offsets)
{
    int i = 0;
#if CV_SIMD
    const v_float32 va = vx_setall_f32(a), vb = vx_setall_f32(b);
    const v_int32 vstep = vx_setall_s32(int(step));
    for (; i < STEP; i += AQORB_LANES(v_float32))
    {
        const v_float32 px = vx_load(x + i), py = vx_load(y + i);
        const v_int32 column = roundToEven(v_sub(v_mul(px, va), v_mul(py, vb)));
        const v_int32 row = roundToEven(v_add(v_mul(px, vb), v_mul(py, va)));
        v_store(offsets + i, v_add(v_mul(row, vstep), column));
    }
#endif
    for (; i < STEP; i++)
        offsets[i] = cvRound(x[i] * b + y[i] * a) * int(step) + cvRound(x[i] * a - y[i] * b);
}

CV_ALWAYS_INLINE void fetchPoints(const ushort* center, const int* offsets, ushort* values)
{
    // Without volatile, compilers combine stores, with more instructions.
    volatile ushort* const out = values;
    for (int i = 0; i < STEP; i++)
        out[i] = center[offsets[i]];
}

// Fetches the pixels at the rotated points of all tests: all first points, then all second points.
void fetchPairs(const ushort* center, ptrdiff_t step, float a, float b, const PairTests& tests,
                ushort* values)
{
    // Lead of the rotation over the fetch. A shorter lead would read offsets still in the store buffer. A longer lead
    // would keep the processor from overlapping rotation and fetch.
    const int AHEAD = 64, COUNT = 2 * PairTests::COUNT;
    const float *x = tests.x, *y = tests.y;
    CV_DECL_ALIGNED(CACHE_LINE) int offsets[COUNT];
    int i = 0;
    for (; i < AHEAD; i += STEP)
        rotatePoints(x + i, y + i, a, b, step, offsets + i);
    for (; i < COUNT; i += STEP)
    {
        rotatePoints(x + i, y + i, a, b, step, offsets + i);
        fetchPoints(center, offsets + (i - AHEAD), values + (i - AHEAD));
    }
    for (; i < COUNT + AHEAD; i += STEP)
        fetchPoints(center, offsets + (i - AHEAD), values + (i - AHEAD));
}

}  // namespace

void comparePairs(const ushort* center, ptrdiff_t step, float a, float b, const PairTests& tests,
                  uchar* descriptor, uint64 undecided[PairTests::COUNT / 64])
{
    const int COUNT = PairTests::COUNT;
    // The exact value lies between the rounded bounds of the approximate value.
    const int DOWN = 127 - BLUR_EXCESS, UP = 128 + BLUR_SHORTFALL;
    CV_DECL_ALIGNED(CACHE_LINE) ushort values[2 * COUNT];
    const ushort *first = values, *second = values + COUNT;
    fetchPairs(center, step, a, b, tests, values);
    for (int k = 0; k < COUNT / 64; k++)
        undecided[k] = 0;
    int i = 0;
#if CV_SIMD
    const v_uint16 down = vx_setall_u16(DOWN), up = vx_setall_u16(UP);
    const int LANES = AQORB_LANES(v_uint16);
    for (; i < COUNT; i += 2 * LANES)
    {
        v_uint16 sure[2], possible[2];
        for (int k = 0; k < 2; k++)
        {
            const v_uint16 p = vx_load(first + i + k * LANES), q = vx_load(second + i + k * LANES);
            sure[k] = v_gt(v_shr<8>(v_add(q, down)), v_shr<8>(v_add(p, up)));
            possible[k] = v_gt(v_shr<8>(v_add(q, up)), v_shr<8>(v_add(p, down)));
        }
        const v_int8 isSure = v_pack(v_reinterpret_as_s16(sure[0]), v_reinterpret_as_s16(sure[1]));
        const v_int8 isPossible =
            v_pack(v_reinterpret_as_s16(possible[0]), v_reinterpret_as_s16(possible[1]));
        const uint64 less = signBits(isSure);
        for (int j = 0; j < 2 * LANES / 8; j++)
            descriptor[i / 8 + j] = uchar(less >> (8 * j));
        undecided[i / 64] |= (uint64(signBits(isPossible)) & ~less) << (i % 64);
    }
#endif
    for (; i < COUNT; i++)
    {
        const int p = first[i], q = second[i];
        const bool sure = (q + DOWN) >> 8 > (p + UP) >> 8, possible = (q + UP) >> 8 > (p + DOWN) >> 8;
        if (i % 8 == 0)
            descriptor[i / 8] = 0;
        if (sure)
            descriptor[i / 8] |= uchar(1 << (i % 8));
        else if (possible)
            undecided[i / 64] |= uint64(1) << (i % 64);
    }
}

#endif  // CV_CPU_OPTIMIZATION_DECLARATIONS_ONLY

CV_CPU_OPTIMIZATION_NAMESPACE_END
}  // namespace aqorb
}  // namespace cv
