// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// Tests of matches, and the arrays that matches are written to.

#ifndef OPENCV_AQORB_MATCH_FILTER_HPP
#define OPENCV_AQORB_MATCH_FILTER_HPP

#include "matching/hamming.hpp"

namespace cv
{
namespace aqorb
{

typedef std::vector<DistanceKey> Keys;

//! Tests of a match, as documented at matchArrays.
struct MatchFilter
{
    //! Throws unless the ratio is finite and at least 0, and maxDistance at least -1.
    MatchFilter(double ratio, bool crossCheck, int maxDistance);

    //! Number of nearest descriptors that the tests need.
    int kept() const { return ratio > 0 ? 2 : 1; }

    //! Tests the nearest train of a query.
    //! @param trainLists lists of all trains
    bool passes(int query, const DistanceKey* queryList, const Keys& trainLists) const;

    const double ratio;
    const bool crossCheck;
    const int maxDistance;
};

//! Throws unless there is one element for each row of the descriptors.
void checkCount(const char* name, size_t count, const char* descriptors, int rows);

//! Writes two matrices with the same number of rows. If either output does not fit, both stay unchanged.
void writeBoth(const Mat& first, const char* firstName, OutputArray firstOutput, const Mat& distances,
               OutputArray distancesOutput);

//! Writes the matches that pass the tests.
//! @param queryLists, trainLists lists of filter.kept() keys; trainLists serve crossCheck only
//! @param name of the output `pairs` for messages
void writeMatches(const Keys& queryLists, const Keys& trainLists, const MatchFilter& filter, const char* name,
                  OutputArray pairs, OutputArray distances);

}  // namespace aqorb
}  // namespace cv

#endif
