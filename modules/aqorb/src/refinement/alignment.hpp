// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// Alignment of pairs of patches by least squares matching.

#ifndef OPENCV_AQORB_ALIGNMENT_HPP
#define OPENCV_AQORB_ALIGNMENT_HPP

#include "common/memory.hpp"

#include <opencv2/core.hpp>

#include <vector>

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

//! Centre of a patch and distance of its samples, in pixels of the image. Alignment needs a spacing > 0.
struct PatchLocation
{
    Point2f center;
    double spacing;
};

//! Two patches to align. Sample (u, v) of the second patch lies at second.center + map * (u, v).
struct PatchPair
{
    PatchLocation first, second;
    Matx22d map;
};

//! Second patch after the alignment, in pixels of image 2.
struct PatchAlignment
{
    Point2f center;  //!< the start of the alignment if the patches cannot be aligned
    Matx22d map;
    float correlation;  //!< NOT_ALIGNED if the patches cannot be aligned
    float deviation;  //!< standard deviation along the worst axis; infinity if the patches cannot be aligned
};

struct LevelWindow;

/** Grey image pyramid; each level halves the level before. Patches are sampled from the level at which their samples
 are one to two pixels apart. A few patches of a large image get small pyramids of the pixels around them, with the same
 bytes as the whole pyramid. */
class PatchPyramid
{
public:
    //! Throws unless the input is an image. An input that is not needed may be empty.
    PatchPyramid(InputArray image, const char* name, bool isNeeded);

    //! Converts the whole image to grey if single patches would convert more pixels.
    //! @return number of levels for makeLevels
    int prepare(const std::vector<PatchLocation>& patches);
    void makeLevels(int count);

    //! Finds the window of a patch.
    //! @param space memory for the patch's own pyramid
    //! @return size of a pixel of the window, in pixels of the image; 0 if the centre lies too close to the border
    int findWindow(const PatchLocation& patch, LevelWindow& window, Mat& space) const;

private:
    bool hasLevel(int level) const;

    UMat retained;
    Mat image;
    std::vector<Mat> levels;  // level 0 is empty until the image is grey
};

//! Aligns patches of two images.
class PatchAligner
{
public:
    PatchAligner(InputArray image1, InputArray image2, bool areNeeded);
    //! The first patches of pairs lie in image 1, or in image 2 if isReversed.
    std::vector<PatchAlignment> align(const std::vector<PatchPair>& pairs, bool isReversed);

private:
    PatchPyramid pyramids[2];
};

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
    //! With the first patch before the last step. NOT_ALIGNED: the other fields are undefined.
    float correlation;
    float variance;  //!< variance of the position along its worst axis, in squared pixels, uncalibrated
};

}  // namespace aqorb
}  // namespace cv

#endif
