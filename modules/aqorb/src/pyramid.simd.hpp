// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "pyramid.hpp"
#include "simd_compat.hpp"

namespace cv
{
namespace aqorb
{
namespace stages
{
CV_CPU_OPTIMIZATION_NAMESPACE_BEGIN

//! Computes the destination rows from `begin` to before `end`. Returns false, and does nothing, if there is no kernel
//! for this CPU.
bool resizeRows(const Resize& resize, int begin, int end);

#ifndef CV_CPU_OPTIMIZATION_DECLARATIONS_ONLY

#if CV_AVX2

namespace
{

#if CV_AVX512_SKX
#define AQORB_WIDE(name) _mm512_##name
typedef __m512i Wide;
CV_ALWAYS_INLINE Wide load(const void* p)
{
    return _mm512_loadu_si512(p);
}
CV_ALWAYS_INLINE void store(void* p, Wide a)
{
    _mm512_storeu_si512(p, a);
}
#else
#define AQORB_WIDE(name) _mm256_##name
typedef __m256i Wide;
CV_ALWAYS_INLINE Wide load(const void* p)
{
    return _mm256_loadu_si256(static_cast<const __m256i*>(p));
}
CV_ALWAYS_INLINE void store(void* p, Wide a)
{
    _mm256_storeu_si256(static_cast<__m256i*>(p), a);
}
#endif
const int LANES = int(sizeof(Wide) / sizeof(short));

// Loads the source bytes of as many groups as the vector holds, one in each 128 bits.
CV_ALWAYS_INLINE Wide loadGroups(const uchar* source, const int* base)
{
    __m128i groups[sizeof(Wide) / sizeof(__m128i)];
    for (size_t i = 0; i < sizeof(Wide) / sizeof(__m128i); i++)
        groups[i] = _mm_loadu_si128(reinterpret_cast<const __m128i*>(source + base[i]));
    const __m256i low = _mm256_inserti128_si256(_mm256_castsi128_si256(groups[0]), groups[1], 1);
#if CV_AVX512_SKX
    const __m256i high = _mm256_inserti128_si256(_mm256_castsi128_si256(groups[2]), groups[3], 1);
    return _mm512_inserti64x4(_mm512_castsi256_si512(low), high, 1);
#else
    return low;
#endif
}

// Stores signed 16-bit numbers as bytes: saturated to 8 bits, then offset to unsigned ones.
CV_ALWAYS_INLINE void storeBytes(uchar* p, Wide a)
{
    const Wide bytes = AQORB_WIDE(add_epi8)(AQORB_WIDE(packs_epi16)(a, a), AQORB_WIDE(set1_epi8)(-128));
#if CV_AVX512_SKX
    const __m512i inOrder = _mm512_permutexvar_epi64(_mm512_setr_epi64(0, 2, 4, 6, 0, 2, 4, 6), bytes);
    _mm256_storeu_si256(reinterpret_cast<__m256i*>(p), _mm512_castsi512_si256(inOrder));
#else
    const __m256i inOrder = _mm256_permute4x64_epi64(bytes, 0x08);
    _mm_storeu_si128(reinterpret_cast<__m128i*>(p), _mm256_castsi256_si128(inOrder));
#endif
}

// The horizontal pass. Its pixels are in 1/256, less 2^15 so that they fit into signed 16-bit numbers, and plus the
// 2^7 by which the second pass rounds.
void resizeRow(const uchar* source, const ResizeBlock* blocks, int count, short* out)
{
    const Wide bias = AQORB_WIDE(set1_epi16)(short(128 - 32768));
    const int GROUPS = LANES / ResizeBlock::GROUP;
    for (int i = 0; i < count; i++)
    {
        const ResizeBlock& block = blocks[i];
        for (int group = 0; group < ResizeBlock::GROUPS; group += GROUPS, out += LANES)
        {
            const Wide pixels = loadGroups(source, block.base + group);
            const Wide a = AQORB_WIDE(shuffle_epi8)(pixels, load(block.a[group]));
            const Wide b = AQORB_WIDE(shuffle_epi8)(pixels, load(block.b[group]));
            const Wide weight = load(block.weight + group * ResizeBlock::GROUP);
            const Wide part = AQORB_WIDE(mullo_epi16)(AQORB_WIDE(sub_epi16)(b, a), weight);
            const Wide whole = AQORB_WIDE(add_epi16)(AQORB_WIDE(slli_epi16)(a, 8), bias);
            store(out, AQORB_WIDE(add_epi16)(whole, part));
        }
    }
}

// The vertical pass: pixels between two rows, less 128, as signed 16-bit numbers.
CV_ALWAYS_INLINE Wide between(const short* upper, const short* lower, Wide weights)
{
    const Wide u = load(upper), l = load(lower);
    const Wide first = AQORB_WIDE(madd_epi16)(AQORB_WIDE(unpacklo_epi16)(u, l), weights);
    const Wide second = AQORB_WIDE(madd_epi16)(AQORB_WIDE(unpackhi_epi16)(u, l), weights);
    return AQORB_WIDE(packs_epi32)(AQORB_WIDE(srai_epi32)(first, 16), AQORB_WIDE(srai_epi32)(second, 16));
}

void blendRows(const short* upper, const short* lower, int lowerWeight, int width, uchar* out)
{
    const Wide weights = AQORB_WIDE(set1_epi32)((lowerWeight << 16) | (256 - lowerWeight));
    int x = 0;
    for (; x + LANES <= width; x += LANES)
        storeBytes(out + x, between(upper + x, lower + x, weights));
    if (x < width)
    {
        uchar last[LANES];
        storeBytes(last, between(upper + x, lower + x, weights));
        for (int i = x; i < width; i++)
            out[i] = last[i - x];
    }
}
#undef AQORB_WIDE

}  // namespace

bool resizeRows(const Resize& resize, int begin, int end)
{
    const int blocks = (resize.width + ResizeBlock::PIXELS - 1) / ResizeBlock::PIXELS;
    int held[2] = {-1, -1};  // the source rows in resize.rows
    for (int y = begin; y < end; y++)
    {
        const int rows[2] = {resize.upper[y], resize.lower[y]};
        for (int i = 0; i < 2; i++)
        {
            const int slot = rows[i] & 1;
            if (held[slot] != rows[i])
                resizeRow(resize.source + rows[i] * resize.sourceStep, resize.blocks, blocks,
                          resize.rows[slot]);
            held[slot] = rows[i];
        }
        blendRows(resize.rows[rows[0] & 1], resize.rows[rows[1] & 1], resize.lowerWeight[y], resize.width,
                  resize.destination + y * resize.destinationStep);
    }
    return true;
}

#else

bool resizeRows(const Resize&, int, int)
{
    return false;
}

#endif

#endif  // CV_CPU_OPTIMIZATION_DECLARATIONS_ONLY

CV_CPU_OPTIMIZATION_NAMESPACE_END
}  // namespace stages
}  // namespace aqorb
}  // namespace cv
