// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// Gaussian blur before the descriptor: exactly as in cv::ORB, or fast with an error bound.

#ifndef OPENCV_AQORB_BLUR_HPP
#define OPENCV_AQORB_BLUR_HPP

#include "detector/types.hpp"

namespace cv
{
namespace aqorb
{

//! cv::ORB's Gaussian blur (7x7, sigma 2) at a pixel of a level, rounded as with fused multiply-add.
uchar exactBlur(const Mat& image, int x, int y);

//! Width of a tile in pixels, a multiple of all vector lengths.
const int BLUR_TILE_WIDTH = 32;

//! Margin of the BlurredRows around a level when descriptors read up to `reach` pixels away, rounded to whole tiles.
int blurMargin(int reach);

//! Rows of the approximate blur of a level and its margin.
struct BlurredRows
{
    ushort* row(int y) const { return data + (y - top) * step; }

    ushort* data;    //!< column 0 of the first row
    ptrdiff_t step;  //!< in elements
    int top;         //!< the first row
};

//! Set of pixels to blur in a level and its margin, by column of tiles and by row.
class BlurRegion
{
public:
    //! Empties the region and sets the size of the level.
    //! @param margin a result of blurMargin
    void reset(Size size, int margin);
    //! Adds at least the pixels of a disc. Its centre lies in the level or one pixel outside.
    //! @param halfHeights half height of the disc, by horizontal distance from the centre
    void addDisc(const Point& center, const std::vector<int>& halfHeights);

    //! Number of columns of tiles.
    int columns() const { return 2 * borderTiles + innerTiles; }
    int firstPixelOf(int column) const;
    //! Flags of a column: whether to blur its tile row, by row.
    const uchar* rowsOf(int column) const;

private:
    int columnOf(int x) const;

    Size size;
    int margin, borderTiles, innerTiles;  // tiles at each side, and between the sides
    std::vector<uchar> needed;            // [column][row]
};

//! Error bounds of the approximate blur against the exact blur before rounding, in units of 1/256.
const int BLUR_EXCESS = 2, BLUR_SHORTFALL = 10;

/** Blurs rows in fixed point, in units of 1/256. A value exceeds the exact blur before rounding by at most BLUR_EXCESS,
 and falls short of it by at most BLUR_SHORTFALL. In the margin it copies reflected pixels unblurred, as cv::ORB does.
 @param rows rows to blur; may begin and end in the margin
 @param blurred receives the pixels of the region; other pixels of these rows become undefined
 @param space work space
 @param isExact computes exactBlur times 256 instead, within the same bounds */
void approximateBlur(const Mat& image, const BlurRegion& region, const Range& rows,
                     const BlurredRows& blurred, std::vector<uchar>& space, bool isExact = false);

}  // namespace aqorb
}  // namespace cv

#endif
