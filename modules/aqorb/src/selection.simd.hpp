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

/** Counts, for each leaf, the leaves before it within the disc around it.
 @param grid without any bit; afterwards it has those of all leaves */
void countBefore(const RankGrid& grid, const unsigned* leaves, size_t count, int* counts);

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

void countBefore(const RankGrid& grid, const unsigned* leaves, size_t count, int* counts)
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
        // The bit of the leaf lies in two words of its row, and in two of the row before.
        const unsigned bit = column + unsigned(grid.left);
        uint64* const own = grid.bits + size_t(row + unsigned(grid.top)) * grid.stride + bit / STEP + 1;
        const uint64 inSecond = uint64(1) << (bit % STEP), inFirst = inSecond << STEP;
        own[0] |= inSecond;
        own[-1] |= inFirst;
        own[-grid.stride] |= inSecond << 32;
        own[-grid.stride - 1] |= inFirst << 32;
    }
}

#endif  // CV_CPU_OPTIMIZATION_DECLARATIONS_ONLY

CV_CPU_OPTIMIZATION_NAMESPACE_END
}  // namespace aqorb
}  // namespace cv
