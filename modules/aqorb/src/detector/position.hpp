// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// Positions of a level's pixels in the input image.

#ifndef OPENCV_AQORB_POSITION_HPP
#define OPENCV_AQORB_POSITION_HPP

#include <opencv2/core.hpp>

namespace cv
{
namespace aqorb
{

//! Position in the image of a point of a level. The level spans the whole image, so pixel centres do not shift.
inline Point2d scaleByCenters(double x, double y, Size levelSize, Size imageSize)
{
    return Point2d((x + 0.5) * imageSize.width / levelSize.width - 0.5,
                   (y + 0.5) * imageSize.height / levelSize.height - 0.5);
}

//! Maps pixels of a level to positions in the input image.
struct PositionMap
{
    Size imageSize, levelSize;
    float scale;
    int border;     //!< distance that positions keep from the image's border where the pixel allows it
    bool subPixel;  //!< false: pixel times scale, as in cv::ORB

    //! Position of the centre of pixel (x, y) plus (dx, dy), each within +-0.5.
    Point2f operator()(int x, int y, double dx = 0, double dy = 0) const;
    //! Position nearest to p that belongs to pixel (x, y). Requires subPixel.
    Point2f nearest(int x, int y, const Point2d& p) const;
};

//! Whether the mask of the input image is not 0 at the rounded position.
bool isUsable(const Mat& imageMask, const Point2f& position);

/** Finds a usable position for pixel (x, y) of a level: its centre if usable. Otherwise, with subPixel, the nearest
 centre of a usable pixel of the input image that still belongs to the pixel of the level.
 @return false, and `found` unchanged, if no position is usable */
bool usablePosition(const Mat& imageMask, const PositionMap& position, int x, int y, Point2f& found);

//! Clears the pixels of a level's mask that have no usable position in the input image.
void maskPositions(const Mat& imageMask, const PositionMap& position, Mat& levelMask);

}  // namespace aqorb
}  // namespace cv

#endif
