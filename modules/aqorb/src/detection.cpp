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
    // A RankedSequence needs the responses of few corners.
    if (!rules.strengthPatch)
        score(band.corners, rules.rankByHarris, band.ranked);
    band.isRanked = true;
}

void LevelDetection::order(const OrderRule& rule, DetectionScratch& scratch)
{
    CV_TRACE_FUNCTION();
    for (int i = 0; i < bandCount; i++)
    {
        if (!bands[i].isRanked)
            rankBand(i);
    }
    if (rule.isRanked)
    {
        orderByRank(rule, scratch);
    }
    else
    {
        ordered.clear();
        for (int i = 0; i < bandCount; i++)
            ordered.insert(ordered.end(), bands[i].ranked.begin(), bands[i].ranked.end());
        leafPoints(ordered, root, rule.depth, scratch.leaves, scratch.points);
        balanced.begin(scratch.points, rule.depth);
    }
    isOrdered = true;
}

void LevelDetection::orderByRank(const OrderRule& rule, DetectionScratch& scratch)
{
    CV_TRACE_FUNCTION();
    size_t count = 0;
    for (int i = 0; i < bandCount; i++)
        count += bands[i].corners.size();
    ordered.resize(count);
    count = 0;
    for (int i = 0; i < bandCount; i++)
    {
        const std::vector<Corner>& corners = bands[i].corners;
        for (size_t j = 0; j < corners.size(); j++)
        {
            const RankedCorner corner = {corners[j].x, corners[j].y, float(corners[j].score)};
            ordered[count++] = corner;
        }
    }
    // A tree of one leaf leaves the choice to the response.
    const bool byResponse = rule.depth == 0;
    if (byResponse)
        setResponses(ordered, scratch);
    ranked.begin(rule.depth, count);
    numberLeaves(root.size(), rule.depth, ranked, scratch.leaves);
    const unsigned *columns = scratch.leaves.columns.data(), *rows = scratch.leaves.rows.data();
    for (size_t i = 0; i < count; i++)
    {
        const RankedCorner& corner = ordered[i];
        const LeafPoint point = {columns[corner.x - root.x] + rows[corner.y - root.y], corner.response,
                                 float(corner.x), float(corner.y), int(i)};
        ranked.add(point);
    }
    ranked.findRepresentatives();
    if (!byResponse)
        scoreRepresentatives(scratch);
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

// The strength is the fourth power of FAST * sqrt(sqrt(Harris)) * moment, so that no root is needed. A corner whose moment
// is long has a well-defined direction, and is found again with the same direction.
void LevelDetection::scoreRepresentatives(DetectionScratch& scratch)
{
    const std::vector<LeafPoint>& best = ranked.representatives();
    scratch.corners.resize(best.size());
    scratch.patches.resize(best.size());
    scratch.moments.resize(best.size());
    for (size_t i = 0; i < best.size(); i++)
    {
        const int x = int(best[i].x), y = int(best[i].y);
        const Corner corner = {x, y, int(best[i].response)};
        const FeaturePoint patch = {x, y, 0};
        scratch.corners[i] = corner;
        scratch.patches[i] = patch;
    }
    patchMoments(level->image, *rules.strengthPatch, scratch.patches.data(), best.size(),
                 scratch.moments.data());
    if (rules.rankByHarris)
        score(scratch.corners, true, scratch.ranked);
    for (size_t i = 0; i < best.size(); i++)
    {
        const float fast = best[i].response * best[i].response;
        const float harris = rules.rankByHarris ? std::max(scratch.ranked[i].response, 0.f) : 1.f;
        const int64 m10 = scratch.moments[i].m10, m01 = scratch.moments[i].m01;
        const float moment = float(uint64(m10 * m10) + uint64(m01 * m01)) * (1.f / 4294967296.f);
        ranked.strength(i) = (fast * fast * harris) * (moment * moment);
    }
}

void LevelDetection::setResponses(std::vector<RankedCorner>& chosen, DetectionScratch& scratch) const
{
    if (!rules.rankByHarris || !rules.strengthPatch)
        return;
    scratch.corners.resize(chosen.size());
    for (size_t i = 0; i < chosen.size(); i++)
    {
        const Corner corner = {chosen[i].x, chosen[i].y, 0};
        scratch.corners[i] = corner;
    }
    score(scratch.corners, true, chosen);
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

void LevelDetection::list(CornerSet set, DetectionScratch& scratch, std::vector<RankedCorner>& corners) const
{
    if (set == KEPT_CORNERS)
    {
        corners = ordered;
        setResponses(corners, scratch);
        return;
    }
    std::vector<Corner> found, kept, passedOver;
    for (int i = 0; i < bandCount; i++)
    {
        const Band& band = bands[i];
        kept.insert(kept.end(), band.corners.begin(), band.corners.end());
        listCorners(band.blocks, plane, found);
    }
    if (set == SUPPRESSED_CORNERS)
        cornersWithout(found, kept, passedOver);
    else
        findWeakCorners(*level, root, rules.thresholds, found, passedOver);
    score(passedOver, rules.rankByHarris, corners);
}

void LevelDetection::score(const std::vector<Corner>& corners, bool byHarris,
                           std::vector<RankedCorner>& scored) const
{
    if (byHarris)
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
