// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// Kernels of points 3 and 5 of the selection rule: counts of leaves.

#include "detector/selection.hpp"
#include "common/simd_compat.hpp"

namespace cv
{
namespace aqorb
{
CV_CPU_OPTIMIZATION_NAMESPACE_BEGIN

/** Counts, for each leaf of a row, how many of its eight neighbours have a better best point. Ties go to the upper
 leaf, then to the left leaf.
 @param keys key of each leaf's best point, greater is better; the rows above and below are stride elements away */
void countBetter(const int* keys, ptrdiff_t stride, int columns, uchar* counts);

/** Counts, for each leaf, the earlier leaves of the list within the disc around it.
 @param grid empty grid; receives the bits of all leaves */
void countBefore(const RankGrid& grid, const unsigned* leaves, size_t count, int* counts);

#ifndef CV_CPU_OPTIMIZATION_DECLARATIONS_ONLY

// Compilers vectorize this loop.
void countBetter(const int* keys, ptrdiff_t stride, int columns, uchar* counts)
{
    const int *above = keys - stride, *below = keys + stride;
    for (int i = 0; i < columns; i++)
    {
        const int key = keys[i];
        counts[i] =
            uchar((above[i - 1] >= key) + (above[i] >= key) + (above[i + 1] >= key) + (keys[i - 1] >= key) +
                  (keys[i + 1] > key) + (below[i - 1] > key) + (below[i] > key) + (below[i + 1] > key));
    }
}

void countBefore(const RankGrid& grid, const unsigned* leaves, size_t count, int* counts)
{
    const unsigned columns = (1u << grid.columnBits) - 1, STEP = RankGrid::STEP;
    for (size_t i = 0; i < count; i++)
    {
        const unsigned column = leaves[i] & columns, row = leaves[i] >> grid.columnBits;
        const uint64* const word = grid.bits + size_t(row) * grid.stride + column / STEP;
        int sum = 0;
        for (int j = 0; j < grid.wordCount; j++)
            sum += bitCount((word[grid.words[j]] >> (column % STEP)) & grid.masks[j]);
        counts[i] = sum;
        // The bit of the leaf lies in two words.
        const unsigned bit = column + unsigned(grid.left);
        uint64* const words = grid.bits + size_t(row + unsigned(grid.top)) * grid.stride + bit / STEP + 1;
        words[0] |= uint64(1) << (bit % STEP);
        words[-1] |= uint64(1) << (bit % STEP + STEP);
    }
}

#endif  // CV_CPU_OPTIMIZATION_DECLARATIONS_ONLY

CV_CPU_OPTIMIZATION_NAMESPACE_END
}  // namespace aqorb
}  // namespace cv
