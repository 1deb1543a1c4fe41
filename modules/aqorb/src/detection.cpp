// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "precomp.hpp"

#include "detection.hpp"

#include "harris.hpp"

namespace cv
{
namespace aqorb
{

int LevelDetection::reset(const Level& level_, const Rect& root_, const DetectionRules& rules_, int most)
{
    level = &level_;
    root = root_;
    rules = rules_;
    isOrdered = hasOthers = false;
    found.clear();
    bandCount = std::min(mostBands(root, rules.corners.cellSize), most);
    if (bands.size() < size_t(bandCount))
        bands.resize(bandCount);
    if (seams.size() + 1 < size_t(bandCount))
        seams.resize(bandCount - 1);
    const Size size = level->image.size();
    const Rect scanned = fastRegion(size, root);
    for (int i = 0; i < bandCount; i++)
    {
        const Range rows = rowsOfBand(root, rules.corners.cellSize, bandCount, i);
        bands[i].rect = Rect(root.x, rows.start, root.width, rows.size());
        bands[i].corners.clear();
        if (i > 0)
            seams[i - 1].reset(size.width, Range(scanned.x, scanned.x + scanned.width), rows.start);
    }
    return bandCount;
}

void LevelDetection::searchBand(int index, DetectionScratch& scratch)
{
    const bool hasSeams = rules.corners.suppressNear;
    Seam* const above = hasSeams && index > 0 ? &seams[index - 1] : 0;
    Seam* const below = hasSeams && index < bandCount - 1 ? &seams[index] : 0;
    scratch.search.find(*level, bands[index].rect, rules.corners, above, below, cornersOf(index));
}

void LevelDetection::order(const LevelPlan& plan, DetectionScratch& scratch)
{
    CV_TRACE_FUNCTION();
    for (int i = 1; i < bandCount; i++)
    {
        if (rules.corners.suppressNear)
            seams[i - 1].list(rules.corners.listPassedOver, found, scratch.search.scratch);
        found.append(bands[i].corners);
    }
    isOrdered = true;
    hasOthers = plan.isRanked && plan.depth > 0 && found.kept.size() > size_t(plan.quota);
    if (!hasOthers)
    {
        inOrder.resize(found.kept.size());
        respond(found.kept.data(), found.kept.size(), inOrder.data());
        // A tree of one leaf leaves the choice to the response.
        if (plan.isRanked && plan.depth == 0)
            std::sort(inOrder.begin(), inOrder.end(),
                      [](const CornerResponse& a, const CornerResponse& b)
                      { return a.response != b.response ? a.response > b.response : InRasterOrder()(a, b); });
        return;
    }
    represent(plan, scratch);
    findStrengths(scratch);
    findUsable(plan.depth, scratch);
    orderRepresentatives(scratch.representatives.leaves, scratch.strengths, 4, plan.depth, scratch.usable,
                         plan.rankRule, scratch.ranked, scratch.order);
    inOrder.resize(scratch.order.size());
    for (size_t i = 0; i < inOrder.size(); i++)
        inOrder[i] = scratch.responses[scratch.order[i]];
}

// Of a leaf the corner with the highest FAST score is the best.
LeafPoint LevelDetection::pointAt(size_t index) const
{
    const Corner& corner = found.kept[index];
    return {leaves.leaf(corner.x, corner.y), corner.score};
}

// Finds the representatives.
void LevelDetection::represent(const LevelPlan& plan, DetectionScratch& scratch)
{
    leaves.reset(root, plan.depth);
    findRepresentatives(
        found.kept.size(), [&](size_t i) { return pointAt(i); }, plan.depth, scratch.ranked,
        scratch.representatives);
}

// The strength is the fourth power of FAST * sqrt(sqrt(Harris)) * moment, so that no root is needed. A corner whose moment
// is long has a well-defined direction, and is found again with the same direction.
void LevelDetection::findStrengths(DetectionScratch& scratch) const
{
    const size_t AT_ONCE = 64, size = scratch.representatives.points.size();
    scratch.responses.resize(size);
    scratch.strengths.resize(size);
    for (size_t first = 0; first < size; first += AT_ONCE)
    {
        const size_t some = std::min(size - first, AT_ONCE);
        Corner corners[AT_ONCE];
        FeaturePoint patches[AT_ONCE];
        Moments moments[AT_ONCE];
        for (size_t i = 0; i < some; i++)
        {
            const Corner& corner = corners[i] = found.kept[scratch.representatives.points[first + i]];
            patches[i] = {corner.x, corner.y, 0};
        }
        patchMoments(level->image, *rules.strengthPatch, patches, some, moments);
        CornerResponse* const responses = &scratch.responses[first];
        respond(corners, some, responses);
        for (size_t i = 0; i < some; i++)
        {
            const float score = float(corners[i].score), fast = score * score;
            const float harris = rules.useHarris ? std::max(responses[i].response, 0.f) : 1.f;
            const int64 m10 = moments[i].m10, m01 = moments[i].m01;
            const float moment = float(uint64(m10 * m10) + uint64(m01 * m01)) * (1.f / 4294967296.f);
            scratch.strengths[first + i] = (fast * fast * harris) * (moment * moment);
        }
    }
}

// By leaf: whether its centre may have a corner.
void LevelDetection::findUsable(int depth, DetectionScratch& scratch) const
{
    scratch.usable.clear();
    for (unsigned leaf = 0; !level->mask.empty() && leaf < 1u << (2 * depth); leaf++)
        scratch.usable.push_back(level->mask.at<uchar>(leaves.centre(leaf)));
}

const std::vector<CornerResponse>& LevelDetection::ordered(const LevelPlan& plan, DetectionScratch& scratch)
{
    if (!isOrdered)
    {
        for (int i = 0; i < bandCount; i++)
            searchBand(i, scratch);
        order(plan, scratch);
    }
    return inOrder;
}

bool LevelDetection::orderOthers(const LevelPlan& plan, DetectionScratch& scratch)
{
    if (!hasOthers)
        return false;
    hasOthers = false;
    represent(plan, scratch);
    scratch.points.clear();
    for (size_t i = 0; i < found.kept.size(); i++)
        scratch.points.push_back(pointAt(i));
    aqorb::orderOthers(scratch.points, scratch.representatives.points, scratch.ranked, scratch.order);
    scratch.corners.clear();
    for (unsigned index : scratch.order)
        scratch.corners.push_back(found.kept[index]);
    const size_t before = inOrder.size(), size = scratch.corners.size();
    inOrder.resize(before + size);
    respond(scratch.corners.data(), size, inOrder.data() + before);
    return !scratch.order.empty();
}

void LevelDetection::list(CornerSet set, DetectionScratch& scratch, std::vector<CornerResponse>& listed)
{
    if (set != KEPT_CORNERS && !rules.corners.listPassedOver)
    {
        found.clear();
        rules.corners.listPassedOver = true;
        scratch.search.find(*level, root, rules.corners, 0, 0, found);
    }
    const std::vector<Corner>& corners = set == KEPT_CORNERS         ? found.kept
                                         : set == SUPPRESSED_CORNERS ? found.suppressed
                                                                     : found.weak;
    listed.resize(corners.size());
    respond(corners.data(), corners.size(), listed.data());
}

void LevelDetection::respond(const Corner* corners, size_t count, CornerResponse* responses) const
{
    if (rules.useHarris)
        return harrisResponses(level->image, corners, count, responses);
    for (size_t i = 0; i < count; i++)
        responses[i] = {corners[i].x, corners[i].y, float(corners[i].score)};
}

}  // namespace aqorb
}  // namespace cv
