// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#ifndef OPENCV_AQORB_SIMD_COMPAT_HPP
#define OPENCV_AQORB_SIMD_COMPAT_HPP

#include <opencv2/core/hal/intrin.hpp>
#include <opencv2/core/version.hpp>

// The kernels call the universal intrinsics by the function names that OpenCV has had since 4.9. Older versions have
// operators only; for these the functions are added here.

#define AQORB_VERSION_CODE (CV_VERSION_MAJOR * 100 + CV_VERSION_MINOR)

namespace cv
{
namespace aqorb
{

#if AQORB_VERSION_CODE < 409
#define AQORB_LANES(V) int(V::nlanes)
#define AQORB_BINARY(name, op)                                                   \
    template <typename V> CV_ALWAYS_INLINE static V name(const V& a, const V& b) \
    {                                                                            \
        return a op b;                                                           \
    }
AQORB_BINARY(v_add, +)
AQORB_BINARY(v_sub, -)
AQORB_BINARY(v_mul, *)
AQORB_BINARY(v_and, &)
AQORB_BINARY(v_or, |)
AQORB_BINARY(v_xor, ^)
AQORB_BINARY(v_eq, ==)
AQORB_BINARY(v_gt, >)
#undef AQORB_BINARY
#else
#define AQORB_LANES(V) VTraits<V>::vlanes()
#endif

#if CV_SIMD
//! Rounds to the nearest whole number, and ties to even, as cvRound does. The numbers must be less than 2^22 in size.
static CV_ALWAYS_INLINE v_int32 roundToEven(const v_float32& a)
{
#if CV_SSE2 || defined(__aarch64__) || defined(_M_ARM64)
    return v_round(a);
#else
    // Elsewhere OpenCV's v_round adds a half and cuts the fraction off, for example on 32-bit ARM. The sum with this number
    // has no fraction bits left, so the addition itself rounds, and the lowest bits of the sum are the whole number.
    const float LARGE = 3 << 22;
    const v_int32 sum = v_reinterpret_as_s32(v_add(a, vx_setall_f32(LARGE)));
    return v_sub(sum, v_reinterpret_as_s32(vx_setall_f32(LARGE)));
#endif
}

//! A bit for each lane of bytes, set where the sign of the lane is.
template <typename V> static CV_ALWAYS_INLINE uint64 signBits(const V& a)
{
    auto bits = v_signmask(a);
#if CV_AVX512_SKX && defined(__GNUC__) && !defined(__clang__)
    // GCC 12 may keep a mask that it extends to 64 bits in memory of which it writes only 32. Extended from a general
    // register, the mask is right.
    if (AQORB_LANES(V) < 64)
        __asm__("" : "+r"(bits));
#endif
    return uint64(bits) & (~uint64(0) >> (64 - AQORB_LANES(V)));
}
#endif

//! Index of the lowest bit that is set. At least one must be.
static CV_ALWAYS_INLINE int trailingZeros(uint64 bits)
{
#if defined(__GNUC__)
    return __builtin_ctzll(bits);
#else
    const unsigned low = unsigned(bits);
    return int(low ? trailingZeros32(low) : 32 + trailingZeros32(unsigned(bits >> 32)));
#endif
}

}  // namespace aqorb
}  // namespace cv

#endif
