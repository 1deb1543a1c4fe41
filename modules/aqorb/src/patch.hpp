// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// The pixels around a pixel, reflected beyond the border.

#ifndef OPENCV_AQORB_PATCH_HPP
#define OPENCV_AQORB_PATCH_HPP

#include <opencv2/core.hpp>

namespace cv
{
namespace aqorb
{

//! Copies a rectangle, row by row without gaps. Pixels outside of the image are reflected.
void copyReflected(const Mat& image, const Rect& rect, uchar* out);

//! The pixels around a pixel of a level, readable within a radius.
struct Patch
{
    const uchar* center;
    ptrdiff_t step;
};

typedef AutoBuffer<uchar, 2048> PatchBuffer;

//! The square patch of the given radius around (x, y). Where it lies inside the image it is read in place; else it
//! is copied into the buffer and its pixels outside of the image are reflected.
Patch patchAround(const Mat& image, int x, int y, int radius, PatchBuffer& buffer);

}  // namespace aqorb
}  // namespace cv

#endif
