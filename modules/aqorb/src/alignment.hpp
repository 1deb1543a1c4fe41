// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// Least squares matching: the alignment of two patches.

#ifndef OPENCV_AQORB_ALIGNMENT_HPP
#define OPENCV_AQORB_ALIGNMENT_HPP

#include "types.hpp"

namespace cv
{
namespace aqorb
{

//! A patch has 13 x 13 samples, at u and v from -6 to 6 from its centre.
const int PATCH_RADIUS = 6;
//! The variance of a patch with texture, in squared grey values.
const float MIN_PATCH_VARIANCE = 4;
//! How far alignment may move a position, in samples.
const float MAX_PATCH_SHIFT = PATCH_RADIUS;
//! By which factor alignment may change the area of a patch.
const float MAX_AREA_CHANGE = 4;
//! How far from the start of the alignment a sample may lie, in pixels of the pyramid level.
const int MAX_PATCH_REACH = 63;
//! The correlation of patches that cannot be aligned.
const float NOT_ALIGNED = -2;

// ---- for the kernel: plain structs only, see types.hpp ---------------------------------------

//! The longest distance of rows in memory. Offsets within a window fit into an int.
const int MAX_WINDOW_STEP = 1 << 23;

//! The pixels of a pyramid level around a position.
struct LevelWindow
{
    const uchar* origin;  //!< the pixel at (0, 0)
    int step;             //!< bytes from a row to the next one
    float x, y;           //!< the position
    float left, top, right,
        bottom;  //!< Samples lie between these. The pixels to the right and below are readable.
};

//! Two patches. Sample (u, v) of the first one lies at (x + spacing * u, y + spacing * v), and of the second one at
//! (x + map[0] * u + map[1] * v, y + map[2] * u + map[3] * v).
struct LevelPatches
{
    LevelWindow first, second;
    float spacing;
    float map[4];
};

//! The second patch after the alignment.
struct LevelAlignment
{
    float x, y;
    float map[4];
    float correlation;  //!< with the first patch; NOT_ALIGNED: the other fields have no meaning
    float variance;     //!< of the position along its worst axis, in squared pixels, before calibration
};

/** Aligns patches by three inverse compositional steps (Baker and Matthews 2004). Each step solves for the affine map,
 the gain and the bias that bring the second patch closest to the first one. */
void alignPatches(const LevelPatches* patches, int count, LevelAlignment* alignments);

}  // namespace aqorb
}  // namespace cv

#endif
