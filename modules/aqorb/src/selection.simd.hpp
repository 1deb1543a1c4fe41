// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// The kernels of the selection: which leaves have representatives, and their ranks.

#include "selection.hpp"
#include "simd_compat.hpp"

namespace cv
{
namespace aqorb
{
CV_CPU_OPTIMIZATION_NAMESPACE_BEGIN

/** Finds which leaves of a row represent their neighbourhood.
 @param keys of the best points of the leaves of the row; those of the rows above and below are stride elements away */
void flagRepresentatives(const int* keys, ptrdiff_t stride, int side, uchar* flags);

//! Counts the leaves that are set within the disc around each leaf. With `setsEach` each one is set before the next.
void countInDiscs(const RankGrid& grid, const unsigned* leaves, size_t count, bool setsEach, int* counts);

#ifndef CV_CPU_OPTIMIZATION_DECLARATIONS_ONLY

// Compilers vectorize this loop.
void flagRepresentatives(const int* keys, ptrdiff_t stride, int side, uchar* flags)
{
    const int *above = keys - stride, *below = keys + stride;
    for (int i = 0; i < side; i++)
    {
        const int own = keys[i];
        const int better = (above[i - 1] >= own) + (above[i] >= own) + (above[i + 1] >= own) +
                           (keys[i - 1] >= own) + (keys[i + 1] > own) + (below[i - 1] > own) +
                           (below[i] > own) + (below[i + 1] > own);
        flags[i] = uchar((own != INT_MIN) & (better <= MOST_BETTER_NEIGHBORS));
    }
}

void countInDiscs(const RankGrid& grid, const unsigned* leaves, size_t count, bool setsEach, int* counts)
{
    const unsigned columns = (1u << grid.depth) - 1, STEP = RankGrid::STEP;
    for (size_t i = 0; i < count; i++)
    {
        const unsigned column = leaves[i] & columns, row = leaves[i] >> grid.depth;
        const uint64* const word = grid.bits + size_t(row) * grid.stride + column / STEP;
        int sum = 0;
        for (int j = 0; j < grid.wordCount; j++)
            sum += bitCount((word[grid.words[j]] >> (column % STEP)) & grid.masks[j]);
        counts[i] = sum;
        if (!setsEach)
            continue;
        const unsigned bit = column + unsigned(grid.left);  // it lies in two words
        uint64* const own = grid.bits + size_t(row + unsigned(grid.top)) * grid.stride + bit / STEP + 1;
        own[0] |= uint64(1) << (bit % STEP);
        own[-1] |= uint64(1) << (bit % STEP + STEP);
    }
}

#endif  // CV_CPU_OPTIMIZATION_DECLARATIONS_ONLY

CV_CPU_OPTIMIZATION_NAMESPACE_END
}  // namespace aqorb
}  // namespace cv
