// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// The positions, directions and descriptors of selected corners.

#ifndef OPENCV_AQORB_KEYPOINTS_HPP
#define OPENCV_AQORB_KEYPOINTS_HPP

#include "blur.hpp"
#include "descriptor.hpp"
#include "harris_orientation.hpp"
#include "position.hpp"

namespace cv
{
namespace aqorb
{

//! Where the quadratic through the 3x3 FAST scores around (x, y) peaks, relative to (x, y), within +-0.5.
Point2d subPixelOffset(const Mat& image, int x, int y);

//! Features of a level that are described together.
struct FeatureRange
{
    int level;
    Range features;
};
//! Divides features into ranges: large enough to be worth a thread's time, small enough that no thread waits long.
std::vector<FeatureRange> divideIntoRanges(const std::vector<FeatureList>& features, int threads);

//! The data by which features are described.
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
 positions in the image and their descriptors. For the descriptors, rows of the level are blurred from top to bottom,
 some at a time. */
void describeFeatures(const Level& level, const DescriptionRules& rules, const Range& features,
                      FeatureList& list, DescriptionScratch& scratch);

}  // namespace aqorb
}  // namespace cv

#endif
