// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// Patches of an image, reflected at the border.

#ifndef OPENCV_AQORB_PATCH_HPP
#define OPENCV_AQORB_PATCH_HPP

#include <opencv2/core.hpp>

namespace cv
{
namespace aqorb
{

//! Copies a rectangle row by row without gaps, and reflects the image at its border.
void copyReflected(const Mat& image, const Rect& rect, uchar* out);

//! Pixels around a pixel of a level, readable within a radius.
struct Patch
{
    const uchar* center;
    ptrdiff_t step;
};

typedef AutoBuffer<uchar, 2048> PatchBuffer;

//! Square patch of the given radius around (x, y): in place inside the image, else copied to the buffer, with
//! reflection at the border.
Patch patchAround(const Mat& image, int x, int y, int radius, PatchBuffer& buffer);

}  // namespace aqorb
}  // namespace cv

#endif
