// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#ifndef OPENCV_AQORB_TEST_REFERENCE_MATCHING_HPP
#define OPENCV_AQORB_TEST_REFERENCE_MATCHING_HPP

#include "test_precomp.hpp"

#include <functional>

// Plain matchers, written for clarity and without regard to speed.

namespace opencv_test
{

typedef std::vector<std::vector<DMatch>> MatchLists;

int referenceDistance(const Mat& a, int row, const Mat& b, int otherRow, int normType);

//! All matches of a query that are allowed, the nearest first, then by image and by index.
std::vector<DMatch> referenceMatches(const Mat& query, int row, const std::vector<Mat>& images,
                                     const std::vector<Mat>& masks, int normType);

//! Whether a query may be matched with a train descriptor.
typedef std::function<bool(int, int)> Allowed;

//! What matchArrays documents.
struct ReferenceTests
{
    double ratio;
    bool crossCheck;
    int maxDistance, normType;
};
std::vector<DMatch> referenceTested(const Mat& query, const Mat& train, const ReferenceTests& tests,
                                    const Allowed& isAllowed);

/** Random descriptors. Some are copies of others, and of some only a few bits differ, so that many distances are equal.
 They may be a part of a larger matrix. */
Mat randomDescriptors(RNG& rng, int rows, int bytes);

::testing::AssertionResult sameMatches(const MatchLists& a, const MatchLists& b);

}  // namespace opencv_test

#endif
