// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// Sorts indices by keys.

#ifndef OPENCV_AQORB_INDEX_SORT_HPP
#define OPENCV_AQORB_INDEX_SORT_HPP

#include <opencv2/core.hpp>

#include <climits>
#include <vector>

namespace cv
{
namespace aqorb
{

//! Integer that sorts like the value, never INT_MIN. NaN comes first.
inline int sortKey(float value)
{
    Cv32suf bits;
    bits.f = value + 0.f;  // makes -0 equal to 0
    return value == value ? bits.i ^ ((bits.i >> 31) & INT_MAX) : INT_MIN + 1;
}
//! Reverses the order of keys: the greatest key comes first.
inline unsigned descendingKey(int key)
{
    return unsigned(key) ^ 0x7fffffffu;
}

//! Indices of the keys in ascending order of the keys. Ties keep the order of indices. A radix sort, because the CPU
//! would mispredict most comparisons.
std::vector<unsigned> sortIndices(const std::vector<uint64>& keys);

}  // namespace aqorb
}  // namespace cv

#endif
