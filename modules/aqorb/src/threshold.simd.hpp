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
namespace stages
{
CV_CPU_OPTIMIZATION_NAMESPACE_BEGIN

//! Adds the pixels of a row and their squares.
void sumRow(const uchar* row, int width, uint64& sum, uint64& squares);

#ifndef CV_CPU_OPTIMIZATION_DECLARATIONS_ONLY

void sumRow(const uchar* row, int width, uint64& sum, uint64& squares)
{
    int x = 0;
#if CV_SIMD
    const int LANES = AQORB_LANES(v_uint8), FLUSH = 1024 * LANES;  // so many squares fit into 32 bits
    const v_uint8 one = vx_setall_u8(1);
    while (x + LANES <= width)
    {
        v_uint32 sums = vx_setzero_u32(), squareSums = vx_setzero_u32();
        const int end = x + FLUSH < width ? x + FLUSH : width;
        for (; x + LANES <= end; x += LANES)
        {
            const v_uint8 v = vx_load(row + x);
            sums = v_dotprod_expand_fast(v, one, sums);
            squareSums = v_dotprod_expand_fast(v, v, squareSums);
        }
        sum += v_reduce_sum(sums);
        squares += v_reduce_sum(squareSums);
    }
#endif
    for (; x < width; x++)
    {
        sum += row[x];
        squares += unsigned(row[x]) * row[x];
    }
}

#endif  // CV_CPU_OPTIMIZATION_DECLARATIONS_ONLY

CV_CPU_OPTIMIZATION_NAMESPACE_END
}  // namespace stages
}  // namespace aqorb
}  // namespace cv
