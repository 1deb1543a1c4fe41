// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#ifndef OPENCV_AQORB_HAMMING_HPP
#define OPENCV_AQORB_HAMMING_HPP

// The kernels that compute the Hamming distances of all queries to all trains of a tile, which are packed for them.
//
// A kernel chooses the number of planes into which it packs a 64-bit word. A block holds as many trains as a vector of
// 16-bit distances has lanes.

#include "types.hpp"

namespace cv
{
namespace aqorb
{

// The functions are static, because a file compiled for one CPU that includes them must keep its own: see types.hpp.

//! A distance and the index at which it is found, as one number. The smaller number is that of the nearer descriptor,
//! or of the lower index where two descriptors are equally near.
typedef uint64 DistanceKey;
const DistanceKey NO_KEY = ~DistanceKey(0);

static inline DistanceKey distanceKey(int distance, int index)
{
    return DistanceKey(unsigned(distance)) << 32 | unsigned(index);
}
static inline int distanceOf(DistanceKey key)
{
    return int(key >> 32);
}
static inline int indexOf(DistanceKey key)
{
    return int(unsigned(key));
}

//! Puts a key into a list of the count smallest ones, in ascending order.
static inline void insertKey(DistanceKey* smallest, int count, DistanceKey key)
{
    if (key >= smallest[count - 1])
        return;
    int i = count - 1;
    for (; i > 0 && smallest[i - 1] > key; i--)
        smallest[i] = smallest[i - 1];
    smallest[i] = key;
}

//! The same for lists of one or two, without a branch, which the CPU would often predict wrongly.
template <int KEPT> static inline void keepKey(DistanceKey* smallest, DistanceKey key)
{
    const DistanceKey first = smallest[0], larger = first < key ? key : first;
    smallest[0] = first < key ? first : key;
    if (KEPT == 2)
        smallest[KEPT - 1] = smallest[KEPT - 1] < larger ? smallest[KEPT - 1] : larger;
}

//! Of two words. PAIRS: pairs of bits count.
template <bool PAIRS> static inline int wordDistance(uint64 a, uint64 b)
{
    const uint64 bits = a ^ b;
    return bitCount(PAIRS ? (bits | bits >> 1) & 0x5555555555555555u : bits);
}

//! The nearest one or two descriptors are kept for each query and, if asked for, for each train.
const int MAX_KEPT = 2;

// ---- for the kernel: plain structs only, see types.hpp ---------------------------------------

//! Queries and trains that are compared in one go.
struct HammingTile
{
    const uint64 *queries, *trains;  //!< packed
    int queryCount, trainCount;
    int firstQuery, firstTrain;  //!< the indices of the first ones
    int words;                   //!< 64-bit words of a descriptor
    int indexBits;    //!< for nearest: a tile has at most 2^indexBits queries, and blocks of trains
    ushort* scratch;  //!< for nearest: MAX_KEPT * queryCount * block elements
};

//! The kernels of a CPU for a norm and a width of descriptors.
struct HammingKernels
{
    int block;                     //!< trains of a block
    int queryPlanes, trainPlanes;  //!< packed words for each word of a query and of a train

    //! Packs descriptors, row by row.
    void (*packQueries)(const uchar* rows, size_t step, int count, int bytes, uint64* packed);
    //! Packs at most a block of descriptors. Missing ones become zeros.
    void (*packTrains)(const uchar* rows, size_t step, int count, int bytes, uint64* packed);

    /** Puts the descriptors of a tile into lists of the nearest ones. nearest[KEPT - 1][BOTH] is the kernel for lists
     of KEPT descriptors. With BOTH it fills the lists of the trains, too.
     @param ofQueries, ofTrains lists in ascending order of the queries and of the trains of the tile, one after the
     other */
    void (*nearest[MAX_KEPT][2])(const HammingTile& tile, DistanceKey* ofQueries, DistanceKey* ofTrains);

    //! Computes distances: a row for each query, stride elements after the row before. A row has an element for each
    //! train, and for those that fill the last block.
    void (*distances)(const HammingTile& tile, int* distances, size_t stride);
};

//! The largest number of bits of a descriptor for which nearest can be used.
const int MAX_KEY_BITS = 1023;
//! The longest descriptors that the kernels take: a sum of 16 bits counts their bits, and a tile stays in the cache.
const int MAX_PACKED_BYTES = 1024;

//! The best kernels that this CPU has for descriptors.
//! @param countPairs whether pairs of bits count, as for NORM_HAMMING2
const HammingKernels& hammingKernels(bool countPairs, int bytes);
//! Those that every CPU has, without a vector.
const HammingKernels& plainHammingKernels(bool countPairs);

}  // namespace aqorb
}  // namespace cv

#endif
