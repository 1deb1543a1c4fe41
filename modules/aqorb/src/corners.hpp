// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#ifndef OPENCV_AQORB_CORNERS_HPP
#define OPENCV_AQORB_CORNERS_HPP

#include "fast.hpp"
#include "types.hpp"

namespace cv
{
namespace aqorb
{

//! The rules by which corners are found.
struct CornerRules
{
    Thresholds thresholds;
    int cellSize;
    bool suppressNear;    //!< whether a corner loses to a better one within SUPPRESS_RADIUS
    bool listPassedOver;  //!< whether those that are not kept are listed, too
};

//! The corners of a band or a level, each list in raster order.
struct FoundCorners
{
    void clear();
    void append(const FoundCorners& next);

    std::vector<Corner> kept;
    std::vector<Corner> suppressed;  //!< those that lost to a better corner nearby
    std::vector<Corner> weak;        //!< those below thresholds.ini in cells that have one at thresholds.ini
};

/** The rows on both sides of the border between two bands. Which of their corners are kept can be said only when both
 bands have been searched. Each band writes its own half. */
class Seam
{
public:
    //! Prepares the seam above row y.
    void reset(int imageWidth, const Range& columns, int y);
    //! Appends the corners of the seam, once both bands have been searched.
    void list(bool listPassedOver, FoundCorners& found, std::vector<Corner>& scratch) const;

private:
    friend class BandSearch;
    ScorePlane plane;
    CornerBlocks above, below;
};

/** Finds the corners of bands: those of score >= thresholds.ini, and in cells that have none of them those of score
 >= thresholds.min. Cells are squares of side cellSize; the first is in the upper left of the band. Masked corners do
 not count. With suppressNear, a corner is kept only if there is no better one within SUPPRESS_RADIUS. A corner is better
 if it has a higher score or, with the same score, comes first in raster order. It counts even if it loses to another one
 itself. An object can be used again, and then needs no new memory. */
class BandSearch
{
public:
    /** Appends the corners of a band in raster order.
     @param above, below the seams to neighbouring bands; 0: there is no neighbour, or corners are not suppressed. The
     corners of the seams are left to them. */
    void find(const Level& level, const Rect& band, const CornerRules& rules, Seam* above, Seam* below,
              FoundCorners& found);

    //! Work space for Seam::list.
    std::vector<Corner> scratch;

private:
    void take(int end, bool listPassedOver, FoundCorners& found);
    void giveFirst(int end, Seam& above);
    void removeFirst(int removed, int cornersLeft);

    FastScanner scanner;
    ScorePlane plane;
    CornerBlocks blocks;  // of rows whose corners were not taken yet
};

//! How many bands of whole rows of cells a region can be divided into so that none is too small to be worth a task.
int mostBands(const Rect& region, int cellSize);
//! The rows of band `index` of so many of a region, at most mostBands.
Range rowsOfBand(const Rect& region, int cellSize, int bands, int index);

}  // namespace aqorb
}  // namespace cv

#endif
