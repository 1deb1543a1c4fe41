// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// The pixels around a pixel, reflected at the border of the image.

#ifndef OPENCV_AQORB_NEIGHBORHOOD_HPP
#define OPENCV_AQORB_NEIGHBORHOOD_HPP

#include <opencv2/core.hpp>

namespace cv
{
namespace aqorb
{

//! Copies a rectangle row by row without gaps, and reflects the image at its border.
void copyReflected(const Mat& image, const Rect& rect, uchar* out);

//! Pixels around a pixel of a level, readable within a radius.
struct Neighborhood
{
    const uchar* center;
    ptrdiff_t step;
};

typedef AutoBuffer<uchar, 2048> NeighborhoodSpace;

//! Square of the given radius around (x, y): in place inside the image, else copied to the work space, with
//! reflection at the border.
Neighborhood neighborhoodOf(const Mat& image, int x, int y, int radius, NeighborhoodSpace& space);

}  // namespace aqorb
}  // namespace cv

#endif
