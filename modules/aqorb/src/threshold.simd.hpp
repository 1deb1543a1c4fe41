// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "simd_compat.hpp"
#include "threshold.hpp"

#include <cstring>

namespace cv
{
namespace aqorb
{
namespace stages
{
CV_CPU_OPTIMIZATION_NAMESPACE_BEGIN

//! Adds the pixels of rows and their squares.
void sumRows(const uchar* rows, ptrdiff_t step, int width, int height, uint64& sum, uint64& squares);

#ifndef CV_CPU_OPTIMIZATION_DECLARATIONS_ONLY

void sumRows(const uchar* rows, ptrdiff_t step, int width, int height, uint64& sum, uint64& squares)
{
#if CV_SIMD
    const int LANES = AQORB_LANES(v_uint8), MOST = 1024;  // so many vectors of squares fit into 32 bits
    const v_uint8 low = v_reinterpret_as_u8(vx_setall_u16(0x00ff));
    const v_uint16 one = vx_setall_u16(1);
    v_uint32 sums = vx_setzero_u32(), squareSums = vx_setzero_u32();
    int added = 0;
    uchar counted[2 * CV_SIMD_WIDTH];  // from LANES on: all lanes, from i lanes before: all but the first i
    std::memset(counted, 0, LANES);
    std::memset(counted + LANES, 255, LANES);
#endif
    for (int y = 0; y < height; y++)
    {
        const uchar* row = rows + y * step;
        int x = 0;
#if CV_SIMD
        for (; x < width && width >= LANES; x += LANES)
        {
            // The last vector overlaps the one before, whose pixels do not count again.
            const int first = std::min(x, width - LANES);
            const v_uint8 v = v_and(vx_load(row + first), vx_load(counted + LANES - (x - first)));
            const v_int16 even = v_reinterpret_as_s16(v_and(v, low));
            const v_int16 odd = v_reinterpret_as_s16(v_shr<8>(v_reinterpret_as_u16(v)));
            squareSums =
                v_add(squareSums, v_reinterpret_as_u32(v_add(v_dotprod(even, even), v_dotprod(odd, odd))));
            sums = v_add(sums, v_reinterpret_as_u32(v_dotprod(v_add(even, odd), v_reinterpret_as_s16(one))));
            if (++added == MOST)
            {
                sum += v_reduce_sum(sums);
                squares += v_reduce_sum(squareSums);
                sums = squareSums = vx_setzero_u32();
                added = 0;
            }
        }
#endif
        for (; x < width; x++)
        {
            sum += row[x];
            squares += unsigned(row[x]) * row[x];
        }
    }
#if CV_SIMD
    sum += v_reduce_sum(sums);
    squares += v_reduce_sum(squareSums);
#endif
}

#endif  // CV_CPU_OPTIMIZATION_DECLARATIONS_ONLY

CV_CPU_OPTIMIZATION_NAMESPACE_END
}  // namespace stages
}  // namespace aqorb
}  // namespace cv
