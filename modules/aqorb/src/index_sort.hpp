// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#ifndef OPENCV_AQORB_INDEX_SORT_HPP
#define OPENCV_AQORB_INDEX_SORT_HPP

#include <opencv2/core.hpp>

#include <vector>

namespace cv
{
namespace aqorb
{

//! Work space of sortIndices.
struct SortScratch
{
    std::vector<uint64> items, moved;
};

/** Sorts the indices of numbers by the numbers, and equal ones by themselves. It counts digits, because most comparisons
 would be hard to predict.
 @param least, greatest the range of all numbers but a few */
void sortIndices(const std::vector<uint64>& numbers, uint64 least, uint64 greatest, SortScratch& scratch,
                 std::vector<unsigned>& indices);
//! The same with the range of all numbers.
void sortIndices(const std::vector<uint64>& numbers, SortScratch& scratch, std::vector<unsigned>& indices);

}  // namespace aqorb
}  // namespace cv

#endif
