// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#ifndef OPENCV_AQORB_DETECTION_HPP
#define OPENCV_AQORB_DETECTION_HPP

#include "balanced_sequence.hpp"
#include "corners.hpp"
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
    KeptCount* count;   //!< of the image
    //! For the strengths of corners in a RankedSequence.
    const OrientationPatch* strengthPatch;
};

//! Work space that a task of the detection needs only while it runs.
struct DetectionScratch
{
    BandSearch search;
    RankedScratch ranking;
    LeafScratch leaves;
    std::vector<LeafPoint> points;
    std::vector<Corner> corners;
    std::vector<RankedCorner> ranked;
    std::vector<FeaturePoint> patches;
    std::vector<Moments> moments;
    std::vector<uchar> usable;
};

/** Finds the corners of one level and puts them into the order of selection. The level is divided into bands, so that
 several tasks can work on it at once. An object can be used again, and then needs no new memory. */
class LevelDetection : private PointSource, private PointSequence
{
public:
    LevelDetection();
    /** Starts with a level, which must stay where it is.
     @param level its pixels may be filled in until the first band is searched
     @param root the region in which corners are wanted
     @param bands how many bands there are at most
     @return number of bands, at least one */
    int begin(const Level& level, const Rect& root, const DetectionRules& rules, int bands);
    //! Sets the thresholds, before the first band is searched.
    void setThresholds(const Thresholds& thresholds) { rules.thresholds = thresholds; }
    //! Finds the corners of a band. Several bands may be searched at once.
    void searchBand(int index, DetectionScratch& scratch);
    //! Begins the sequence of all corners, once all bands have been searched.
    void order(const OrderRule& rule, DetectionScratch& scratch);
    //! The sequence of the corners. If the level has not been searched yet, it is searched now. The rule, which is that of
    //! order, and the work space must stay while points are taken, as the level may have to be ranked again.
    PointSequence& sequence(const OrderRule& rule, DetectionScratch& scratch);
    //! Lists the corners of a set with their responses. The level must have begun its sequence.
    void list(CornerSet set, DetectionScratch& scratch, std::vector<RankedCorner>& listed);

private:
    // A part of the level whose corners are found independently.
    struct Band
    {
        Rect rect;
        FoundCorners corners;  // unused in the first band, whose corners go into `found` at once
    };
    FoundCorners& cornersOf(int band) { return band == 0 ? found : bands[band].corners; }
    void respond(const Corner* corners, size_t count, RankedCorner* ranked) const;
    void respond(const std::vector<Corner>& corners, std::vector<RankedCorner>& ranked) const;
    void orderByRank(const OrderRule& rule, DetectionScratch& scratch, size_t enough);
    void findStrengths(DetectionScratch& scratch);

    size_t count() const CV_OVERRIDE { return found.kept.size(); }
    LeafPoint point(size_t index) const CV_OVERRIDE;
    unsigned leaf(const LeafPoint& point) const CV_OVERRIDE;
    float response(const LeafPoint& point) const CV_OVERRIDE;
    void willTake(size_t count) CV_OVERRIDE { ranked.willTake(count); }
    bool next(LeafPoint& point, const PointFilter* filter) CV_OVERRIDE;

    const Level* level;
    Rect root;
    DetectionRules rules;
    std::vector<Band> bands;              // it never shrinks, so that bands keep their memory
    std::vector<Seam> seams;              // below each band but the last one
    int bandCount;                        // of this level
    FoundCorners found;                   // of all bands, once they are ordered
    std::vector<RankedCorner> responses;  // of the corners, where the response alone ranks them
    int depth;                            // of the ranked sequence
    BalancedSequence balanced;
    RankedSequence ranked;
    bool isOrdered;
    // The arguments of sequence.
    const OrderRule* ruleInUse;
    DetectionScratch* scratchInUse;
};

}  // namespace stages
}  // namespace aqorb
}  // namespace cv

#endif
