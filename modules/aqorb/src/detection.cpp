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

LevelDetection::LevelDetection() : level(0), rules(), bandCount(0), isOrdered(false)
{
}

void LevelDetection::begin(const Level& level_, const Rect& root_, const DetectionRules& rules_)
{
    level = &level_;
    root = root_;
    rules = rules_;
    bandCount = 0;
    isOrdered = false;
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

void LevelDetection::order(const OrderRule& rule, DetectionScratch& scratch)
{
    CV_TRACE_FUNCTION();
    ordered.clear();
    for (int i = 0; i < bandCount; i++)
    {
        const Band& band = bands[i];
        if (!band.isRanked)
            rankBand(i);
        ordered.insert(ordered.end(), band.ranked.begin(), band.ranked.end());
    }
    if (rule.isRanked)
    {
        orderByRank(rule, scratch);
    }
    else
    {
        leafPoints(ordered, root, rule.depth, scratch.leaves, scratch.points);
        balanced.begin(scratch.points, rule.depth);
    }
    isOrdered = true;
}

// The strength of a corner is the fourth power of FAST * sqrt(sqrt(Harris)), so that no root is needed.
static float cornerStrength(int fastScore, float harrisResponse)
{
    const float squared = float(fastScore) * float(fastScore);
    return squared * squared * std::max(harrisResponse, 0.f);
}

void LevelDetection::orderByRank(const OrderRule& rule, DetectionScratch& scratch)
{
    // A tree of one leaf leaves the choice to the response.
    const bool byResponse = rule.depth == 0;
    ranked.begin(rule.depth, ordered.size());
    numberLeaves(root.size(), rule.depth, ranked, scratch.leaves);
    const unsigned *columns = scratch.leaves.columns.data(), *rows = scratch.leaves.rows.data();
    int index = 0;
    for (int i = 0; i < bandCount; i++)
    {
        const Band& band = bands[i];
        for (size_t j = 0; j < band.corners.size(); j++, index++)
        {
            const Corner& corner = band.corners[j];
            const float response = band.ranked[j].response;
            const float strength =
                byResponse ? response : cornerStrength(corner.score, rules.rankByHarris ? response : 1.f);
            const LeafPoint point = {columns[corner.x - root.x] + rows[corner.y - root.y], strength,
                                     float(corner.x), float(corner.y), index};
            ranked.add(point);
        }
    }
    ranked.findRepresentatives();

    const std::vector<LeafPoint>& best = ranked.representatives();
    if (!byResponse)
    {
        // A corner whose direction is well defined is found again with the same direction.
        scratch.patches.resize(best.size());
        scratch.moments.resize(best.size());
        for (size_t i = 0; i < best.size(); i++)
        {
            scratch.patches[i].x = int(best[i].x);
            scratch.patches[i].y = int(best[i].y);
        }
        patchMoments(level->image, *rules.strengthPatch, scratch.patches.data(), best.size(),
                     scratch.moments.data());
        for (size_t i = 0; i < best.size(); i++)
        {
            const int64 m10 = scratch.moments[i].m10, m01 = scratch.moments[i].m01;
            const float squared = float(uint64(m10 * m10) + uint64(m01 * m01)) * (1.f / 4294967296.f);
            ranked.strength(i) *= squared * squared;
        }
    }
    scratch.usable.clear();
    if (!level->mask.empty())
    {
        const int depth = rule.depth, side = 1 << depth;
        for (int row = 0; row < side; row++)
        {
            const int y = root.y + int((int64(2 * row + 1) * root.height) >> (depth + 1));
            for (int column = 0; column < side; column++)
            {
                const int x = root.x + int((int64(2 * column + 1) * root.width) >> (depth + 1));
                scratch.usable.push_back(level->mask.at<uchar>(y, x));
            }
        }
    }
    ranked.rank(rule.rank, byResponse ? 1 : 4, scratch.usable);
}

PointSequence& LevelDetection::sequence(const OrderRule& rule, DetectionScratch& scratch)
{
    if (!isOrdered)
    {
        layOutBands();
        for (int i = 0; i < bandCount; i++)
            searchBand(i, scratch);
        order(rule, scratch);
    }
    if (rule.isRanked)
        return ranked;
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

void LevelDetection::score(const std::vector<Corner>& corners, std::vector<RankedCorner>& scored) const
{
    if (rules.rankByHarris)
    {
        harrisResponses(level->image, corners, scored);
        return;
    }
    scored.resize(corners.size());
    for (size_t i = 0; i < corners.size(); i++)
    {
        const RankedCorner corner = {corners[i].x, corners[i].y, float(corners[i].score)};
        scored[i] = corner;
    }
}

}  // namespace stages
}  // namespace aqorb
}  // namespace cv
