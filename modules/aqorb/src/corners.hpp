// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#ifndef OPENCV_AQORB_CORNERS_HPP
#define OPENCV_AQORB_CORNERS_HPP

#include "types.hpp"

namespace cv
{
namespace aqorb
{
namespace stages
{

struct CornerBlocks;
class ScorePlane;
class FastScanner;

//! The rows of band `index` of a region: whole rows of cells, whose corners are found independently of other bands.
//! Empty if the index is too high.
Range cornerBand(const Rect& region, int cellSize, int index);

/** Finds the corners of a band: those of score >= thresholds.ini, and in cells that have none of them those of score
 >= thresholds.min. Cells are squares of side cellSize; the first begins at the corner of the band. Masked
 corners do not count.
 @param plane prepared for fastRegion of the whole region; other bands may be searched at the same time
 @param found gets the corners of this band only */
void findBandCorners(const Level& level, const Rect& band, Thresholds thresholds, int cellSize,
                     ScorePlane& plane, CornerBlocks& found, FastScanner& scanner);

/** The corners of a band that have no better corner within SUPPRESS_RADIUS. A corner is better if it has a higher
 score or, with the same score, comes first in raster order. It counts even if it loses to another one itself.
 @param plane of the whole region */
void suppressCorners(const CornerBlocks& blocks, const ScorePlane& plane, std::vector<Corner>& kept);

//! The corners that are not among the excluded ones. All are in raster order.
void cornersWithout(const std::vector<Corner>& corners, const std::vector<Corner>& excluded,
                    std::vector<Corner>& remaining);

/** The corners of score >= thresholds.min that findBandCorners leaves out because their cell has a strong one.
 @param found the corners that it finds in all bands of the region */
void findWeakCorners(const Level& level, const Rect& region, Thresholds thresholds,
                     const std::vector<Corner>& found, std::vector<Corner>& weak);

}  // namespace stages
}  // namespace aqorb
}  // namespace cv

#endif
