// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#ifndef OPENCV_AQORB_DESCRIPTION_HPP
#define OPENCV_AQORB_DESCRIPTION_HPP

#include "aligned.hpp"
#include "blur.hpp"
#include "descriptor.hpp"
#include "measures.hpp"
#include "position.hpp"
#include "types.hpp"

namespace cv
{
namespace aqorb
{

//! Features of a level.
struct FeatureList
{
    std::vector<FeaturePoint> points;  //!< in raster order
    std::vector<KeyPoint> keypoints;   //!< of the points
    std::vector<uchar> descriptors;    //!< of the points, DESCRIPTOR_BYTES each; empty if they are not wanted
    std::vector<uint64> outputKeys;    //!< of the points: by them they come in the output
};

//! Features of a level that are described together.
struct FeatureRange
{
    int level;
    Range features;
};
//! Divides features into ranges that are worth a thread's time, and so many that no thread waits long for another.
std::vector<FeatureRange> divideIntoRanges(const std::vector<FeatureList>& features, int threads);

//! What features are described by.
struct DescriptionRules
{
    const Mat* imageMask;           //!< of the input image; may be empty
    PositionMap position;           //!< of the level
    const OrientationPatch* patch;  //!< 0: the keypoints are given, with their directions
    const DescriptorTests* tests;   //!< 0: no descriptors are wanted
};

//! Work space of describeFeatures.
struct DescriptionScratch
{
    BlurRegion region;
    std::vector<uchar> blur;
    AlignedVector<ushort> blurred;
};

/** Describes some of the features of a list, so that several threads can share it: finds their directions, their
 positions in the image and their descriptors. The rows of the level are read and blurred from top to bottom, some at a
 time. */
void describeFeatures(const Level& level, const DescriptionRules& rules, const Range& features,
                      FeatureList& list, DescriptionScratch& scratch);

}  // namespace aqorb
}  // namespace cv

#endif
