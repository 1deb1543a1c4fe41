// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// Least squares matching: the alignment of two patches.

#ifndef OPENCV_AQORB_ALIGNMENT_HPP
#define OPENCV_AQORB_ALIGNMENT_HPP

#include "common/memory.hpp"

namespace cv
{
namespace aqorb
{

//! Radius of a patch: 13 x 13 samples, at u and v from -6 to 6.
const int PATCH_RADIUS = 6;
//! The variance of a patch must be above this, in squared grey values.
const float MIN_PATCH_VARIANCE = 4;
//! Limit on the shift of a position by alignment, in samples.
const float MAX_PATCH_SHIFT = PATCH_RADIUS;
//! Limit on the change of a patch's area by alignment, as a factor.
const float MAX_AREA_CHANGE = 4;
//! Limit on the distance of samples from the start of the alignment, in pixels of the pyramid level.
const int MAX_PATCH_REACH = 63;
//! Correlation value of patches that cannot be aligned.
const float NOT_ALIGNED = -2;

// ---- for the kernel: plain structs only, see simd_compat.hpp ---------------------------------

//! Limit on the bytes from row to row. Offsets within a window then fit into an int.
const int MAX_WINDOW_STEP = 1 << 23;

//! Pixels of a pyramid level around a position.
struct LevelWindow
{
    const uchar* origin;  //!< pixel at (0, 0)
    int step;             //!< bytes from row to row
    float x, y;           //!< position
    //! Bounds of the samples; one more pixel to the right and below is readable.
    float left, top, right, bottom;
};

//! Two patches. Sample (u, v) lies at (x + spacing * u, y + spacing * v) in the first patch, and at
//! (x + map[0] * u + map[1] * v, y + map[2] * u + map[3] * v) in the second patch.
struct LevelPatches
{
    LevelWindow first, second;
    float spacing;
    float map[4];
};

//! Second patch after the alignment.
struct LevelAlignment
{
    float x, y;
    float map[4];
    float
        correlation;  //!< with the first patch before the last step; NOT_ALIGNED: other fields are undefined
    float variance;   //!< variance of the position along its worst axis, in squared pixels, uncalibrated
};

}  // namespace aqorb
}  // namespace cv

#endif
