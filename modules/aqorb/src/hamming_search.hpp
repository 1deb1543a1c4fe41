// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#ifndef OPENCV_AQORB_HAMMING_SEARCH_HPP
#define OPENCV_AQORB_HAMMING_SEARCH_HPP

#include "hamming.hpp"

#include <functional>

namespace cv
{
namespace aqorb
{

/** Takes the distances of a query to count trains, of which the first one has the index firstTrain. It is called by several
 threads at once, but for a query by one at a time, and then in the order of the trains. */
typedef std::function<void(int query, int firstTrain, const int* distances, int count)> DistanceSink;

/** Computes the Hamming distances of all queries to all trains, in parallel and in tiles that stay in the cache.
 @param query, train CV_8UC1 matrices of the same width, a descriptor in each row
 @param countPairs whether pairs of bits count, as for NORM_HAMMING2 */
void allDistances(const Mat& query, const Mat& train, bool countPairs, const DistanceSink& sink);

/** Finds the nearest descriptors. Rows of distances are only computed for long lists, for long descriptors and with a mask.
 @param mask empty, or CV_8UC1 with a row for each query; trains for which it is 0 are left out
 @param firstTrain the index that the first train is to have
 @param kept the length of each list
 @param ofQueries lists in ascending order, of one query after the other; the trains are added to what they hold, NO_KEY
 for none
 @param ofTrains lists of the nearest queries of each train, likewise; or null */
void nearestDescriptors(const Mat& query, const Mat& train, const Mat& mask, bool countPairs, int firstTrain,
                        int kept, DistanceKey* ofQueries, DistanceKey* ofTrains);

}  // namespace aqorb
}  // namespace cv

#endif
