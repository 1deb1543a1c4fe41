// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// The corners of all levels: FAST by two thresholds in a mesh of cells, without those near a better one.

#ifndef OPENCV_AQORB_CORNERS_HPP
#define OPENCV_AQORB_CORNERS_HPP

#include "fast.hpp"
#include "types.hpp"

namespace cv
{
namespace aqorb
{

//! The side of the cells in pixels of the level. The paper states none.
const int CELL_SIZE = 35;

//! The rules by which corners are found.
struct CornerRules
{
    Thresholds thresholds;
    bool suppressNear;  //!< whether a corner loses to a better one within SUPPRESS_RADIUS
};

/** Finds corners of score >= thresholds.ini and, in cells without one, corners of score >= thresholds.min. Cells are
 squares of side CELL_SIZE; the first is in the upper left of the region. Masked corners do not count. With
 suppressNear, a corner is kept only if there is no better one within SUPPRESS_RADIUS. A corner is better if it has a
 higher score or, with the same score, comes first in raster order. It counts even if it loses to another one itself.
 @param rows of the region, from the first row of a cell to the last row of another one
 @param found gets the corners of these rows, in raster order */
void searchBand(const Level& level, const Rect& region, const Range& rows, const CornerRules& rules,
                FastScanner& scanner, std::vector<Corner>& found);

//! Rows of a level that are searched together.
struct Band
{
    int level;
    Range rows;
};
//! Divides the regions of levels into bands of whole cells, enough of them for all threads.
std::vector<Band> divideIntoBands(const std::vector<Rect>& regions, int threads);

//! The result of findCorners, and its memory, which is kept for later images.
struct CornerSpace
{
    std::vector<std::vector<Corner>> corners;  //!< by level, in raster order
    std::vector<std::vector<Corner>> bands;    //!< the corners of bands that are not the first of their level
    std::vector<FastScanner> scanners;         //!< of each thread
};
//! Finds the corners of all levels, as searchBand does.
void findCorners(const std::vector<Level>& levels, const std::vector<Rect>& regions, const CornerRules& rules,
                 int threads, CornerSpace& space);

}  // namespace aqorb
}  // namespace cv

#endif
