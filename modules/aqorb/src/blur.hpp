// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// The Gaussian blur whose pixels descriptors compare: exactly as cv::ORB's, and fast with a bound on the error.

#ifndef OPENCV_AQORB_BLUR_HPP
#define OPENCV_AQORB_BLUR_HPP

#include "types.hpp"

namespace cv
{
namespace aqorb
{

//! The value of cv::ORB's Gaussian blur (7x7, sigma 2) at a pixel of a level, rounded as with fused multiply-add.
uchar exactBlur(const Mat& image, int x, int y);

//! The pixels that the kernel blurs side by side: whole vectors.
const int BLUR_TILE_WIDTH = 32;

//! How far around a level there must be BlurredRows if points within `reach` are read. Whole tiles fit into it.
int blurMargin(int reach);

//! Some rows of the approximate blur of a level and of the margin around it.
struct BlurredRows
{
    ushort* row(int y) const { return data + (y - top) * step; }

    ushort* data;    //!< column 0 of the first row
    ptrdiff_t step;  //!< in elements
    int top;         //!< the first row
};

//! The pixels of a level and of the margin around it that are to be blurred, by column of tiles and by row.
class BlurRegion
{
public:
    //! Starts with no pixels of a level of the given size.
    //! @param margin a blurMargin
    void reset(Size size, int margin);
    //! Adds the pixels of a disc and possibly some more. Its centre lies in the level or one pixel beside it.
    //! @param halfHeights the greatest vertical distance from the centre, by the horizontal one
    void addDisc(const Point& center, const std::vector<int>& halfHeights);

    //! The number of columns of tiles.
    int columns() const { return 2 * borderTiles + innerTiles; }
    int firstPixelOf(int column) const;
    //! Whether the pixels of a column are needed, by row.
    const uchar* rowsOf(int column) const;

private:
    int columnOf(int x) const;

    Size size;
    int margin, borderTiles, innerTiles;  // tiles on either side, and between
    std::vector<uchar> needed;            // by column, by row
};

//! By how many units of 1/256 at most the approximate blur exceeds the exact one before rounding, or falls short of it.
const int BLUR_EXCESS = 2, BLUR_SHORTFALL = 10;

/** The blur in fixed point, in units of 1/256. It exceeds the exact one before rounding by at most BLUR_EXCESS, and
 falls short of it by at most BLUR_SHORTFALL. Outside of the level stand the reflected pixels themselves: those cv::ORB
 does not blur.
 @param rows to blur; may begin and end in the margin
 @param blurred gets the pixels of the region; others of these rows get any value
 @param scratch work space
 @param isExact gives exactBlur times 256, which is within these bounds, too */
void approximateBlur(const Mat& image, const BlurRegion& region, const Range& rows,
                     const BlurredRows& blurred, std::vector<uchar>& scratch, bool isExact = false);

}  // namespace aqorb
}  // namespace cv

#endif
