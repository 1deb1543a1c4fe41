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

//! A whole number that sorts as the value does. NaN comes before all others, and none is INT_MIN.
inline int sortKey(float value)
{
    Cv32suf bits;
    bits.f = value + 0.f;  // makes -0 equal to 0
    return value == value ? bits.i ^ ((bits.i >> 31) & INT_MAX) : INT_MIN + 1;
}
//! A number that is the smaller the greater the key is, so that the greatest key comes first.
inline unsigned descendingKey(int key)
{
    return unsigned(key) ^ 0x7fffffffu;
}

//! The indices of keys in ascending order of the keys. Ties go to the lower index. It counts digits, because the CPU
//! could predict few comparisons.
std::vector<unsigned> sortIndices(const std::vector<uint64>& keys);

}  // namespace aqorb
}  // namespace cv

#endif
