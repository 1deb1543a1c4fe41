// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// Corners of all levels: FAST with two thresholds in a mesh of cells, then non-maximum suppression.

#ifndef OPENCV_AQORB_CORNERS_HPP
#define OPENCV_AQORB_CORNERS_HPP

#include "detector/fast.hpp"
#include "detector/types.hpp"

namespace cv
{
namespace aqorb
{

//! Side of a cell in pixels of the level. The paper gives no value.
const int CELL_SIZE = 35;

//! Options of the corner search.
struct CornerRules
{
    Thresholds thresholds;
    bool suppressNear;  //!< whether a corner loses to a better one within SUPPRESS_RADIUS
    //! Number of blocks to list in CornerLists::all, for all levels together. A negative number means that the list
    //! is incomplete.
    std::atomic<int64>* room;
};

//! Corners of a level or of a band, in raster order.
struct CornerLists
{
    std::vector<Corner> chosen;    //!< those that pass their cell's threshold and the suppression
    std::vector<CornerBlock> all;  //!< all corners of score >= thresholds.min, if there was room
};

/** Finds corners of score >= thresholds.ini and, in cells without such corners, corners of score >= thresholds.min.
 Cells are squares of side CELL_SIZE, starting at the upper left of the region. Masked corners do not count. With
 suppressNear, a corner loses to any better corner within SUPPRESS_RADIUS, even if that corner loses to a third one. The
 better corner has the higher score; at equal scores it comes first in raster order.
 @param rows rows of the region to search, whole cells
 @param found receives the corners of these rows */
void searchBand(const Level& level, const Rect& region, const Range& rows, const CornerRules& rules,
                FastScanner& scanner, CornerLists& found);

//! Rows of a level, searched by one thread.
struct Band
{
    int level;
    Range rows;
};
//! Divides the regions of all levels into bands of whole cells, enough for all threads.
std::vector<Band> divideIntoBands(const std::vector<Rect>& regions, int threads);

//! Result of findCorners. Later images use its memory again.
struct CornerSpace
{
    std::vector<CornerLists> levels;
    std::vector<CornerLists> bands;     //!< each level's later bands
    std::vector<FastScanner> scanners;  //!< one for each thread
};
//! Finds the corners of all levels by searchBand.
void findCorners(const std::vector<Level>& levels, const std::vector<Rect>& regions, const CornerRules& rules,
                 int threads, CornerSpace& space);

}  // namespace aqorb
}  // namespace cv

#endif
