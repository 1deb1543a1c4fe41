// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// Least squares matching: the alignment of the two patches of a match.

#ifndef OPENCV_AQORB_REFINEMENT_STAGE_HPP
#define OPENCV_AQORB_REFINEMENT_STAGE_HPP

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
//! The correlation of patches that cannot be aligned.
const float NOT_ALIGNED = -2;

//! A position on a level of an image.
struct PatchPlace
{
    const uchar* origin;  //!< the pixel at (0, 0); it has neighbours to the right and below
    int step;             //!< from a row to the next one; at most MAX_PATCH_STEP
    float x, y;
    float right, bottom;  //!< samples are taken from (0, 0) to here; less than PATCH_AREA
};
const int PATCH_AREA = 512, MAX_PATCH_STEP = 1 << 21;  // so that offsets fit into an int

//! The patches of a match. Sample (u, v) of the first one lies at (x + spacing * u, y + spacing * v), and of the second
//! one at (x + map[0] * u + map[1] * v, y + map[2] * u + map[3] * v).
struct PatchPair
{
    PatchPlace first, second;
    float spacing;
    float map[4];
};

//! The place in the second image that shows the centre of the first patch.
struct Alignment
{
    float x, y;
    float correlation;  //!< of the patches before the last step; NOT_ALIGNED: x and y have no meaning
};

/** Aligns patches by three inverse compositional steps (Baker and Matthews 2004). Each step solves for the affine map,
 the gain and the bias that bring the second patch closest to the first one. */
void alignPatches(const PatchPair* pairs, int count, Alignment* alignments);

}  // namespace aqorb
}  // namespace cv

#endif
