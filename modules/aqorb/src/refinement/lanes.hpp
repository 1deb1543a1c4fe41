// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#ifndef OPENCV_AQORB_LANES_HPP
#define OPENCV_AQORB_LANES_HPP

#include "common/simd_compat.hpp"

// Vectors of floats with one item in each lane. Every CPU computes an item in the same order, whatever the number of
// lanes, so the results have the same bytes. All functions are static: see simd_compat.hpp.

namespace cv
{
namespace aqorb
{

#if CV_SIMD && (!CV_NEON || defined(__aarch64__) || defined(_M_ARM64)) && !defined(AQORB_ONE_LANE_ONLY)

typedef v_float32 Floats;
typedef v_int32 Ints;
const int LANES = CV_SIMD_WIDTH / 4;

static CV_ALWAYS_INLINE Floats all(float a)
{
    return vx_setall_f32(a);
}
static CV_ALWAYS_INLINE Floats load(const float* a)
{
    return vx_load(a);
}
static CV_ALWAYS_INLINE Ints load(const int* a)
{
    return vx_load(a);
}
template <int I> static CV_ALWAYS_INLINE Floats byteOf(const unsigned* numbers)
{
    const v_uint32 shifted = v_shr<8 * I>(vx_load(numbers));
    return v_cvt_f32(v_reinterpret_as_s32(v_and(shifted, vx_setall_u32(255))));
}

#else

// One lane, without vectors and on 32-bit ARM, where OpenCV's vector division is approximate. C's functions, because a
// compiler may emit those of the namespace std for one CPU, and the linker choose them for all.
typedef float Floats;
typedef int Ints;
const int LANES = 1;

#define AQORB_ONE_LANE(name, T, value)           \
    static CV_ALWAYS_INLINE T name(T a, T b = 0) \
    {                                            \
        return static_cast<void>(b), (value);    \
    }
AQORB_ONE_LANE(v_add, float, a + b)
AQORB_ONE_LANE(v_sub, float, a - b)
AQORB_ONE_LANE(v_mul, float, (a) * (b))
AQORB_ONE_LANE(v_div, float, a / b)
AQORB_ONE_LANE(v_max, float, a < b ? b : a)
AQORB_ONE_LANE(v_gt, float, float(a > b))
AQORB_ONE_LANE(v_and, float, a != 0 ? b : 0)
AQORB_ONE_LANE(v_abs, float, fabsf(a))
AQORB_ONE_LANE(v_sqrt, float, sqrtf(a))
AQORB_ONE_LANE(all, float, a)
AQORB_ONE_LANE(v_add, int, a + b)
AQORB_ONE_LANE(v_mul, int, (a) * (b))
#undef AQORB_ONE_LANE
template <typename T> static CV_ALWAYS_INLINE T load(const T* a)
{
    return *a;
}
template <typename T> static CV_ALWAYS_INLINE void v_store(T* out, T a)
{
    *out = a;
}
static CV_ALWAYS_INLINE int v_trunc(float a)
{
    return int(a);
}
static CV_ALWAYS_INLINE float v_cvt_f32(int a)
{
    return float(a);
}
template <int I> static CV_ALWAYS_INLINE Floats byteOf(const unsigned* numbers)
{
    return float(*numbers >> (8 * I) & 255);
}

#endif

// c + a * b and c - a * b, both rounded twice on every CPU.
static CV_ALWAYS_INLINE Floats plus(const Floats& c, const Floats& a, const Floats& b)
{
    return v_add(c, v_mul(a, b));
}
static CV_ALWAYS_INLINE Floats minus(const Floats& c, const Floats& a, const Floats& b)
{
    return v_sub(c, v_mul(a, b));
}
template <int COUNT> static CV_ALWAYS_INLINE void clear(Floats (&numbers)[COUNT])
{
    for (Floats& number : numbers)
        number = all(0);
}

}  // namespace aqorb
}  // namespace cv

#endif
