// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#ifndef OPENCV_AQORB_MATCH_FILTER_HPP
#define OPENCV_AQORB_MATCH_FILTER_HPP

#include "hamming.hpp"

namespace cv
{
namespace aqorb
{

//! The tests that a match must pass, as documented at matchArrays.
struct MatchFilter
{
    //! Throws if a value is invalid.
    MatchFilter(double ratio, bool crossCheck, int maxDistance);

    //! How many nearest descriptors the tests need.
    int kept() const { return ratio > 0 ? 2 : 1; }

    double ratio;
    bool crossCheck;
    int maxDistance;
};

/** Writes the matches that pass the tests.
 @param nearest lists of filter.kept() keys for each query
 @param nearestQueries the same for each train; used for crossCheck only */
void writeMatches(const std::vector<DistanceKey>& nearest, const std::vector<DistanceKey>& nearestQueries,
                  const MatchFilter& filter, OutputArray pairs, OutputArray distances);

}  // namespace aqorb
}  // namespace cv

#endif
