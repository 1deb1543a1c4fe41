// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// Where pixels of a level are in the input image.

#ifndef OPENCV_AQORB_POSITION_HPP
#define OPENCV_AQORB_POSITION_HPP

#include <opencv2/core.hpp>

namespace cv
{
namespace aqorb
{

//! The position in an image of a point of one of its levels. Sizes correspond, so pixel centres are not shifted.
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
    int border;     //!< positions stay this far inside the image where the pixel allows it
    bool subPixel;  //!< false: pixel times scale, as in cv::ORB

    //! The position of the point that lies (dx, dy), each within +-0.5, off the centre of pixel (x, y).
    Point2f operator()(int x, int y, double dx = 0, double dy = 0) const;
    //! With subPixel: the position nearest to p at which a keypoint belongs to pixel (x, y).
    Point2f nearest(int x, int y, const Point2d& p) const;
};

//! Whether a position rounds to a pixel that is not 0 in the mask of the input image.
bool isUsable(const Mat& imageMask, const Point2f& position);

/** Finds a usable position for pixel (x, y) of a level: its centre, if that is usable. Otherwise, with subPixel, it is
 the nearest centre of a usable pixel of the input image at which a keypoint still belongs to the pixel of the level.
 @return false, and `found` unchanged, where there is none */
bool usablePosition(const Mat& imageMask, const PositionMap& position, int x, int y, Point2f& found);

//! Clears the pixels of a level's mask that have no usable position in the input image.
void maskPositions(const Mat& imageMask, const PositionMap& position, Mat& levelMask);

}  // namespace aqorb
}  // namespace cv

#endif
