// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// The pyramid: cv::ORB's levels, and their masks.

#ifndef OPENCV_AQORB_PYRAMID_HPP
#define OPENCV_AQORB_PYRAMID_HPP

#include "types.hpp"

namespace cv
{
namespace aqorb
{

//! The size of a pixel of a level in pixels of the input image, as cv::ORB computes it.
float levelScale(int level, int firstLevel, double scaleFactor);

//! The longest side of a level.
const int MAX_LEVEL_SIDE = (1 << 20) - 1;

//! The size of a level, as cv::ORB computes it; a side may be 0. Throws where a side exceeds MAX_LEVEL_SIDE.
Size levelSize(Size imageSize, float scale);

struct ResizeTables;

//! Resizes an image by cv::resize with INTER_LINEAR_EXACT, without the overhead that cv::resize has for one channel.
//! @param tables made when sizes change, and used again for later images
void resizeExact(const Mat& source, Mat& destination, Ptr<ResizeTables>& tables, int threads = 1);

//! The memory of a pyramid and the tables by which it is made. It is kept for later images.
struct PyramidSpace
{
    struct LevelSpace
    {
        AlignedVector<uchar> pixels, mask;
        Ptr<ResizeTables> resizing;
    };
    std::vector<LevelSpace> levels;
};

//! The rule by which the levels of a pyramid are made.
struct PyramidRule
{
    int firstLevel;      //!< the level that is the image itself
    double scaleFactor;  //!< between levels
    int levels;          //!< at most
    int shortestSide;    //!< of a level; the pyramid ends before the first level with a shorter one
};

/** Makes the levels of cv::ORB's pyramid of an image by cv::resize with INTER_LINEAR_EXACT. Where there is a mask, a
 pixel of a level is usable if all pixels that it is made from are. Throws where there is not enough memory for the
 levels.
 @param input the image and its mask; they are not copied
 @return the levels, whose pixels lie in the space */
std::vector<Level> makePyramid(const Level& input, const PyramidRule& rule, int threads, PyramidSpace& space);

//! Copies of the levels. One level may be the image itself.
std::vector<Mat> copiesOf(const std::vector<Level>& levels);

// ---- for the kernel: plain structs only, see types.hpp ---------------------------------------

//! The two source pixels along one axis from which INTER_LINEAR_EXACT makes a pixel.
struct ResizeTaps
{
    int first, second;
    int secondWeight;  //!< in 1/256
};

//! Where neighbouring pixels of a resized row come from: each from two source bytes.
struct ResizeBlock
{
    enum
    {
        GROUP = 8,  //!< pixels that come from the same source bytes
        GROUPS = 4,
        PIXELS = 32,
        BYTES = 16  //!< source bytes of a group
    };
    //! For each pixel the indices of its two bytes among those of its group.
    uchar pairs[GROUPS][2 * GROUP];
    //! For each pixel the weights of its two bytes in 1/256, which add up to 256. A pixel that comes from one byte
    //! alone has it twice, with the weights 255 and 1, as 256 would not fit.
    uchar weights[GROUPS][2 * GROUP];
};

//! Resizes rows by INTER_LINEAR_EXACT.
struct Resize
{
    const uchar* source;
    ptrdiff_t sourceStep;
    uchar* destination;
    ptrdiff_t destinationStep;
    int width, height;          //!< of the destination
    const ResizeBlock* blocks;  //!< as many as cover the width
    const int* bases;           //!< the first source byte of each group of the blocks
    const ResizeTaps* rowTaps;  //!< by destination row
    short* rows[2];  //!< work space of as many elements each as the blocks have pixels, and of 32 at the end
};

}  // namespace aqorb
}  // namespace cv

#endif
