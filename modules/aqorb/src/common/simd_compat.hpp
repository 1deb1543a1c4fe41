// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#ifndef OPENCV_AQORB_SIMD_COMPAT_HPP
#define OPENCV_AQORB_SIMD_COMPAT_HPP

#include <opencv2/core/hal/intrin.hpp>
#include <opencv2/core/version.hpp>

#include <cmath>
#include <cstring>

// Differences between CPUs and between versions of OpenCV, for the kernels: byte and bit operations that the universal
// intrinsics lack or do slowly. Each gives the same result on every CPU.
//
// The kernels call the universal intrinsics by the function names of OpenCV 4.9. Older versions have only operators, so
// this header adds the functions. All functions are static: a file compiled for one CPU must keep its own.
//
// A stage and its kernel (*.simd.hpp) exchange only raw pointers and plain structs. The compiler may emit a member or
// template function in a file compiled for one CPU; if the linker chose it for the whole program, the program would
// crash on other CPUs.

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
AQORB_BINARY(v_div, /)
AQORB_BINARY(v_and, &)
AQORB_BINARY(v_or, |)
AQORB_BINARY(v_xor, ^)
AQORB_BINARY(v_eq, ==)
AQORB_BINARY(v_gt, >)
#undef AQORB_BINARY
#else
#define AQORB_LANES(V) VTraits<V>::vlanes()
#endif

//! Number of set bits.
static CV_ALWAYS_INLINE int bitCount(uint64 v)
{
#if defined(__POPCNT__) || defined(__aarch64__) || defined(__wasm__)
    return __builtin_popcountll(v);
#else
    v -= (v >> 1) & 0x5555555555555555u;
    v = (v & 0x3333333333333333u) + ((v >> 2) & 0x3333333333333333u);
    v = (v + (v >> 4)) & 0x0f0f0f0f0f0f0f0fu;
    return int((v * 0x0101010101010101u) >> 56);
#endif
}

//! Index of the lowest set bit. At least one bit must be set.
static CV_ALWAYS_INLINE int trailingZeros(uint64 bits)
{
#if defined(__GNUC__)
    return __builtin_ctzll(bits);
#else
    const unsigned low = unsigned(bits);
    return int(low ? trailingZeros32(low) : 32 + trailingZeros32(unsigned(bits >> 32)));
#endif
}

//! a * b + c, rounded once. The C library's fma is slow on processors without the instruction, and MinGW's rounds
//! twice.
static CV_ALWAYS_INLINE float multiplyAdd(float a, float b, float c)
{
#if defined(FP_FAST_FMAF) || defined(__FMA__) || defined(__ARM_FEATURE_FMA)
    return fmaf(a, b, c);  // std::fma is an inline function, see types.hpp
#else
    // The product of two floats is exact in a double. An inexact sum is rounded to odd: to the neighbouring double with
    // an odd last bit. A double has more than twice the bits of a float plus two, so the odd sum is neither a float nor
    // midway between two floats, and rounds to the same float as the exact sum.
    const double product = double(a) * b, sum = product + c;
    const double added = sum - product, error = (product - (sum - added)) + (c - added);
    if (error == 0)
        return float(sum);
    int64 bits;
    std::memcpy(&bits, &sum, sizeof(bits));
    if (bits % 2 == 0)
        bits += (error > 0) == (sum > 0) ? 1 : -1;
    double odd;
    std::memcpy(&odd, &bits, sizeof(odd));
    return float(odd);
#endif
}

//! Average of two numbers, rounded up.
static CV_ALWAYS_INLINE unsigned average(unsigned a, unsigned b)
{
    return (a + b + 1) >> 1;
}

#if CV_SSE2 || CV_SSSE3  // Emscripten has SSSE3's intrinsics on request
//! Intel's intrinsic for the widest vectors.
#if CV_SIMD_WIDTH == 64
#define AQORB_WIDE(name) _mm512_##name
#elif CV_SIMD_WIDTH == 32
#define AQORB_WIDE(name) _mm256_##name
#else
#define AQORB_WIDE(name) _mm_##name
#endif
#endif

#if CV_SIMD
//! Rounds to the nearest whole number, ties to even, as cvRound does. Requires |a| < 2^22.
static CV_ALWAYS_INLINE v_int32 roundToEven(const v_float32& a)
{
#if CV_SSE2 || defined(__aarch64__) || defined(_M_ARM64)
    return v_round(a);
#else
    // On other CPUs, for example 32-bit ARM, OpenCV's v_round adds a half and truncates. The sum with LARGE has no
    // fraction bits, so the addition rounds, and the lowest bits of the sum are the whole number.
    const float LARGE = 3 << 22;
    const v_int32 sum = v_reinterpret_as_s32(v_add(a, vx_setall_f32(LARGE)));
    return v_sub(sum, v_reinterpret_as_s32(vx_setall_f32(LARGE)));
#endif
}

//! Sign bits of the byte lanes.
template <typename V> static CV_ALWAYS_INLINE uint64 signBits(const V& a)
{
    auto bits = v_signmask(a);
#if CV_AVX512_SKX && defined(__GNUC__) && !defined(__clang__)
    // GCC 12 may extend a mask of 32 bits to 64 in memory without writing the upper 32. A general register extends it
    // correctly.
    if (AQORB_LANES(V) < 64)
        __asm__("" : "+r"(bits));
#endif
    return uint64(bits) & (~uint64(0) >> (64 - AQORB_LANES(V)));
}

//! Bits of the lanes in which a is greater than b.
template <typename V> static CV_ALWAYS_INLINE uint64 greaterLanes(const V& a, const V& b)
{
    return signBits(v_gt(a, b));
}
#if CV_AVX512_SKX && CV_SIMD_WIDTH == 64
// AVX-512 comparisons give masks. The generic code would make vectors of these, and masks again.
static CV_ALWAYS_INLINE uint64 greaterLanes(const v_uint8& a, const v_uint8& b)
{
    return _mm512_cmpgt_epu8_mask(a.val, b.val);
}
#endif

//! Whether a is greater than b in any lane.
template <typename V> static CV_ALWAYS_INLINE bool anyLaneGreater(const V& a, const V& b)
{
#if CV_NEON
    return v_check_any(v_gt(a, b));  // NEON is slow at collecting one bit from each lane
#else
    return greaterLanes(a, b) != 0;
#endif
}

static CV_ALWAYS_INLINE v_uint16 average(const v_uint16& a, const v_uint16& b)
{
#if CV_SSE2
    return v_uint16(AQORB_WIDE(avg_epu16)(a.val, b.val));
#elif CV_NEON
    return v_uint16(vrhaddq_u16(a.val, b.val));
#else
    return v_sub(v_or(a, b), v_shr<1>(v_xor(a, b)));
#endif
}

//! Loads eight bytes at p[i] + offset for each 128 bits, as 16-bit numbers.
static CV_ALWAYS_INLINE v_int16 expandEach(const uchar* const* p, ptrdiff_t offset)
{
    int64 bytes[CV_SIMD_WIDTH / 16];
    for (int i = 0; i < CV_SIMD_WIDTH / 16; i++)
        std::memcpy(&bytes[i], p[i] + offset, sizeof(bytes[i]));
#if CV_AVX512_SKX && CV_SIMD_WIDTH == 64
    return v_int16(_mm512_cvtepu8_epi16(_mm256_set_epi64x(bytes[3], bytes[2], bytes[1], bytes[0])));
#elif CV_AVX2 && CV_SIMD_WIDTH == 32
    return v_int16(_mm256_cvtepu8_epi16(_mm_set_epi64x(bytes[1], bytes[0])));
#else
    return v_reinterpret_as_s16(vx_load_expand(reinterpret_cast<const uchar*>(bytes)));
#endif
}

#if CV_NEON
//! Sums of neighbouring lanes, of a and then of b.
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

#if CV_SSSE3 || CV_NEON
#define AQORB_PICKS_BYTES
//! Loads sixteen bytes at p + offsets[i] for each 128 bits.
static CV_ALWAYS_INLINE v_uint8 loadEach(const uchar* p, const int* offsets)
{
#if CV_SIMD_WIDTH == 16
    return v_load(p + offsets[0]);
#elif CV_SIMD_WIDTH == 32
    return v256_load_halves(p + offsets[0], p + offsets[1]);
#else
    const __m512i low = _mm512_castsi256_si512(v256_load_halves(p + offsets[0], p + offsets[1]).val);
    return v_uint8(_mm512_inserti64x4(low, v256_load_halves(p + offsets[2], p + offsets[3]).val, 1));
#endif
}

//! Picks bytes by index, in each 128 bits.
static CV_ALWAYS_INLINE v_uint8 pick(const v_uint8& bytes, const v_uint8& indices)
{
#if CV_SSSE3
    return v_uint8(AQORB_WIDE(shuffle_epi8)(bytes.val, indices.val));
#elif defined(__aarch64__) || defined(_M_ARM64)
    return v_uint8(vqtbl1q_u8(bytes.val, indices.val));
#else
    const uint8x8x2_t halves = {{vget_low_u8(bytes.val), vget_high_u8(bytes.val)}};
    return v_uint8(
        vcombine_u8(vtbl2_u8(halves, vget_low_u8(indices.val)), vtbl2_u8(halves, vget_high_u8(indices.val))));
#endif
}

//! Weighted sums of neighbouring bytes, minus 2^15 to fit. The two weights add up to 256.
static CV_ALWAYS_INLINE v_int16 weighPairs(const v_uint8& bytes, const v_uint8& weights)
{
#if CV_NEON
    const uint16x8_t low = vmull_u8(vget_low_u8(bytes.val), vget_low_u8(weights.val)),
                     high = vmull_u8(vget_high_u8(bytes.val), vget_high_u8(weights.val));
    return v_reinterpret_as_s16(v_xor(v_uint16(addPairs(low, high)), vx_setall_u16(1 << 15)));
#else
    return v_int16(AQORB_WIDE(maddubs_epi16)(weights.val, v_xor(bytes, vx_setall_u8(128)).val));
#endif
}

//! Upper 16 of the 32 bits of a * (256 - weight) + b * weight.
static CV_ALWAYS_INLINE v_int16 blendHigh(const v_int16& a, const v_int16& b, int weight)
{
#if CV_NEON
    const int16x4_t weightA = vdup_n_s16(short(256 - weight)), weightB = vdup_n_s16(short(weight));
    const int32x4_t low = vmlal_s16(vmull_s16(vget_low_s16(a.val), weightA), vget_low_s16(b.val), weightB);
    const int32x4_t high = vmlal_s16(vmull_s16(vget_high_s16(a.val), weightA), vget_high_s16(b.val), weightB);
    return v_int16(vcombine_s16(vshrn_n_s32(low, 16), vshrn_n_s32(high, 16)));
#else
    const auto weights = AQORB_WIDE(set1_epi32)((weight << 16) | (256 - weight));
    const auto low = AQORB_WIDE(madd_epi16)(AQORB_WIDE(unpacklo_epi16)(a.val, b.val), weights);
    const auto high = AQORB_WIDE(madd_epi16)(AQORB_WIDE(unpackhi_epi16)(a.val, b.val), weights);
    return v_int16(
        AQORB_WIDE(packs_epi32)(AQORB_WIDE(srai_epi32)(low, 16), AQORB_WIDE(srai_epi32)(high, 16)));
#endif
}
#endif

#if CV_SSE2 || CV_NEON
#define AQORB_COUNTS_BITS
// Bit counts of 64-bit words: a vector holds the same word of several descriptors. If a table counts the bits of half a
// byte, the two halves are separate words: the difference of two words is an index of the table.
#if CV_SSSE3 && !CV_AVX_512BITALG
const int WORD_HALVES = 2;
#else
const int WORD_HALVES = 1;
#endif

//! Adds the bit counts of words to sums, the arguments of wordBits.
static CV_ALWAYS_INLINE v_uint8 addBits(const v_uint8& sums, const v_uint64& words)
{
#if CV_AVX_512BITALG && CV_SIMD_WIDTH == 64
    return v_uint8(_mm512_add_epi64(sums.val, _mm512_popcnt_epi64(words.val)));
#elif CV_SSSE3
    static const uchar COUNTS[64] = {0, 1, 1, 2, 1, 2, 2, 3, 1, 2, 2, 3, 2, 3, 3, 4, 0, 1, 1, 2, 1, 2,
                                     2, 3, 1, 2, 2, 3, 2, 3, 3, 4, 0, 1, 1, 2, 1, 2, 2, 3, 1, 2, 2, 3,
                                     2, 3, 3, 4, 0, 1, 1, 2, 1, 2, 2, 3, 1, 2, 2, 3, 2, 3, 3, 4};
    v_uint8 result = v_add_wrap(sums, pick(vx_load(COUNTS), v_reinterpret_as_u8(words)));
#if defined(__GNUC__) && defined(__x86_64__)
    __asm__("" : "+v"(result.val));  // keeps GCC from an order of additions that spills registers
#endif
    return result;
#else
    return v_add_wrap(sums, v_popcount(v_reinterpret_as_u8(words)));
#endif
}

//! Bit counts of the words of four vectors. In each 128 bits, the counts of the first vector come first.
static CV_ALWAYS_INLINE v_uint16 wordBits(const v_uint8* sums)
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

}  // namespace aqorb
}  // namespace cv

#endif
