// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "precomp.hpp"

#include "detection.hpp"

#include "corners.hpp"
#include "harris.hpp"

namespace cv
{
namespace aqorb
{
namespace stages
{

LevelDetection::LevelDetection() : level(0), depth(0), rules(), bandCount(0), isBalanced(false)
{
}

void LevelDetection::begin(const Level& level_, const Rect& root_, int depth_, const DetectionRules& rules_)
{
    level = &level_;
    root = root_;
    depth = depth_;
    rules = rules_;
    bandCount = 0;
    isBalanced = false;
}

int LevelDetection::layOutBands()
{
    const Size size = level->image.size();
    const Rect scanned = fastRegion(size, root);
    if (scanned.empty())
        return 0;
    plane.begin(size.width, scanned);
    for (;; bandCount++)
    {
        const Range rows = cornerBand(root, rules.cellSize, bandCount);
        if (rows.start >= rows.end)
            return bandCount;
        if (size_t(bandCount) == bands.size())
            bands.push_back(Band());
        Band& band = bands[bandCount];
        band.rect = Rect(root.x, rows.start, root.width, rows.end - rows.start);
        band.isRanked = false;
    }
}

void LevelDetection::searchBand(int index, DetectionScratch& scratch)
{
    CV_TRACE_FUNCTION();
    Band& band = bands[index];
    findBandCorners(*level, band.rect, rules.thresholds, rules.cellSize, plane, band.blocks, scratch.scanner);
}

void LevelDetection::rankBand(int index)
{
    CV_TRACE_FUNCTION();
    Band& band = bands[index];
    if (rules.rankByHarris)
    {
        // Harris responses of neighbours hardly differ. Without suppression a strong corner would be chosen thrice.
        suppressCorners(band.blocks, plane, band.corners);
    }
    else
    {
        band.corners.clear();
        listCorners(band.blocks, plane, band.corners);
    }
    score(band.corners, band.ranked);
    band.isRanked = true;
}

void LevelDetection::balance(DetectionScratch& scratch)
{
    CV_TRACE_FUNCTION();
    scratch.ranked.clear();
    for (int i = 0; i < bandCount; i++)
    {
        const Band& band = bands[i];
        if (!band.isRanked)
            rankBand(i);
        scratch.ranked.insert(scratch.ranked.end(), band.ranked.begin(), band.ranked.end());
    }
    leafPoints(scratch.ranked, root, depth, scratch.leaves, scratch.points);
    balanced.begin(scratch.points, depth);
    isBalanced = true;
}

BalancedSequence& LevelDetection::sequence(DetectionScratch& scratch)
{
    if (!isBalanced)
    {
        layOutBands();
        for (int i = 0; i < bandCount; i++)
            searchBand(i, scratch);
        balance(scratch);
    }
    return balanced;
}

void LevelDetection::list(CornerSet set, std::vector<RankedCorner>& corners) const
{
    corners.clear();
    std::vector<Corner> found, kept, passedOver;
    for (int i = 0; i < bandCount; i++)
    {
        const Band& band = bands[i];
        corners.insert(corners.end(), band.ranked.begin(), band.ranked.end());
        kept.insert(kept.end(), band.corners.begin(), band.corners.end());
        listCorners(band.blocks, plane, found);
    }
    if (set == SUPPRESSED_CORNERS)
        cornersWithout(found, kept, passedOver);
    else if (set == WEAK_CORNERS)
        findWeakCorners(*level, root, rules.thresholds, found, passedOver);
    else
        return;
    score(passedOver, corners);
}

void LevelDetection::score(const std::vector<Corner>& corners, std::vector<RankedCorner>& ranked) const
{
    if (rules.rankByHarris)
    {
        harrisResponses(level->image, corners, ranked);
        return;
    }
    ranked.resize(corners.size());
    for (size_t i = 0; i < corners.size(); i++)
    {
        const RankedCorner corner = {corners[i].x, corners[i].y, float(corners[i].score)};
        ranked[i] = corner;
    }
}

}  // namespace stages
}  // namespace aqorb
}  // namespace cv
