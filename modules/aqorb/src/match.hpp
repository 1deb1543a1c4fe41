// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// The steps that the matchers share: their arguments are checked here, and the nearest descriptors are searched.

#ifndef OPENCV_AQORB_MATCH_HPP
#define OPENCV_AQORB_MATCH_HPP

#include "hamming.hpp"

#include <functional>

namespace cv
{
namespace aqorb
{

//! Throws unless the norm is one of the two Hamming norms.
void checkHammingNorm(int normType);

/** Checks descriptors and returns them. All matchers call it, so that they agree on when there are none: a matrix
 without rows or columns is returned as an empty one.
 @param width the number of columns that they must have; any for 0 */
Mat descriptorsOf(const char* name, InputArray descriptors, int width = 0);

//! Reports that memory ran out as OpenCV does. To be called where std::bad_alloc is caught.
void throwNoMemory(InputArray queryDescriptors);

/** Takes the distances of a query to count trains, the first of which has the index firstTrain. Several threads call it
 at once. For one query it is called by one thread at a time, in the order of the trains. */
typedef std::function<void(int query, int firstTrain, const int* distances, int count)> DistanceSink;

/** Computes the Hamming distances of all queries to all trains, in parallel.
 @param query, train CV_8UC1 matrices of the same width, a descriptor in each row
 @param countPairs whether pairs of bits count, as for NORM_HAMMING2 */
void allDistances(const Mat& query, const Mat& train, bool countPairs, const DistanceSink& sink);

/** Finds the nearest descriptors. Lists of one or two without a mask have kernels of their own.
 @param mask empty, or CV_8UC1 with a row for each query; trains for which it is 0 are left out
 @param firstTrain the index that the first train is to have
 @param kept the length of each list
 @param ofQueries lists in ascending order, of one query after the other, with NO_KEY for no descriptor. The trains are
 added to these lists.
 @param ofTrains lists of the nearest queries of each train, likewise; or null */
void nearestDescriptors(const Mat& query, const Mat& train, const Mat& mask, bool countPairs, int firstTrain,
                        int kept, DistanceKey* ofQueries, DistanceKey* ofTrains);

}  // namespace aqorb
}  // namespace cv

#endif
