// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#ifndef OPENCV_AQORB_DETECTION_HPP
#define OPENCV_AQORB_DETECTION_HPP

#include "fast.hpp"
#include "orientation.hpp"
#include "quadtree.hpp"
#include "ranked_sequence.hpp"
#include "types.hpp"

namespace cv
{
namespace aqorb
{
namespace stages
{

//! The rules of the detection, the same for all levels of an image.
struct DetectionRules
{
    Thresholds thresholds;
    int cellSize;
    bool rankByHarris;  //!< false: corners are ranked by their FAST score, and none is suppressed
    //! For the strengths of corners in a RankedSequence.
    const OrientationPatch* strengthPatch;
};

//! Work space that a task of the detection needs only while it runs.
struct DetectionScratch
{
    FastScanner scanner;
    LeafScratch leaves;
    std::vector<LeafPoint> points;
    std::vector<FeaturePoint> patches;
    std::vector<Moments> moments;
    std::vector<uchar> usable;
};

/** Detects and ranks the corners of one level. The level is divided into bands, so that several tasks can work on it
 at once: first all bands are searched, then all are ranked, and finally their corners are put into the order of selection.
 An object can be used again, and then needs no new memory. */
class LevelDetection
{
public:
    LevelDetection();
    /** Starts with a level, which must stay where it is.
     @param level its pixels may be filled in until the first band is searched
     @param root the region in which corners are wanted */
    void begin(const Level& level, const Rect& root, const DetectionRules& rules);
    //! Divides the level into bands and returns their number.
    int layOutBands();
    //! Finds the corners of a band. Several bands may be searched at once.
    void searchBand(int index, DetectionScratch& scratch);
    //! Suppresses and ranks the corners of a band, once all bands are searched. Several bands may be ranked at once.
    void rankBand(int index);
    //! Ranks the bands that are not ranked yet and begins the sequence of all corners.
    void order(const OrderRule& rule, DetectionScratch& scratch);
    //! The sequence of the corners. If the level has not been searched yet, it is searched now.
    PointSequence& sequence(const OrderRule& rule, DetectionScratch& scratch);
    //! The corners of the sequence, by the index of its points.
    const std::vector<RankedCorner>& corners() const { return ordered; }
    //! Lists the ranked corners of a set. The level must have begun its sequence.
    void list(CornerSet set, std::vector<RankedCorner>& corners) const;

private:
    // A part of the level whose corners are found independently.
    struct Band
    {
        Rect rect;
        CornerBlocks blocks;
        bool isRanked;
        std::vector<Corner> corners;       // those kept
        std::vector<RankedCorner> ranked;  // the same, ranked
    };
    void score(const std::vector<Corner>& corners, std::vector<RankedCorner>& ranked) const;
    void orderByRank(const OrderRule& rule, DetectionScratch& scratch);

    const Level* level;
    Rect root;
    DetectionRules rules;
    std::vector<Band> bands;  // it never shrinks, so that bands keep their memory
    int bandCount;            // of this level
    ScorePlane plane;         // of all bands
    std::vector<RankedCorner> ordered;  // those kept, of all bands
    BalancedSequence balanced;
    RankedSequence ranked;
    bool isOrdered;
};

}  // namespace stages
}  // namespace aqorb
}  // namespace cv

#endif
