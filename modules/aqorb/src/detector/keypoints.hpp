// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// Positions, directions and descriptors of selected corners and of given keypoints.

#ifndef OPENCV_AQORB_KEYPOINTS_HPP
#define OPENCV_AQORB_KEYPOINTS_HPP

#include "detector/blur.hpp"
#include "detector/descriptor.hpp"
#include "detector/harris_orientation.hpp"
#include "detector/parameters.hpp"
#include "detector/position.hpp"

namespace cv
{
namespace aqorb
{

/** Given keypoints that cv::ORB::compute would describe, and their pixels: one list for each level, up to the highest
 octave. Throws if an octave is negative or has no pixels, or an angle is not finite. */
std::vector<FeatureList> groupGivenKeypoints(const std::vector<KeyPoint>& keypoints,
                                             const Parameters& parameters, Size imageSize);

//! Peak of the quadratic through the 3x3 FAST scores around (x, y), relative to (x, y), within +-0.5.
Point2d subPixelOffset(const Mat& image, int x, int y);

//! Parameters of describeFeatures.
struct DescriptionRules
{
    Mat imageMask;                       //!< mask of the input image; may be empty
    std::vector<PositionMap> positions;  //!< position map of each level
    const OrientationPatch* patch;       //!< 0: keypoints are given with their directions
    const DescriptorTests* tests;        //!< 0: no descriptors
};

//! Work space of one thread of describeFeatures.
struct DescriptionSpace
{
    BlurRegion region;
    std::vector<uchar> blur;
    AlignedVector<ushort> blurred;
};

//! Computes directions, positions in the image and descriptors of the features of all levels.
void describeFeatures(const std::vector<Level>& levels, const DescriptionRules& rules, int threads,
                      std::vector<DescriptionSpace>& spaces, std::vector<FeatureList>& features);

//! Writes the features of all levels to the output: by level, then by output key, then in raster order.
void outputFeatures(const std::vector<FeatureList>& features, std::vector<KeyPoint>& keypoints,
                    OutputArray descriptors);

}  // namespace aqorb
}  // namespace cv

#endif
