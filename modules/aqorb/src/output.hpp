// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#ifndef OPENCV_AQORB_OUTPUT_HPP
#define OPENCV_AQORB_OUTPUT_HPP

#include "description.hpp"
#include "index_sort.hpp"

namespace cv
{
namespace aqorb
{
namespace stages
{

//! Work space of outputFeatures.
struct OutputScratch
{
    std::vector<unsigned> rasterOrder, sorted;
    std::vector<uint64> keys;
    SortScratch sorting;
};

/** Gives the features of a level, by their output keys and, where these are equal, in raster order.
 @param keypoints space for all features of the level
 @param descriptors rows for all of them, from `row` on; empty: they are not wanted */
void outputFeatures(const LevelFeatures& features, OutputScratch& scratch, KeyPoint* keypoints, int row,
                    Mat& descriptors);

}  // namespace stages
}  // namespace aqorb
}  // namespace cv

#endif
