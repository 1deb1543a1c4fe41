// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#ifndef OPENCV_AQORB_BLUR_HPP
#define OPENCV_AQORB_BLUR_HPP

#include "aligned.hpp"
#include "types.hpp"

namespace cv
{
namespace aqorb
{
namespace stages
{

//! The value of cv::ORB's Gaussian blur (7x7, sigma 2) at a pixel of a level, rounded as with fused multiply-add.
uchar exactBlur(const Mat& image, int x, int y);

//! The pixels of a level that are to be blurred, kept for each row of each column of tiles. The pixels at the
//! border, whose blur needs reflected pixels, have tiles of their own.
class BlurRegion
{
public:
    //! Starts with no pixels of a level of the given size.
    void begin(Size size);
    //! Adds the pixels of a rectangle that are inside the level, and possibly some more.
    void add(const Rect& rect);
    //! Adds the pixels of a disc that are inside the level, and possibly some more.
    //! @param halfHeights the greatest vertical distance from the centre, by the horizontal one
    void addDisc(const Point& center, const std::vector<int>& halfHeights);
    //! Where a search for tiles has arrived.
    struct Position
    {
        int column, row;
    };
    //! Gives the next tile of some rows, and false if there is none. The search begins at column 0 and the first row.
    bool nextTile(const Range& rows, Position& position, Rect& tile) const;

private:
    enum
    {
        TILE_WIDTH = 32  // whole vectors
    };
    int columnOf(int x) const;
    Range pixelsOf(int column) const;

    Size size;
    int columns;                // of tiles
    std::vector<uchar> needed;  // by column, by row
};

//! The elements to leave free before a row of BlurredRows that begins at a cache line, so that tiles begin at one, too.
const int BLUR_LEFT = CACHE_LINE / int(sizeof(ushort)) - 3;  // the left border has 3 columns

//! Work space of approximateBlur.
typedef std::vector<uchar> BlurScratch;

//! Some rows of the approximate blur of a level.
struct BlurredRows
{
    BlurredRows() : data(0), step(0), top(0) {}
    ushort* row(int y) const { return data + (y - top) * step; }

    ushort* data;
    ptrdiff_t step;  //!< in elements
    int top;         //!< the first row
};

/** The blur in fixed point, in units of 1/256. It exceeds the exact one before rounding by at most BLUR_EXCESS, and
 falls short of it by at most BLUR_SHORTFALL.
 @param rows to blur
 @param blurred gets the pixels of the region; others of these rows get any value */
void approximateBlur(const Mat& image, const BlurRegion& region, const Range& rows,
                     const BlurredRows& blurred, BlurScratch& scratch);

}  // namespace stages
}  // namespace aqorb
}  // namespace cv

#endif
