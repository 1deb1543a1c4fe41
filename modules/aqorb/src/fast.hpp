// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// FAST-9/16 corners after non-maximum suppression, found in one pass over the rows of a level.

#ifndef OPENCV_AQORB_FAST_HPP
#define OPENCV_AQORB_FAST_HPP

#include "types.hpp"

namespace cv
{
namespace aqorb
{

//! A corner loses to a better one at most this far away in x and in y. The kernel is written for this radius.
const int SUPPRESS_RADIUS = 3;
//! The columns beside a region whose scores must be readable, as the kernel of the suppression loads whole vectors.
const int SUPPRESS_MARGIN = 16;

//! The part of a region in which there may be FAST corners: the pixels whose whole circle is inside the image.
Rect fastRegion(Size imageSize, const Rect& region);

// ---- for the kernel: plain structs only, see types.hpp ---------------------------------------

//! Neighbouring pixels of a row, and which of them are FAST corners.
struct CornerBlock
{
    int x, y;        //!< the first pixel
    uint64 columns;  //!< bit i: whether pixel x + i is a corner
};

//! Neighbouring pixels of a row that are scored together.
struct ScanBlock
{
    int x;          //!< the first
    uint64 wanted;  //!< bit i: whether a corner at x + i is wanted
};

const int SCAN_ROWS = 4;  // rows of scores that are kept: at least three, and a power of two
// Bytes to which scores are aligned, so that as few vectors as possible cross the border of a cache line.
const int SCAN_ALIGNMENT = 64;
const int SCAN_MARGIN = 64;  // columns around the scores of a row that vectors may touch

//! What is scanned, and for which corners.
struct ScanArea
{
    const uchar* image;
    ptrdiff_t step;
    int width, height;  //!< of the image
    const uchar* mask;  //!< of usable pixels; 0: all are usable
    ptrdiff_t maskStep;
    int top, bottom;          //!< the rows in which corners are wanted
    const ScanBlock* blocks;  //!< of each row, from left to right
    int blockCount;
    int blockWidth;       //!< by blockWidthFor
    int threshold;        //!< of all corners
    int strongThreshold;  //!< >= threshold
};

//! The scores that suppression still needs: it finds the corners of a row as soon as the row below it has scores, too.
struct ScanScores
{
    int nextRow;  //!< to get scores
    uchar* rows;  //!< SCAN_ROWS rows, by row modulo their number, by column, with SCAN_MARGIN on both sides
    ptrdiff_t step;
    int* listed[2];  //!< by row modulo 2: the blocks in which there are scores
    int listedCount[2];
};

//! What a scan finds.
struct ScanCorners
{
    //! The scores of corners, from row planeTop on, by column. Scores in columns that are not wanted mean nothing until
    //! dropCorners clears them.
    uchar* plane;
    ptrdiff_t planeStep;
    int planeTop;
    uint64* strong;  //!< by block: the columns with a strong corner; other bits than wanted ones mean nothing
    CornerBlock* found;  //!< has space for all blocks of the rows to scan, and two more
    int foundCount;
};

// ---- of the stage -----------------------------------------------------------------------------

/** By pixel, the score of a corner plus 1, as cornerScores3x3 counts; 0 where there is none. The plane holds some rows
 of a region only, and slides down over the region. */
class ScorePlane
{
public:
    //! How many rows above the plane's first one are kept.
    enum
    {
        ROWS_ABOVE = 2 * SUPPRESS_RADIUS
    };
    //! Prepares the plane for `rows` rows of a region of an image imageWidth wide. The rows above are 0.
    void reset(int imageWidth, const Rect& region, int rows);
    //! Moves the plane down, so that `top` becomes its first row.
    void slideTo(int top);
    //! Clears the SUPPRESS_RADIUS rows from y on. Row y is at most the one below the plane.
    void clearBelow(int y);
    //! The scores of a row by column of the image. SUPPRESS_MARGIN columns beside the region are readable, too.
    uchar* row(int y) { return bytes.data() + first + (y - top) * rowBytes; }
    ptrdiff_t step() const { return rowBytes; }
    int topRow() const { return top; }

private:
    std::vector<uchar> bytes;
    ptrdiff_t first, rowBytes;
    int top;
};

/** Finds the FAST-9/16 corners of a region of a level, with 3x3 non-maximum suppression, from top to bottom and some
 rows at a time. Corners of score >= thresholds.ini are called strong, and others of score >= thresholds.min weak. An
 object can be used again, and then needs no new memory. */
class FastScanner
{
public:
    /** Starts with the first row of a region.
     @param region inside fastRegion, not empty
     @param rows that are scanned at a time, at most */
    void begin(const Level& level, const Rect& region, Thresholds thresholds, int rows);
    //! Scans the next rows, up to the row before `end`. A cell is a range of columns of these rows. Weak corners count
    //! only outside of the cells, and in cells without a strong one.
    void scan(int end, const std::vector<Range>& cells);
    /** Appends the corners of the scanned rows, in raster order and each once. It holds SUPPRESS_RADIUS rows back until
     the region ends.
     @param suppressNear leaves out corners that have a better one within SUPPRESS_RADIUS */
    void append(bool suppressNear, std::vector<Corner>& corners);

private:
    bool hasStrong(const Range& columns) const;

    ScanArea area;
    ScanScores kept;
    ScanCorners out;
    Range columns;
    ScorePlane plane;
    std::vector<ScanBlock> blocks;
    std::vector<uchar> scores, dropped;
    std::vector<int> listed;
    std::vector<uint64> strong;
    std::vector<CornerBlock> found;    // with corners that were not appended yet, in raster order
    int foundCount, cornerCount;       // elements of `found` in use, and their corners
    std::vector<Corner> unsuppressed;  // work space of append
};

/** The unthresholded FAST scores, -255 to 255, of (x, y) and its neighbours: scores[1 + dy][1 + dx]. A score is the
 largest over the 16 arcs of 9 circle pixels of their least difference to the centre, brighter or darker. That is one
 more than the response of cv::FAST. */
void cornerScores3x3(const Mat& image, int x, int y, int scores[3][3]);

}  // namespace aqorb
}  // namespace cv

#endif
