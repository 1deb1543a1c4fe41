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
    // Elsewhere OpenCV's v_round adds a half and cuts the fraction off, for example on 32-bit ARM. The sum with this
    // number has no fraction bits left, so the addition itself rounds, and the lowest bits of the sum are the whole
    // number.
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

#if CV_SSE2
//! The instruction of Intel's for the widest vectors.
#if CV_SIMD_WIDTH == 64
#define AQORB_WIDE(name) _mm512_##name
#elif CV_SIMD_WIDTH == 32
#define AQORB_WIDE(name) _mm256_##name
#else
#define AQORB_WIDE(name) _mm_##name
#endif
#endif

#if CV_SSE2 || CV_NEON
// Counting the bits of 64-bit words: a vector has the same word of several descriptors. Where a table counts the bits
// of half a byte, the two halves are separate words, so that the difference of two is an index of the table.
#if CV_SSSE3 && !CV_AVX_512BITALG
const int BIT_PLANES = 2;
#else
const int BIT_PLANES = 1;
#endif

//! Adds the counts of words to sums, which are to be given to bitsOfWords.
static CV_ALWAYS_INLINE v_uint8 addBits(const v_uint8& sums, const v_uint64& words)
{
#if CV_AVX_512BITALG && CV_SIMD_WIDTH == 64
    return v_uint8(_mm512_add_epi64(sums.val, _mm512_popcnt_epi64(words.val)));
#elif CV_SSSE3
    static const uchar COUNTS[64] = {0, 1, 1, 2, 1, 2, 2, 3, 1, 2, 2, 3, 2, 3, 3, 4, 0, 1, 1, 2, 1, 2,
                                     2, 3, 1, 2, 2, 3, 2, 3, 3, 4, 0, 1, 1, 2, 1, 2, 2, 3, 1, 2, 2, 3,
                                     2, 3, 3, 4, 0, 1, 1, 2, 1, 2, 2, 3, 1, 2, 2, 3, 2, 3, 3, 4};
    v_uint8 result = v_add_wrap(sums, v_uint8(AQORB_WIDE(shuffle_epi8)(vx_load(COUNTS).val, words.val)));
#if defined(__GNUC__) && defined(__x86_64__)
    __asm__(""
            : "+v"(result.val));  // otherwise GCC adds in an order that needs more registers than there are
#endif
    return result;
#else
    return v_add_wrap(sums, v_popcount(v_reinterpret_as_u8(words)));
#endif
}

#if CV_NEON
//! The sums of neighbours, of a and then of b.
static CV_ALWAYS_INLINE uint16x8_t addPairs(const uint16x8_t& a, const uint16x8_t& b)
{
#if defined(__aarch64__) || defined(_M_ARM64)
    return vpaddq_u16(a, b);
#else
    return vcombine_u16(vpadd_u16(vget_low_u16(a), vget_high_u16(a)),
                        vpadd_u16(vget_low_u16(b), vget_high_u16(b)));
#endif
}
#endif

//! The bits of the words of four vectors. In each 128 bits come those of the first vector, then those of the others.
static CV_ALWAYS_INLINE v_uint16 bitsOfWords(const v_uint8* sums)
{
#if CV_NEON
    const uint16x8_t a = addPairs(vpaddlq_u8(sums[0].val), vpaddlq_u8(sums[1].val));
    const uint16x8_t b = addPairs(vpaddlq_u8(sums[2].val), vpaddlq_u8(sums[3].val));
    return v_uint16(addPairs(a, b));
#else
    decltype(v_uint8().val) words[4];
    for (int i = 0; i < 4; i++)
#if CV_AVX_512BITALG && CV_SIMD_WIDTH == 64
        words[i] = sums[i].val;
#else
        words[i] = AQORB_WIDE(sad_epu8)(sums[i].val, vx_setzero_u8().val);
#endif
    return v_uint16(AQORB_WIDE(packs_epi32)(AQORB_WIDE(packs_epi32)(words[0], words[1]),
                                            AQORB_WIDE(packs_epi32)(words[2], words[3])));
#endif
}
#endif
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
