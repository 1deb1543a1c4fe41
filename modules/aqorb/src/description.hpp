// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// The positions, directions and descriptors of selected corners.

#ifndef OPENCV_AQORB_DESCRIPTION_HPP
#define OPENCV_AQORB_DESCRIPTION_HPP

#include "blur.hpp"
#include "descriptor.hpp"
#include "measures.hpp"
#include "parameters.hpp"

namespace cv
{
namespace aqorb
{

//! Maps pixels of a level to positions in the input image.
struct PositionMap
{
    Size imageSize, levelSize;
    float scale;
    int border;     //!< positions stay this far inside the image where the pixel allows it
    bool subPixel;  //!< false: pixel times scale, as in cv::ORB

    //! The position of the point that lies (dx, dy), each within +-0.5, off the centre of pixel (x, y).
    Point2f operator()(int x, int y, double dx = 0, double dy = 0) const;
    //! With subPixel: the position nearest to p at which a keypoint belongs to pixel (x, y).
    Point2f nearest(int x, int y, const Point2d& p) const;
};

//! Whether a position rounds to a pixel that is not 0 in the mask of the input image.
bool isUsable(const Mat& imageMask, const Point2f& position);

/** Finds a usable position for pixel (x, y) of a level: that of its centre if it is usable, else, with subPixel, the
 nearest centre of a usable pixel of the input image at which a keypoint still belongs to the pixel of the level.
 @return false, and `found` unchanged, where there is none */
bool usablePosition(const Mat& imageMask, const PositionMap& position, int x, int y, Point2f& found);

//! Clears the pixels of a level's mask that have no usable position in the input image.
void maskPositions(const Mat& imageMask, const PositionMap& position, Mat& levelMask);

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
