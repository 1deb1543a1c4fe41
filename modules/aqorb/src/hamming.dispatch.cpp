// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// The kernels that every CPU has, and the choice of those for this CPU.

#include "precomp.hpp"

#include "hamming.hpp"

#include "hamming.simd.hpp"
#include "hamming.simd_declarations.hpp"

// Whoever disables AVX512-SKX by OPENCV_CPU_DISABLE means what builds on it, too. Pairs of bits have no kernel there.
#if CV_TRY_AVX512_ICL && !CV_CPU_FORCE_AVX512_ICL
#undef CV_CPU_HAS_SUPPORT_AVX512_ICL
#define CV_CPU_HAS_SUPPORT_AVX512_ICL                              \
    (!countPairs && cv::checkHardwareSupport(CV_CPU_AVX512_ICL) && \
     cv::checkHardwareSupport(CV_CPU_AVX512_SKX))
#endif

namespace cv
{
namespace aqorb
{

namespace
{

template <bool PAIRS> int distanceOfPacked(const uint64* a, const uint64* b, int words)
{
    int distance = 0;
    for (int i = 0; i < words; i++)
        distance += wordDistance<PAIRS>(a[i], b[i]);
    return distance;
}

void pack(const uchar* rows, size_t step, int count, int bytes, uint64* packed)
{
    const size_t words = size_t(bytes + 7) / 8;
    std::memset(packed, 0, count * words * sizeof(uint64));
    for (int i = 0; i < count; i++)
        std::memcpy(packed + i * words, rows + i * step, size_t(bytes));
}

template <bool PAIRS, int KEPT, bool BOTH>
void nearest(const HammingTile& tile, DistanceKey* ofQueries, DistanceKey* ofTrains)
{
    for (int i = 0; i < tile.queryCount; i++)
    {
        for (int j = 0; j < tile.trainCount; j++)
        {
            const int distance = distanceOfPacked<PAIRS>(tile.queries + size_t(i) * tile.words,
                                                         tile.trains + size_t(j) * tile.words, tile.words);
            keepKey<KEPT>(ofQueries + size_t(i) * KEPT, distanceKey(distance, tile.firstTrain + j));
            if (BOTH)
                keepKey<KEPT>(ofTrains + size_t(j) * KEPT, distanceKey(distance, tile.firstQuery + i));
        }
    }
}

template <bool PAIRS> void distances(const HammingTile& tile, int* out, size_t stride)
{
    for (int i = 0; i < tile.queryCount; i++)
    {
        for (int j = 0; j < tile.trainCount; j++)
            out[i * stride + j] = distanceOfPacked<PAIRS>(tile.queries + size_t(i) * tile.words,
                                                          tile.trains + size_t(j) * tile.words, tile.words);
    }
}

template <bool PAIRS> const HammingKernels& table()
{
    static const HammingKernels kernels = {1,
                                           1,
                                           1,
                                           pack,
                                           pack,
                                           {{nearest<PAIRS, 1, false>, nearest<PAIRS, 1, true>},
                                            {nearest<PAIRS, 2, false>, nearest<PAIRS, 2, true>}},
                                           distances<PAIRS>};
    return kernels;
}

}  // namespace

const HammingKernels& plainHammingKernels(bool countPairs)
{
    return countPairs ? table<true>() : table<false>();
}

static const HammingKernels* dispatchedKernels(bool countPairs, int bytes)
{
    CV_CPU_DISPATCH(kernelsFor, (countPairs, bytes), CV_CPU_DISPATCH_MODES_ALL);
}

const HammingKernels& hammingKernels(bool countPairs, int bytes)
{
    return *dispatchedKernels(countPairs, bytes);
}

}  // namespace aqorb
}  // namespace cv
