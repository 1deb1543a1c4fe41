// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// The search for the nearest descriptors, and distances, in vectors of 16-bit numbers.

#include "hamming.hpp"
#ifndef CV_CPU_OPTIMIZATION_DECLARATIONS_ONLY
#include "hamming_distance.hpp"
#endif

namespace cv
{
namespace aqorb
{
CV_CPU_OPTIMIZATION_NAMESPACE_BEGIN

const HammingKernels* kernelsFor(bool countPairs, int bytes);

#ifndef CV_CPU_OPTIMIZATION_DECLARATIONS_ONLY

#if CV_SIMD && (CV_SSE2 || CV_NEON)

namespace
{

//! Puts 16-bit keys into lists of the KEPT smallest ones of each lane.
template <int KEPT> inline void insertKeys(v_uint16* smallest, const v_uint16& keys)
{
    if (KEPT == 2)
        smallest[KEPT - 1] = v_min(smallest[KEPT - 1], v_max(smallest[0], keys));
    smallest[0] = v_min(smallest[0], keys);
}

//! Of 16 bits, in a vector.
const int MAX_LANES = 32;

//! A key of 16 bits is a distance and, in the lower bits, a number. This one stands for none.
const ushort NO_KEY16 = 0xffff;

//! The key of a train of the tile from that of a block and the lane, which is the lowest one that is set.
inline DistanceKey keyOfLane(int key, uint64 lanes, const HammingTile& tile)
{
    const int block = key & ((1 << tile.indexBits) - 1);
    const int train = tile.firstTrain + block * AQORB_LANES(v_uint16) + trailingZeros(lanes);
    return key == NO_KEY16 ? NO_KEY : distanceKey(key >> tile.indexBits, train);
}

//! Puts the smallest keys of a query, which are those of its lanes, into its list.
template <int KEPT> inline void mergeLanes(const ushort* lanes, const HammingTile& tile, DistanceKey* list)
{
    v_uint16 keys = vx_load(lanes);
    int smallest = v_reduce_min(keys);
    v_uint16 same = v_eq(keys, vx_setall_u16(ushort(smallest)));
    uint64 where = signBits(same);
    keepKey<KEPT>(list, keyOfLane(smallest, where, tile));
    if (KEPT == 1)
        return;
    where &= where - 1;
    if (!where)
    {
        keys = v_select(same, vx_load(lanes + (KEPT - 1) * AQORB_LANES(v_uint16)), keys);
        smallest = v_reduce_min(keys);
        where = signBits(v_eq(keys, vx_setall_u16(ushort(smallest))));
    }
    keepKey<KEPT>(list, keyOfLane(smallest, where, tile));
}

template <bool PAIRS, int WORDS, int KEPT, bool BOTH>
void nearest(const HammingTile& tile, DistanceKey* ofQueries, DistanceKey* ofTrains)
{
    const int count = AQORB_LANES(v_uint16), words = WORDS ? WORDS : tile.words;
    const int queryWords = words * Packing<PAIRS>::QUERY_PLANES;
    const int blockWords = words * Packing<PAIRS>::TRAIN_PLANES * 4 * AQORB_LANES(v_uint64);
    const KeyMaker maker(tile.indexBits);
    const v_uint16 ones = vx_setall_u16(ushort(maker.one));
    for (int i = 0; i < tile.queryCount * KEPT; i++)
        v_store(tile.scratch + i * count, vx_setall_u16(NO_KEY16));
    for (int b = (tile.trainCount - 1) / count; b >= 0; b--)
    {
        const uint64* block = tile.trains + size_t(b) * blockWords;
        uint64 registers[WORDS * 32 + 1];
        if (Packing<PAIRS>::IN_REGISTERS && WORDS)
            block = static_cast<uint64*>(std::memcpy(registers, block, WORDS * 32 * sizeof(uint64)));
        const v_uint16 number = vx_setall_u16(ushort(b * maker.one));
        v_uint16 query = vx_setzero_u16(), best[2] = {vx_setall_u16(NO_KEY16), vx_setall_u16(NO_KEY16)};
        ushort* lanes = tile.scratch;
        for (int i = 0; i < tile.queryCount; i++, lanes += KEPT * count)
        {
            const v_uint16 distances =
                blockDistances<PAIRS, WORDS>(tile.queries + size_t(i) * queryWords, block, words);
            v_uint16 smallest[2] = {vx_load(lanes), vx_load(lanes + (KEPT - 1) * count)};
            insertKeys<KEPT>(smallest, maker.keys(distances, number));
            for (int k = 0; k < KEPT; k++)
                v_store(lanes + k * count, smallest[k]);
            if (BOTH)
            {
                insertKeys<KEPT>(best, maker.keys(distances, query));
                query = v_add_wrap(query, ones);
            }
        }
        // The last block comes first. What fills it has no keys.
        const int left = tile.trainCount - b * count, filled = left < count ? left : count;
        ushort fill[MAX_LANES];
        for (int i = 0; i < count; i++)
            fill[i] = i < filled ? 0 : NO_KEY16;
        for (int i = filled < count ? 0 : tile.queryCount * KEPT; i < tile.queryCount * KEPT; i++)
            v_store(tile.scratch + i * count, v_or(vx_load(tile.scratch + i * count), vx_load(fill)));
        if (BOTH)
        {
            ushort keys[2][MAX_LANES];
            for (int k = 0; k < KEPT; k++)
                v_store(keys[k], best[k]);
            DistanceKey* list = ofTrains + size_t(b) * count * KEPT;
            for (int i = 0; i < filled; i++, list += KEPT)
            {
                for (int k = 0; k < KEPT; k++)
                {
                    const int key = keys[k][i], query16 = key & ((1 << tile.indexBits) - 1);
                    const DistanceKey all = distanceKey(key >> tile.indexBits, tile.firstQuery + query16);
                    keepKey<KEPT>(list, key == NO_KEY16 ? NO_KEY : all);
                }
            }
        }
    }
    for (int i = 0; i < tile.queryCount; i++)
        mergeLanes<KEPT>(tile.scratch + size_t(i) * KEPT * count, tile, ofQueries + size_t(i) * KEPT);
}

template <bool PAIRS, int WORDS> void distances(const HammingTile& tile, int* out, size_t stride)
{
    const int count = AQORB_LANES(v_uint16), words = WORDS ? WORDS : tile.words;
    const int queryWords = words * Packing<PAIRS>::QUERY_PLANES;
    const int blockWords = words * Packing<PAIRS>::TRAIN_PLANES * 4 * AQORB_LANES(v_uint64);
    for (int first = 0; first < tile.trainCount; first += count)
    {
        const uint64* const block = tile.trains + size_t(first / count) * blockWords;
        for (int i = 0; i < tile.queryCount; i++)
        {
            v_uint32 low, high;
            v_expand(blockDistances<PAIRS, WORDS>(tile.queries + size_t(i) * queryWords, block, words), low,
                     high);
            v_store(out + i * stride + first, v_reinterpret_as_s32(low));
            v_store(out + i * stride + first + count / 2, v_reinterpret_as_s32(high));
        }
    }
}

template <bool PAIRS, int WORDS> const HammingKernels* table()
{
    static const HammingKernels kernels = {
        AQORB_LANES(v_uint16),
        Packing<PAIRS>::QUERY_PLANES,
        Packing<PAIRS>::TRAIN_PLANES,
        Packing<PAIRS>::packQueries,
        Packing<PAIRS>::packTrains,
        {{nearest<PAIRS, WORDS, 1, false>, nearest<PAIRS, WORDS, 1, true>},
         {nearest<PAIRS, WORDS, 2, false>, nearest<PAIRS, WORDS, 2, true>}},
        distances<PAIRS, WORDS>};
    return &kernels;
}

}  // namespace

const HammingKernels* kernelsFor(bool countPairs, int bytes)
{
#if CV_AVX_512BITALG
    if (countPairs)
        return &plainHammingKernels(true);
#else
    if (countPairs)
        return table<true, 0>();
#endif
    return bytes > 24 && bytes <= 32 ? table<false, 4>() : table<false, 0>();
}

#else

const HammingKernels* kernelsFor(bool countPairs, int)
{
    return &plainHammingKernels(countPairs);
}

#endif

#endif  // CV_CPU_OPTIMIZATION_DECLARATIONS_ONLY

CV_CPU_OPTIMIZATION_NAMESPACE_END
}  // namespace aqorb
}  // namespace cv
