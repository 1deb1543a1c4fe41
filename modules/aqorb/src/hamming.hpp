// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#ifndef OPENCV_AQORB_HAMMING_HPP
#define OPENCV_AQORB_HAMMING_HPP

// The steps that all matchers share: descriptors are checked, and the nearest ones are searched by kernels for this
// CPU.

#include "types.hpp"

#include <functional>

namespace cv
{
namespace aqorb
{

//! Throws unless the norm is one of the two Hamming norms.
void checkHammingNorm(int normType);

/** Checks descriptors and returns them. All matchers call it, so that they agree on when there are none: a matrix
 without rows or columns is returned as an empty one.
 @param width the number of columns that they must have; any for 0
 @param image the image that errors name with them; none for -1 */
Mat descriptorsOf(const char* name, InputArray descriptors, int width = 0, int image = -1);

//! Reports that memory ran out as OpenCV does. To be called where std::bad_alloc is caught.
void throwNoMemory(InputArray queryDescriptors);

/** Takes the distances of a query to `count` trains, from the index firstTrain on. Several threads call it at once, but
 only one at a time for the same query, in the order of the trains. */
typedef std::function<void(int query, int firstTrain, const int* distances, int count)> DistanceSink;

/** Computes the Hamming distances of all queries to all trains, in parallel.
 @param query, train CV_8UC1 matrices of the same width, a descriptor in each row
 @param countPairs whether pairs of bits count, as for NORM_HAMMING2 */
void allDistances(const Mat& query, const Mat& train, bool countPairs, const DistanceSink& sink);

// The functions below are static, because a file compiled for one CPU that includes them must keep its own: see
// types.hpp.

//! A distance and its index as one number. The nearer descriptor has the smaller number; ties go to the lower index.
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

/** Finds the nearest descriptors. Lists of one or two have kernels of their own.
 @param mask empty, or CV_8UC1 with a row for each query; pairs for which it is 0 are left out
 @param firstTrain the index that the first train is to have, above those in the lists
 @param kept the length of each list
 @param queryLists lists in ascending order, of one query after the other, with NO_KEY for no descriptor. The trains are
 added to these lists.
 @param trainLists lists of the nearest queries of each train, likewise; or null */
void nearestDescriptors(const Mat& query, const Mat& train, const Mat& mask, bool countPairs, int firstTrain,
                        int kept, DistanceKey* queryLists, DistanceKey* trainLists);

// ---- for the kernels: plain structs only, see types.hpp ---------------------------------------

//! Queries and trains that are compared in one go.
struct HammingTile
{
    const uint64 *queries, *trains;  //!< packed
    int queryCount, trainCount;
    int firstQuery, firstTrain;  //!< the indices of the first ones
    int words;                   //!< 64-bit words of a descriptor
    ushort* scratch;             //!< for nearest: 2 * queryCount * block elements
    //! A row for each query, allowedStride bytes after the row before: 0 for a train that is left out, and for the
    //! padding of the last block. Null: none is left out.
    const uchar* allowed;
    size_t allowedStride;
};

//! The kernels of a CPU for a width of descriptors.
struct HammingKernels
{
    //! Trains lie in blocks: a word of all of them, then the next word. Within a block each has a lane.
    int block;
    int (*laneOf)(int train);
    int planes;     //!< packed words for each word: itself, or the low and the high halves of its bytes
    int indexBits;  //!< for nearest: a tile has at most 2^indexBits queries, and blocks of trains

    /** Puts the descriptors of a tile into lists of the nearest ones. nearest[KEPT - 1][BOTH][MASKED] is the kernel for
     lists of KEPT descriptors. With BOTH it fills the lists of the trains, too. MASKED: tile.allowed is not null.
     @param queryLists, trainLists lists in ascending order of the queries and of the trains of the tile, one after the
     other */
    void (*nearest[2][2][2])(const HammingTile& tile, DistanceKey* queryLists, DistanceKey* trainLists);

    //! Computes distances: a row for each query, stride elements after the row before. A row has an element for each
    //! train and for the padding of the last block. It is 0x7fff for a train that is left out.
    void (*distances)(const HammingTile& tile, ushort* distances, size_t stride);

    /** Finds the distances of a row below a limit, or only the least of them, but no fewer than kept. Returns their
     number.
     @param count a multiple of block, at most 2^15
     @param found their indices in ascending order */
    int (*leastDistances)(const ushort* distances, int count, int limit, int kept, int* found);
};

//! The best kernels of this CPU for descriptors of this many words; null if it has no vectors.
const HammingKernels* hammingKernels(int words);

}  // namespace aqorb
}  // namespace cv

#endif
