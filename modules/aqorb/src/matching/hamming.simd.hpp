// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// Kernels of the Hamming matchers: nearest descriptors and distances, in vectors of 16-bit numbers.

#include "matching/hamming.hpp"
#include "common/simd_compat.hpp"

#include <cstring>

namespace cv
{
namespace aqorb
{
CV_CPU_OPTIMIZATION_NAMESPACE_BEGIN

const HammingKernels* kernelsFor(int words);

#ifndef CV_CPU_OPTIMIZATION_DECLARATIONS_ONLY

#ifdef AQORB_COUNTS_BITS

namespace
{

//! Number of words whose bits a byte can count.
const int WORDS_AT_ONCE = 31;

//! Distances of a query to the trains of a block. WORDS: words of a descriptor; 0: the argument `words` instead.
template <int WORDS>
CV_ALWAYS_INLINE v_uint16 blockDistances(const uint64* query, const uint64* block, int words)
{
    v_uint16 distances = vx_setzero_u16();
    for (int left = WORDS ? WORDS : words; left > 0; left -= WORDS_AT_ONCE)
    {
        const int packedWords = WORD_HALVES * (WORDS ? WORDS : left < WORDS_AT_ONCE ? left : WORDS_AT_ONCE);
        v_uint8 counts[4] = {vx_setzero_u8(), vx_setzero_u8(), vx_setzero_u8(), vx_setzero_u8()};
        for (int i = 0; i < packedWords; i++, query++, block += 4 * AQORB_LANES(v_uint64))
        {
            const v_uint64 word = vx_setall_u64(*query);
            for (int j = 0; j < 4; j++)
                counts[j] = addBits(counts[j], v_xor(word, vx_load(block + j * AQORB_LANES(v_uint64))));
        }
        distances = WORDS ? wordBits(counts) : v_add_wrap(distances, wordBits(counts));
    }
    return distances;
}

//! Lane of a train descriptor within its block, in the order of wordBits.
int laneOf(int train)
{
    return train % 8 / 2 * AQORB_LANES(v_uint64) + train / 8 * 2 + train % 2;
}

//! Largest number of 16-bit lanes in a vector.
const int MAX_LANES = 32;

//! No key. A 16-bit key holds a distance and, in the lower bits, the number of a query or a block.
const ushort NO_KEY16 = 0xffff;

//! Bits of the number in a 16-bit key. More queries in a tile would need more of the cache.
template <int WORDS> struct IndexBits
{
    enum
    {
        VALUE = WORDS ? 7 : 6
    };
};

//! A mask: all bits set in the lanes of the train descriptors that the query must not match.
CV_ALWAYS_INLINE v_uint16 excludedLanes(const uchar* allowed)
{
    return v_eq(vx_load_expand(allowed), vx_setzero_u16());
}

//! Inserts 16-bit keys into lists of the KEPT smallest keys of each lane.
template <int KEPT> CV_ALWAYS_INLINE void insertKeys(v_uint16* smallest, const v_uint16& keys)
{
    if (KEPT == 2)
        smallest[KEPT - 1] = v_min(smallest[KEPT - 1], v_max(smallest[0], keys));
    smallest[0] = v_min(smallest[0], keys);
}

//! Widens a 16-bit key. Its number becomes the index first + step * number.
template <int BITS> CV_ALWAYS_INLINE DistanceKey wideKey(int key, int first, int step)
{
    return key == NO_KEY16 ? NO_KEY : distanceKey(key >> BITS, first + step * (key & ((1 << BITS) - 1)));
}

//! Merges the smallest keys of a query's lanes into its list.
template <int KEPT, int BITS> void mergeLanes(const ushort* lanes, int firstTrain, DistanceKey* list)
{
    const int LANES = AQORB_LANES(v_uint16);
    v_uint16 keys = vx_load(lanes);
    int smallest = v_reduce_min(keys);
    v_uint16 same = v_eq(keys, vx_setall_u16(ushort(smallest)));
    uint64 where = signBits(same);
    keepKey<KEPT>(list, wideKey<BITS>(smallest, firstTrain + trailingZeros(where), LANES));
    if (KEPT == 1)
        return;
    where &= where - 1;
    if (!where)
    {
        keys = v_select(same, vx_load(lanes + (KEPT - 1) * LANES), keys);
        smallest = v_reduce_min(keys);
        where = signBits(v_eq(keys, vx_setall_u16(ushort(smallest))));
    }
    keepKey<KEPT>(list, wideKey<BITS>(smallest, firstTrain + trailingZeros(where), LANES));
}

template <int WORDS, int KEPT, bool BOTH, bool MASKED>
void nearest(const HammingTile& tile, DistanceKey* queryLists, DistanceKey* trainLists)
{
    const int LANES = AQORB_LANES(v_uint16), BITS = IndexBits<WORDS>::VALUE,
              packedWords = tile.words * WORD_HALVES;
    const int lists = tile.queryCount * KEPT;
    for (int i = 0; i < lists; i++)
        v_store(tile.space + i * LANES, vx_setall_u16(NO_KEY16));
    for (int b = (tile.trainCount - 1) / LANES; b >= 0; b--)
    {
        const uint64* block = tile.trains + size_t(b) * packedWords * LANES;
        CV_DECL_ALIGNED(64) uint64 copy[WORDS * MAX_LANES + 1];
        if (WORDS && WORD_HALVES == 1)  // compilers keep this copy in registers
            block = static_cast<uint64*>(std::memcpy(copy, block, WORDS * LANES * sizeof(uint64)));
        const v_uint16 blockNumber = vx_setall_u16(ushort(b));
        v_uint16 nextQuery = vx_setzero_u16(), best[2] = {vx_setall_u16(NO_KEY16), vx_setall_u16(NO_KEY16)};
        ushort* lanes = tile.space;
        for (int i = 0; i < tile.queryCount; i++, lanes += KEPT * LANES)
        {
            const v_uint16 queryNumber = nextQuery;
            if (BOTH)
                nextQuery = v_add_wrap(nextQuery, vx_setall_u16(1));
            const uchar* const allowed = MASKED ? tile.allowed + i * tile.allowedStride + b * LANES : 0;
            const v_uint16 excluded = MASKED ? excludedLanes(allowed) : vx_setzero_u16();
            if (MASKED && v_check_all(excluded))
                continue;
            v_uint16 distances =
                v_shl<BITS>(blockDistances<WORDS>(tile.queries + size_t(i) * packedWords, block, tile.words));
            if (MASKED)
                distances = v_or(distances, excluded);
            v_uint16 smallest[2] = {vx_load(lanes), vx_load(lanes + (KEPT - 1) * LANES)};
            insertKeys<KEPT>(smallest, v_or(distances, blockNumber));
            for (int k = 0; k < KEPT; k++)
                v_store(lanes + k * LANES, smallest[k]);
            if (BOTH)
                insertKeys<KEPT>(best, v_or(distances, queryNumber));
        }
        // The loop begins with the last block. Its padding has no keys.
        const int left = tile.trainCount - b * LANES, filled = left < LANES ? left : LANES;
        ushort fill[MAX_LANES];
        for (int i = 0; i < LANES; i++)
            fill[i] = i < filled ? 0 : NO_KEY16;
        for (int i = filled < LANES ? 0 : lists; i < lists; i++)
            v_store(tile.space + i * LANES, v_or(vx_load(tile.space + i * LANES), vx_load(fill)));
        if (BOTH)
        {
            ushort keys[2][MAX_LANES];
            for (int k = 0; k < KEPT; k++)
                v_store(keys[k], best[k]);
            DistanceKey* list = trainLists + size_t(b) * LANES * KEPT;
            for (int i = 0; i < filled; i++, list += KEPT)
                for (int k = 0; k < KEPT; k++)
                    keepKey<KEPT>(list, wideKey<BITS>(keys[k][i], tile.firstQuery, 1));
        }
    }
    for (int i = 0; i < tile.queryCount; i++)
        mergeLanes<KEPT, BITS>(tile.space + i * KEPT * LANES, tile.firstTrain, queryLists + i * KEPT);
}

template <int WORDS> void distances(const HammingTile& tile, ushort* out, size_t stride)
{
    const int LANES = AQORB_LANES(v_uint16), packedWords = tile.words * WORD_HALVES;
    for (int first = 0; first < tile.trainCount; first += LANES)
    {
        const uint64* const block = tile.trains + size_t(first) * packedWords;
        for (int i = 0; i < tile.queryCount; i++)
        {
            v_uint16 excluded = vx_setzero_u16();
            if (tile.allowed)
                excluded = v_shr<1>(excludedLanes(tile.allowed + i * tile.allowedStride + first));
            v_store(out + i * stride + first,
                    v_or(blockDistances<WORDS>(tile.queries + size_t(i) * packedWords, block, tile.words),
                         excluded));
        }
    }
}

//! Number of distances below a limit.
int countBelow(const ushort* distances, int count, int limit)
{
    const v_int16 bound = vx_setall_s16(short(limit));
    v_int16 below = vx_setzero_s16();
    for (int i = 0; i < count; i += AQORB_LANES(v_int16))
        below = v_sub(below, v_gt(bound, v_reinterpret_as_s16(vx_load(distances + i))));
    return int(v_reduce_sum(below));
}

int leastDistances(const ushort* distances, int count, int limit, int kept, int* found)
{
    // Bisects for a lower limit that leaves at least `kept` distances, and hardly more.
    for (int least = 0, below = countBelow(distances, count, limit); below / 2 > kept && limit - least > 1;)
    {
        const int middle = (least + limit) / 2, belowMiddle = countBelow(distances, count, middle);
        if (belowMiddle < kept)
        {
            least = middle;
        }
        else
        {
            limit = middle;
            below = belowMiddle;
        }
    }
    int* next = found;
    const v_int16 bound = vx_setall_s16(short(limit));
    for (int first = 0; first < count; first += AQORB_LANES(v_int16))
    {
        uint64 lanes = greaterLanes(bound, v_reinterpret_as_s16(vx_load(distances + first)));
        for (; lanes; lanes &= lanes - 1)
            *next++ = first + trailingZeros(lanes);
    }
    return int(next - found);
}

template <int WORDS> const HammingKernels* table()
{
    static const HammingKernels kernels = {
        AQORB_LANES(v_uint16),
        laneOf,
        WORD_HALVES,
        IndexBits<WORDS>::VALUE,
        {{{nearest<WORDS, 1, false, false>, nearest<WORDS, 1, false, true>},
          {nearest<WORDS, 1, true, false>, nearest<WORDS, 1, true, true>}},
         {{nearest<WORDS, 2, false, false>, nearest<WORDS, 2, false, true>},
          {nearest<WORDS, 2, true, false>, nearest<WORDS, 2, true, true>}}},
        distances<WORDS>,
        leastDistances};
    return &kernels;
}

}  // namespace

const HammingKernels* kernelsFor(int words)
{
    return words == 4 ? table<4>() : table<0>();
}

#else

const HammingKernels* kernelsFor(int)
{
    return 0;
}

#endif

#endif  // CV_CPU_OPTIMIZATION_DECLARATIONS_ONLY

CV_CPU_OPTIMIZATION_NAMESPACE_END
}  // namespace aqorb
}  // namespace cv
