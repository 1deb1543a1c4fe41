// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#ifndef OPENCV_AQORB_DETECTION_HPP
#define OPENCV_AQORB_DETECTION_HPP

#include "corners.hpp"
#include "orientation.hpp"
#include "plan.hpp"
#include "ranked_order.hpp"
#include "types.hpp"

namespace cv
{
namespace aqorb
{

//! The corners of a level by what the rules of the detection say about them.
enum CornerSet
{
    KEPT_CORNERS,        //!< those that pass all rules
    SUPPRESSED_CORNERS,  //!< those that lost to a better corner nearby
    WEAK_CORNERS         //!< those below thresholds.ini in cells that have a corner at thresholds.ini
};

//! The rules of the detection, the same for all levels of an image.
struct DetectionRules
{
    //! Its listPassedOver says whether corners that are not kept are listed from the start. LevelDetection sets it once
    //! they are listed.
    CornerRules corners;
    bool useHarris;                         //!< false: the response of a corner is its FAST score
    const OrientationPatch* strengthPatch;  //!< for the strengths of corners
};

//! Work space that a task of the detection needs only while it runs.
struct DetectionScratch
{
    BandSearch search;
    RankedScratch ranked;
    std::vector<LeafPoint> points;
    Representatives representatives;
    std::vector<unsigned> order;
    std::vector<Corner> corners;
    std::vector<CornerResponse> responses;
    std::vector<float> strengths;
    std::vector<uchar> usable;
};

/** Finds the corners of one level and puts them in order. The level is divided into bands, so that several tasks can work on
 it at once. An object can be used again, and then needs no new memory. */
class LevelDetection
{
public:
    /** Starts with a level, which must stay where it is.
     @param level its pixels may be filled in until the first band is searched
     @param root the region in which corners are wanted
     @param bands how many bands there are at most
     @return number of bands, at least one */
    int reset(const Level& level, const Rect& root, const DetectionRules& rules, int bands);
    //! Sets the thresholds, before the first band is searched.
    void setThresholds(const Thresholds& thresholds) { rules.corners.thresholds = thresholds; }
    //! Finds the corners of a band. Several bands may be searched at once.
    void searchBand(int index, DetectionScratch& scratch);
    //! Puts the corners in order, once all bands have been searched.
    void order(const LevelPlan& plan, DetectionScratch& scratch);
    /** The corners of the level, with their responses, as FeatureSelector::take needs them. Where there are more than the
     quota of a level whose order is rankedOrder, they are the representatives alone. If the level has not been searched
     yet, it is searched now. */
    const std::vector<CornerResponse>& ordered(const LevelPlan& plan, DetectionScratch& scratch);
    //! Appends the corners that are not representatives to those that are in order. False: there are none.
    bool orderOthers(const LevelPlan& plan, DetectionScratch& scratch);
    //! Lists the corners of a set in raster order, with their responses. The level must have been put in order. Corners that
    //! were not listed are found by searching the level once more.
    void list(CornerSet set, DetectionScratch& scratch, std::vector<CornerResponse>& listed);

private:
    // A part of the level whose corners are found independently.
    struct Band
    {
        Rect rect;
        FoundCorners corners;  // unused in the first band, whose corners go into `found` at once
    };
    FoundCorners& cornersOf(int band) { return band == 0 ? found : bands[band].corners; }
    LeafPoint pointAt(size_t index) const;
    void represent(const LevelPlan& plan, DetectionScratch& scratch);
    void findStrengths(DetectionScratch& scratch) const;
    void findUsable(int depth, DetectionScratch& scratch) const;
    void respond(const Corner* corners, size_t count, CornerResponse* responses) const;

    const Level* level = 0;
    Rect root;
    DetectionRules rules = DetectionRules();
    std::vector<Band> bands;  // it never shrinks, so that bands keep their memory
    std::vector<Seam> seams;  // below each band but the last one
    int bandCount = 0;        // of this level
    FoundCorners found;       // of all bands, once they are in order
    LeafGrid leaves;          // kept, because images of the same size have the same
    std::vector<CornerResponse> inOrder;
    bool isOrdered = false;
    bool hasOthers = false;  // whether corners are missing in the order
};

}  // namespace aqorb
}  // namespace cv

#endif
