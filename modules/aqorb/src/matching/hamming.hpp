// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#ifndef OPENCV_AQORB_HAMMING_HPP
#define OPENCV_AQORB_HAMMING_HPP

// Steps that all matchers share: checks of descriptors, and the search for nearest descriptors by kernels for this CPU.

#include "common/memory.hpp"

#include <functional>

namespace cv
{
namespace aqorb
{

//! Throws unless the norm is one of the two Hamming norms.
void checkHammingNorm(int normType);

/** Checks descriptors and returns them. A matrix without rows or columns holds no descriptors: all matchers get an
 empty Mat for it.
 @param width required number of columns; 0: any
 @param image index of the image for messages; -1: none */
Mat descriptorsOf(const char* name, InputArray descriptors, int width = 0, int image = -1);

//! Throws OpenCV's exception for lack of memory. Handlers of std::bad_alloc call it.
void throwNoMemory(InputArray queryDescriptors);

/** Callback for the distances of a query to `count` trains, from index firstTrain on. Several threads call it at once,
 but only one thread for the same query, in the order of the trains. */
typedef std::function<void(int query, int firstTrain, const int* distances, int count)> DistanceSink;

/** Computes the Hamming distances of all queries to all trains, in parallel.
 @param query, train CV_8UC1 matrices of the same width, one descriptor per row
 @param countPairs counts pairs of bits, as for NORM_HAMMING2 */
void allDistances(const Mat& query, const Mat& train, bool countPairs, const DistanceSink& sink);

// The functions below are static: a file compiled for one CPU must keep its own, see simd_compat.hpp.

//! Distance and index in one number. The nearer descriptor has the smaller key; ties go to the lower index.
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

//! Inserts a key into an ascending list of the `count` smallest keys.
static inline void insertKey(DistanceKey* smallest, int count, DistanceKey key)
{
    if (key >= smallest[count - 1])
        return;
    int i = count - 1;
    for (; i > 0 && smallest[i - 1] > key; i--)
        smallest[i] = smallest[i - 1];
    smallest[i] = key;
}

//! insertKey for lists of one or two keys, without a branch that the CPU would mispredict.
template <int KEPT> static inline void keepKey(DistanceKey* smallest, DistanceKey key)
{
    const DistanceKey first = smallest[0], larger = first < key ? key : first;
    smallest[0] = first < key ? first : key;
    if (KEPT == 2)
        smallest[KEPT - 1] = smallest[KEPT - 1] < larger ? smallest[KEPT - 1] : larger;
}

/** Finds the nearest descriptors. Lists of one or two keys have kernels of their own.
 @param mask empty, or CV_8UC1 with a row for each query; 0 excludes a pair
 @param firstTrain index of the first train, above all indices already in the lists
 @param kept length of each list
 @param queryLists ascending lists, one query after the other, padded with NO_KEY; receive the trains
 @param trainLists the same for the nearest queries of each train; or null */
void nearestDescriptors(const Mat& query, const Mat& train, const Mat& mask, bool countPairs, int firstTrain,
                        int kept, DistanceKey* queryLists, DistanceKey* trainLists);

// ---- for the kernels: plain structs only, see simd_compat.hpp ---------------------------------

//! Tile of queries and trains that stay in the cache.
struct HammingTile
{
    const uint64 *queries, *trains;  //!< packed
    int queryCount, trainCount;
    int firstQuery, firstTrain;  //!< indices of the first query and the first train
    int words;                   //!< 64-bit words of a descriptor
    ushort* space;               //!< for nearest: KEPT * queryCount * block elements
    //! Row of flags for each query, allowedStride bytes apart: 0 excludes a train, and marks the padding of the last
    //! block. Null: all are allowed.
    const uchar* allowed;
    size_t allowedStride;
};

//! Kernels of a CPU for a width of descriptors.
struct HammingKernels
{
    //! Trains per block. A block holds the first word of all its trains, then the next word. Each train has a lane.
    int block;
    int (*laneOf)(int train);
    int halves;  //!< packed words per word: 1, the word itself; or 2, the low and the high halves of its bytes
    int indexBits;  //!< for nearest: a tile has at most 2^indexBits queries and 2^indexBits blocks of trains

    /** Inserts the descriptors of a tile into lists of nearest descriptors. nearest[KEPT - 1][BOTH][MASKED] is the
     kernel for lists of KEPT keys. With BOTH it also fills the lists of the trains. MASKED: tile.allowed is not null.
     @param queryLists, trainLists ascending lists of the tile's queries and trains, one after the other */
    void (*nearest[2][2][2])(const HammingTile& tile, DistanceKey* queryLists, DistanceKey* trainLists);

    //! Computes one row of distances for each query, stride elements apart, with an element for each train and for the
    //! padding of the last block. Excluded trains get 0x7fff.
    void (*distances)(const HammingTile& tile, ushort* distances, size_t stride);

    /** Finds the distances of a row below a limit. If there are many, it finds only the least, at least `kept` of them.
     @param count a multiple of block, at most 2^15
     @param found receives their indices in ascending order
     @return number of indices */
    int (*leastDistances)(const ushort* distances, int count, int limit, int kept, int* found);
};

//! Best kernels of this CPU for descriptors of `words` words; null without vectors.
const HammingKernels* hammingKernels(int words);

}  // namespace aqorb
}  // namespace cv

#endif
