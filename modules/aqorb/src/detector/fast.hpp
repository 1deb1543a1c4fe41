// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// FAST-9/16 corners after non-maximum suppression, in one pass over the rows of a level.

#ifndef OPENCV_AQORB_FAST_HPP
#define OPENCV_AQORB_FAST_HPP

#include "detector/types.hpp"

#include <atomic>

namespace cv
{
namespace aqorb
{

//! Radius of the suppression, in x and in y. The kernel is written for this radius.
const int SUPPRESS_RADIUS = 3;
//! Readable columns of scores beside a region. The kernel of the suppression loads whole vectors.
const int SUPPRESS_MARGIN = 16;

//! Part of a region that can have FAST corners: pixels whose circle lies inside the image.
Rect fastRegion(Size imageSize, const Rect& region);

// ---- for the kernel: plain structs only, see simd_compat.hpp ---------------------------------

//! FAST corners among neighbouring pixels of a row.
struct CornerBlock
{
    int x, y;        //!< first pixel
    uint64 columns;  //!< bit i: pixel x + i is a corner
};

//! Neighbouring pixels of a row that one step scores.
struct ScanBlock
{
    int x;          //!< column of the first pixel
    uint64 wanted;  //!< bit i: the scan reports corners at x + i
};

const int SCAN_ROWS = 4;     // buffered rows of scores: at least three, and a power of two
const int SCAN_MARGIN = 64;  // columns on each side of a row of scores that vectors may touch

//! Input of a scan.
struct ScanArea
{
    const uchar* image;
    ptrdiff_t step;
    int width, height;  //!< of the image
    const uchar* mask;  //!< not 0 at usable pixels; null: all pixels are usable
    ptrdiff_t maskStep;
    int top, bottom;          //!< rows to report corners in
    const ScanBlock* blocks;  //!< of each row, from left to right
    int blockCount;
    int blockWidth;       //!< result of blockWidthFor
    int threshold;        //!< for weak corners
    int strongThreshold;  //!< for strong corners, >= threshold
};

//! Recent rows of scores. Suppression of a row waits for the scores of the row below.
struct ScanScores
{
    int nextRow;  //!< next row to score
    uchar* rows;  //!< [row modulo SCAN_ROWS][column], with SCAN_MARGIN on each side
    ptrdiff_t step;
    int* listed[2];  //!< [row modulo 2]: blocks that have scores
    int listedCount[2];
};

//! Output of a scan.
struct ScanCorners
{
    //! Scores of corners, from row planeTop on, by column. dropCorners clears the scores outside the wanted columns.
    uchar* plane;
    ptrdiff_t planeStep;
    int planeTop;
    uint64* strong;      //!< by block: bits of columns with a strong corner; only wanted bits count
    CornerBlock* found;  //!< room for all blocks of the rows to scan, and two more
    int foundCount;
};

// ---- of the stage -----------------------------------------------------------------------------

/** Score plane: for each pixel the score of its corner plus 1 (see cornerScores3x3), or 0 without a corner. It holds
 some rows of a region and slides down over the region. */
class ScorePlane
{
public:
    //! Number of rows kept above the plane.
    enum
    {
        ROWS_ABOVE = 2 * SUPPRESS_RADIUS
    };
    //! Prepares the plane for `rows` rows of a region in an image of width imageWidth. The rows above are 0.
    void reset(int imageWidth, const Rect& region, int rows);
    //! Moves the plane down to its new first row `top`.
    void slideTo(int top);
    //! Clears the SUPPRESS_RADIUS rows from y on. Row y lies in the plane or just below it.
    void clearBelow(int y);
    //! Scores of a row, by column of the image. SUPPRESS_MARGIN columns beside the region are readable.
    uchar* row(int y) { return bytes.data() + first + (y - top) * rowBytes; }
    ptrdiff_t step() const { return rowBytes; }
    int topRow() const { return top; }

private:
    std::vector<uchar> bytes;
    ptrdiff_t first, rowBytes;
    int top;
};

/** Finds the FAST-9/16 corners of a region of a level with 3x3 non-maximum suppression, some rows at a time, from top
 to bottom. Strong corners have a score >= thresholds.ini, weak corners a lower score >= thresholds.min. A scanner used
 again needs no new memory. */
class FastScanner
{
public:
    /** Starts with the first row of a region.
     @param region inside fastRegion, not empty
     @param rows that are scanned at a time, at most */
    void begin(const Level& level, const Rect& region, Thresholds thresholds, int rows);
    //! Scans the next rows up to `end`, exclusive. Each cell is a range of columns of these rows. Weak corners count
    //! outside the cells, and in cells without a strong corner.
    //! @param room number of blocks that `all` may still receive, lowered by the number of the blocks found
    //! @param all receives, if there is room, the blocks of all corners, also of weak corners that do not count
    void scan(int end, const std::vector<Range>& cells, std::atomic<int64>& room,
              std::vector<CornerBlock>& all);
    /** Appends each corner of the scanned rows once, in raster order. It holds back SUPPRESS_RADIUS rows until the
     region ends.
     @param suppressNear leaves out corners with a better corner within SUPPRESS_RADIUS */
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
    std::vector<CornerBlock> found;    // blocks that await append, in raster order
    int foundCount, cornerCount;       // number of these blocks and of their corners
    std::vector<Corner> unsuppressed;  // work space of append
};

/** Unthresholded FAST scores, -255 to 255, of (x, y) and its neighbours: scores[1 + dy][1 + dx]. Each of the 16 arcs of
 9 circle pixels has a least difference to the centre, brighter or darker. The score is the largest of the 16, which is
 one more than the response of cv::FAST. */
void cornerScores3x3(const Mat& image, int x, int y, int scores[3][3]);

}  // namespace aqorb
}  // namespace cv

#endif
