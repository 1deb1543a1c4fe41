// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "simd_compat.hpp"
#include "threshold.hpp"

namespace cv
{
namespace aqorb
{
CV_CPU_OPTIMIZATION_NAMESPACE_BEGIN

//! Adds the pixels of rows and their squares.
void sumRows(const uchar* rows, ptrdiff_t step, int width, int height, uint64& sum, uint64& squares);

#ifndef CV_CPU_OPTIMIZATION_DECLARATIONS_ONLY

void sumRows(const uchar* rows, ptrdiff_t step, int width, int height, uint64& sum, uint64& squares)
{
#if CV_SIMD
    const int LANES = AQORB_LANES(v_uint8);
    const v_uint8 one = vx_setall_u8(1);
#endif
    for (int y = 0; y < height; y++)
    {
        const uchar* row = rows + y * step;
        for (int x = 0; x < width;)
        {
            const int MOST = 1 << 15;  // so many squares fit into 32 bits
            const int end = width < x + MOST ? width : x + MOST;
#if CV_SIMD
            v_uint32 sums = vx_setzero_u32(), squareSums = sums;
            for (; x + LANES <= end; x += LANES)
            {
                const v_uint8 v = vx_load(row + x);
                sums = v_add(sums, v_dotprod_expand_fast(v, one));
                squareSums = v_add(squareSums, v_dotprod_expand_fast(v, v));
            }
            sum += v_reduce_sum(sums);
            squares += v_reduce_sum(squareSums);
#endif
            for (; x < end; x++)
            {
                sum += row[x];
                squares += unsigned(row[x]) * row[x];
            }
        }
    }
}

#endif  // CV_CPU_OPTIMIZATION_DECLARATIONS_ONLY

CV_CPU_OPTIMIZATION_NAMESPACE_END
}  // namespace aqorb
}  // namespace cv
