// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// Kernel of the resize: a horizontal and a vertical pass.

#include "detector/pyramid.hpp"
#include "common/simd_compat.hpp"

#include <cstring>

namespace cv
{
namespace aqorb
{
CV_CPU_OPTIMIZATION_NAMESPACE_BEGIN

//! Resizes by INTER_LINEAR_EXACT. Returns false, and does nothing, if this CPU has no kernel.
bool resizeRows(const Resize& resize);

#ifndef CV_CPU_OPTIMIZATION_DECLARATIONS_ONLY

#ifdef AQORB_PICKS_BYTES

namespace
{

const int LANES = CV_SIMD_WIDTH / 2, PIXELS = CV_SIMD_WIDTH;

// Horizontal pass for the groups of a vector. Pixels are in units of 1/256, minus 2^15 to fit signed 16-bit numbers,
// plus 2^7 for the rounding of the vertical pass.
CV_ALWAYS_INLINE void resizeGroup(const uchar* source, const int* bases, const ResizeBlock& block, int group,
                                  short* out)
{
    const v_uint8 pairs = pick(loadEach(source, bases + group), vx_load(block.pairs[group]));
    v_store(out, v_add_wrap(weighPairs(pairs, vx_load(block.weights[group])), vx_setall_s16(128)));
}

// Vertical pass.
CV_ALWAYS_INLINE void blend(const short* upper, const short* lower, int lowerWeight, uchar* out)
{
    // Saturates to signed 8 bits, then shifts to unsigned.
    const v_int8 pixels = v_pack(blendHigh(vx_load(upper), vx_load(lower), lowerWeight),
                                 blendHigh(vx_load(upper + LANES), vx_load(lower + LANES), lowerWeight));
    v_store(out, v_xor(v_reinterpret_as_u8(pixels), vx_setall_u8(128)));
}

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
    if (width < PIXELS)
    {
        uchar pixels[PIXELS];
        blend(upper, lower, lowerWeight, pixels);
        std::memcpy(out, pixels, size_t(width));
        return;
    }
    for (int x = 0; x < width; x += PIXELS)
    {
        // The last vector may overlap the vector before.
        const int first = x < width - PIXELS ? x : width - PIXELS;
        blend(upper + first, lower + first, lowerWeight, out + first);
    }
}

}  // namespace

bool resizeRows(const Resize& resize)
{
    const int blocks = (resize.width + ResizeBlock::PIXELS - 1) / ResizeBlock::PIXELS;
    int loaded[2] = {-1, -1};  // source rows in resize.rows
    for (int y = 0; y < resize.height; y++)
    {
        const ResizeTaps& taps = resize.rowTaps[y];
        const int rows[2] = {taps.first, taps.second};
        for (int i = 0; i < 2; i++)
        {
            const int slot = rows[i] & 1;
            if (loaded[slot] != rows[i])
                resizeRow(resize.source + rows[i] * resize.sourceStep, resize, blocks, resize.rows[slot]);
            loaded[slot] = rows[i];
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
