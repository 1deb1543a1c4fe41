// This file is part of the aqorb project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.

#include "kernels.hpp"
#include "simd_compat.hpp"

namespace cv
{
namespace aqorb
{
namespace stages
{
CV_CPU_OPTIMIZATION_NAMESPACE_BEGIN

//! Computes destination rows [begin, end). False: there is no kernel for this CPU, and nothing was done.
bool resizeRows(const Resize& resize, int begin, int end);

#ifndef CV_CPU_OPTIMIZATION_DECLARATIONS_ONLY

#if CV_AVX2

namespace
{

// 8-bit pixels in 1/256, less 2^15, plus the 2^7 that rounds the second pass: a signed 16-bit number.
void resizeRow(const uchar* source, const ResizeBlock* blocks, int count, short* out)
{
    const __m256i bias = _mm256_set1_epi16(short(128 - 32768));
    for (int i = 0; i < count; i++)
    {
        const ResizeBlock& block = blocks[i];
        const __m128i low = _mm_loadu_si128(reinterpret_cast<const __m128i*>(source + block.base[0]));
        const __m128i high = _mm_loadu_si128(reinterpret_cast<const __m128i*>(source + block.base[1]));
        const __m256i pixels = _mm256_inserti128_si256(_mm256_castsi128_si256(low), high, 1);
        const __m256i a =
            _mm256_shuffle_epi8(pixels, _mm256_loadu_si256(reinterpret_cast<const __m256i*>(block.a)));
        const __m256i b =
            _mm256_shuffle_epi8(pixels, _mm256_loadu_si256(reinterpret_cast<const __m256i*>(block.b)));
        const __m256i weight = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(block.weight));
        const __m256i sum =
            _mm256_add_epi16(_mm256_slli_epi16(a, 8), _mm256_mullo_epi16(_mm256_sub_epi16(b, a), weight));
        _mm256_storeu_si256(reinterpret_cast<__m256i*>(out + 16 * i), _mm256_add_epi16(sum, bias));
    }
}

// 16 pixels between two rows, as signed 16-bit numbers less 128
CV_ALWAYS_INLINE __m256i between(const short* upper, const short* lower, __m256i weights)
{
    const __m256i u = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(upper));
    const __m256i l = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(lower));
    const __m256i first = _mm256_srai_epi32(_mm256_madd_epi16(_mm256_unpacklo_epi16(u, l), weights), 16);
    const __m256i second = _mm256_srai_epi32(_mm256_madd_epi16(_mm256_unpackhi_epi16(u, l), weights), 16);
    return _mm256_packs_epi32(first, second);
}

void blendRows(const short* upper, const short* lower, int lowerWeight, int width, uchar* out)
{
    const __m256i weights = _mm256_set1_epi32((lowerWeight << 16) | (256 - lowerWeight)),
                  sign = _mm256_set1_epi8(-128);
    for (int x = 0; x < width; x += 16)
    {
        const __m256i v = between(upper + x, lower + x, weights);
        const __m256i bytes = _mm256_xor_si256(_mm256_packs_epi16(v, v), sign);
        const __m128i pixels = _mm256_castsi256_si128(_mm256_permute4x64_epi64(bytes, 0x08));
        if (x + 16 <= width)
        {
            _mm_storeu_si128(reinterpret_cast<__m128i*>(out + x), pixels);
            continue;
        }
        uchar last[16];
        _mm_storeu_si128(reinterpret_cast<__m128i*>(last), pixels);
        for (int i = x; i < width; i++)
            out[i] = last[i - x];
    }
}

}  // namespace

bool resizeRows(const Resize& resize, int begin, int end)
{
    const int blocks = (resize.width + 15) / 16;
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
