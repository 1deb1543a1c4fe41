// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "pyramid.hpp"
#include "simd_compat.hpp"

#include <cstring>

namespace cv
{
namespace aqorb
{
CV_CPU_OPTIMIZATION_NAMESPACE_BEGIN

//! Computes the destination. Returns false, and does nothing, if there is no kernel for this CPU.
bool resizeRows(const Resize& resize);

#ifndef CV_CPU_OPTIMIZATION_DECLARATIONS_ONLY

#if (CV_SSSE3 && CV_SIMD) || CV_NEON

namespace
{

#if CV_NEON

const int LANES = 8, PIXELS = 8;  // of which a group is made, and of which bytes are made

CV_ALWAYS_INLINE uint8x16_t pick(const uint8x16_t& bytes, const uint8x16_t& indices)
{
#if defined(__aarch64__) || defined(_M_ARM64)
    return vqtbl1q_u8(bytes, indices);
#else
    const uint8x8x2_t halves = {{vget_low_u8(bytes), vget_high_u8(bytes)}};
    return vcombine_u8(vtbl2_u8(halves, vget_low_u8(indices)), vtbl2_u8(halves, vget_high_u8(indices)));
#endif
}

CV_ALWAYS_INLINE uint16x8_t addPairs(const uint16x8_t& a, const uint16x8_t& b)
{
#if defined(__aarch64__) || defined(_M_ARM64)
    return vpaddq_u16(a, b);
#else
    return vcombine_u16(vpadd_u16(vget_low_u16(a), vget_high_u16(a)),
                        vpadd_u16(vget_low_u16(b), vget_high_u16(b)));
#endif
}

// The horizontal pass. Its pixels are in 1/256, as unsigned 16-bit numbers.
CV_ALWAYS_INLINE void resizeGroup(const uchar* source, const int* bases, const ResizeBlock& block, int group,
                                  short* out)
{
    const uint8x16_t pairs = pick(vld1q_u8(source + bases[group]), vld1q_u8(block.pairs[group]));
    const uint8x16_t weights = vld1q_u8(block.weights[group]);
    const uint16x8_t low = vmull_u8(vget_low_u8(pairs), vget_low_u8(weights)),
                     high = vmull_u8(vget_high_u8(pairs), vget_high_u8(weights));
    vst1q_s16(out, vreinterpretq_s16_u16(addPairs(low, high)));
}

// The vertical pass.
class Blend
{
public:
    explicit Blend(int weight)
        : upperWeight(vdup_n_u16(ushort(256 - weight))), lowerWeight(vdup_n_u16(ushort(weight)))
    {
    }
    CV_ALWAYS_INLINE void store(const short* upper, const short* lower, uchar* out) const
    {
        const uint16x8_t u = vreinterpretq_u16_s16(vld1q_s16(upper)),
                         l = vreinterpretq_u16_s16(vld1q_s16(lower));
        const uint32x4_t first =
            vmlal_u16(vmull_u16(vget_low_u16(u), upperWeight), vget_low_u16(l), lowerWeight);
        const uint32x4_t second =
            vmlal_u16(vmull_u16(vget_high_u16(u), upperWeight), vget_high_u16(l), lowerWeight);
        vst1_u8(out, vmovn_u16(vcombine_u16(vrshrn_n_u32(first, 16), vrshrn_n_u32(second, 16))));
    }

private:
    uint16x4_t upperWeight, lowerWeight;
};

#else

#if CV_SIMD_WIDTH == 64
#define AQORB_WIDE(name) _mm512_##name
#elif CV_SIMD_WIDTH == 32
#define AQORB_WIDE(name) _mm256_##name
#else
#define AQORB_WIDE(name) _mm_##name
#endif
typedef decltype(v_uint8().val) Wide;
const int LANES = CV_SIMD_WIDTH / 2, PIXELS = CV_SIMD_WIDTH;

CV_ALWAYS_INLINE Wide load(const void* p)
{
    return vx_load(static_cast<const uchar*>(p)).val;
}

// Loads the source bytes of as many groups as the vector holds, one in each 128 bits.
CV_ALWAYS_INLINE Wide loadGroups(const uchar* source, const int* base)
{
#if CV_SIMD_WIDTH == 16
    return load(source + base[0]);
#else
    const __m256i low = v256_load_halves(source + base[0], source + base[1]).val;
#if CV_SIMD_WIDTH == 32
    return low;
#else
    const __m256i high = v256_load_halves(source + base[2], source + base[3]).val;
    return _mm512_inserti64x4(_mm512_castsi256_si512(low), high, 1);
#endif
#endif
}

// The horizontal pass, for as many groups as the vector holds. Its pixels are in 1/256, less 2^15 so that they fit into
// signed 16-bit numbers, and plus the 2^7 by which the second pass rounds.
CV_ALWAYS_INLINE void resizeGroup(const uchar* source, const int* bases, const ResizeBlock& block, int group,
                                  short* out)
{
    const Wide bytes = AQORB_WIDE(sub_epi8)(loadGroups(source, bases + group), AQORB_WIDE(set1_epi8)(-128));
    const Wide pairs = AQORB_WIDE(shuffle_epi8)(bytes, load(block.pairs[group]));
    const Wide pixels = AQORB_WIDE(maddubs_epi16)(load(block.weights[group]), pairs);
    v_store(out, v_int16(AQORB_WIDE(add_epi16)(pixels, AQORB_WIDE(set1_epi16)(128))));
}

// The vertical pass.
class Blend
{
public:
    explicit Blend(int lowerWeight)
        : weights(AQORB_WIDE(set1_epi32)((lowerWeight << 16) | (256 - lowerWeight)))
    {
    }
    CV_ALWAYS_INLINE void store(const short* upper, const short* lower, uchar* out) const
    {
        // Saturated to 8 bits, then offset to unsigned ones.
        const v_int8 pixels = v_pack(between(upper, lower), between(upper + LANES, lower + LANES));
        v_store(out, v_xor(v_reinterpret_as_u8(pixels), vx_setall_u8(128)));
    }

private:
    // The pixels less 128, as signed 16-bit numbers.
    CV_ALWAYS_INLINE v_int16 between(const short* upper, const short* lower) const
    {
        const Wide u = load(upper), l = load(lower);
        const Wide first = AQORB_WIDE(madd_epi16)(AQORB_WIDE(unpacklo_epi16)(u, l), weights);
        const Wide second = AQORB_WIDE(madd_epi16)(AQORB_WIDE(unpackhi_epi16)(u, l), weights);
        return v_int16(
            AQORB_WIDE(packs_epi32)(AQORB_WIDE(srai_epi32)(first, 16), AQORB_WIDE(srai_epi32)(second, 16)));
    }

    Wide weights;
};
#undef AQORB_WIDE

#endif

void resizeRow(const uchar* source, const Resize& resize, int count, short* out)
{
    const int GROUPS = LANES / ResizeBlock::GROUP;
    const ResizeBlock* const blocks = resize.blocks;
    const int* bases = resize.bases;
    for (int i = 0; i < count; i++, bases += ResizeBlock::GROUPS)
        for (int group = 0; group < ResizeBlock::GROUPS; group += GROUPS, out += LANES)
            resizeGroup(source, bases, blocks[i], group, out);
}

void blendRows(const short* upper, const short* lower, int lowerWeight, int width, uchar* out)
{
    const Blend blend(lowerWeight);
    if (width < PIXELS)
    {
        uchar pixels[PIXELS];
        blend.store(upper, lower, pixels);
        std::memcpy(out, pixels, size_t(width));
        return;
    }
    for (int x = 0; x < width; x += PIXELS)
    {
        // The last vector may overlap the one before.
        const int first = x < width - PIXELS ? x : width - PIXELS;
        blend.store(upper + first, lower + first, out + first);
    }
}

}  // namespace

bool resizeRows(const Resize& resize)
{
    const int blocks = (resize.width + ResizeBlock::PIXELS - 1) / ResizeBlock::PIXELS;
    int held[2] = {-1, -1};  // the source rows in resize.rows
    for (int y = 0; y < resize.height; y++)
    {
        const ResizeTaps& taps = resize.rowTaps[y];
        const int rows[2] = {taps.first, taps.second};
        for (int i = 0; i < 2; i++)
        {
            const int slot = rows[i] & 1;
            if (held[slot] != rows[i])
                resizeRow(resize.source + rows[i] * resize.sourceStep, resize, blocks, resize.rows[slot]);
            held[slot] = rows[i];
        }
        blendRows(resize.rows[rows[0] & 1], resize.rows[rows[1] & 1], taps.secondWeight, resize.width,
                  resize.destination + y * resize.destinationStep);
    }
    return true;
}

#else

bool resizeRows(const Resize&)
{
    return false;
}

#endif

#endif  // CV_CPU_OPTIMIZATION_DECLARATIONS_ONLY

CV_CPU_OPTIMIZATION_NAMESPACE_END
}  // namespace aqorb
}  // namespace cv
