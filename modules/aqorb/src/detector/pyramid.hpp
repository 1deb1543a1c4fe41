// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// Pyramid: cv::ORB's levels and their masks.

#ifndef OPENCV_AQORB_PYRAMID_HPP
#define OPENCV_AQORB_PYRAMID_HPP

#include "common/images.hpp"
#include "detector/types.hpp"

namespace cv
{
namespace aqorb
{

//! Size of a level's pixel in pixels of the input image, as cv::ORB computes it.
float levelScale(int level, int firstLevel, double scaleFactor);

//! Size of a level, as cv::ORB computes it; a side may be 0. Throws if a side exceeds MAX_LEVEL_SIDE.
Size levelSize(Size imageSize, float scale);

struct ResizeTables;

//! Resizes an image as cv::resize with INTER_LINEAR_EXACT does, without its overhead for one channel.
//! @param kept tables, remade when sizes change, and kept for later images
void resizeExact(const Mat& source, Mat& destination, Ptr<ResizeTables>& kept, int threads = 1);

//! Memory of a pyramid and its resize tables, kept for later images.
struct PyramidSpace
{
    struct LevelSpace
    {
        AlignedVector<uchar> pixels, mask;
        Ptr<ResizeTables> resizing;
    };
    std::vector<LevelSpace> levels;
};

//! Parameters of a pyramid.
struct PyramidRule
{
    int firstLevel;      //!< level of the image itself
    double scaleFactor;  //!< between levels
    int levels;          //!< maximum number of levels
    int shortestSide;    //!< the pyramid ends before the first level with a shorter side
};

/** Makes cv::ORB's pyramid of an image by resizeExact. With a mask, a pixel of a level is usable if all its source
 pixels are. Throws if memory does not suffice.
 @param input image and mask, not copied
 @return the levels, with their pixels in `space` */
std::vector<Level> makePyramid(const Level& input, const PyramidRule& rule, int threads, PyramidSpace& space);

// ---- for the kernel: plain structs only, see simd_compat.hpp ---------------------------------

//! The two source pixels of a pixel along one axis, and the weight of the second pixel.
struct ResizeTaps
{
    int first, second;
    int secondWeight;  //!< in 1/256
};

//! Sources of neighbouring pixels of a resized row: two bytes for each pixel.
struct ResizeBlock
{
    enum
    {
        GROUP = 8,  //!< pixels that share the loaded source bytes
        GROUPS = 4,
        PIXELS = 32,
        BYTES = 16  //!< loaded source bytes of a group
    };
    //! Indices of each pixel's two bytes in the bytes of its group.
    uchar pairs[GROUPS][2 * GROUP];
    //! Weights of each pixel's two bytes in 1/256; the two add up to 256. A pixel with one source byte takes it twice,
    //! with weights 255 and 1, because 256 does not fit.
    uchar weights[GROUPS][2 * GROUP];
};

//! Arguments of resizeRows.
struct Resize
{
    const uchar* source;
    ptrdiff_t sourceStep;
    uchar* destination;
    ptrdiff_t destinationStep;
    int width, height;          //!< of the destination
    const ResizeBlock* blocks;  //!< cover the width
    const int* bases;           //!< first source byte of each group
    const ResizeTaps* rowTaps;  //!< by destination row
    short* rows[2];             //!< work space: one element for each pixel of the blocks, and 32 more
};

}  // namespace aqorb
}  // namespace cv

#endif
