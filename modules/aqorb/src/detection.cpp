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
namespace stages
{

LevelDetection::LevelDetection()
    : level(0), rules(), bandCount(0), depth(0), isOrdered(false), ruleInUse(0), scratchInUse(0)
{
}

int LevelDetection::begin(const Level& level_, const Rect& root_, const DetectionRules& rules_, int most)
{
    level = &level_;
    root = root_;
    rules = rules_;
    isOrdered = false;
    found.clear();
    bandCount = std::min(mostBands(root, rules.cellSize), most);
    if (bands.size() < size_t(bandCount))
        bands.resize(bandCount);
    if (seams.size() + 1 < size_t(bandCount))
        seams.resize(bandCount - 1);
    const Size size = level->image.size();
    const Rect scanned = fastRegion(size, root);
    for (int i = 0; i < bandCount; i++)
    {
        const Range rows = rowsOfBand(root, rules.cellSize, bandCount, i);
        bands[i].rect = Rect(root.x, rows.start, root.width, rows.size());
        bands[i].corners.clear();
        if (i > 0)
            seams[i - 1].begin(size.width, Range(scanned.x, scanned.x + scanned.width), rows.start);
    }
    return bandCount;
}

void LevelDetection::searchBand(int index, DetectionScratch& scratch)
{
    const bool hasSeams = rules.rankByHarris;
    Seam* const above = hasSeams && index > 0 ? &seams[index - 1] : 0;
    Seam* const below = hasSeams && index < bandCount - 1 ? &seams[index] : 0;
    // Harris responses of neighbours hardly differ. Without suppression a strong corner would be chosen thrice.
    const CornerRules ofCorners = {rules.thresholds, rules.cellSize, rules.rankByHarris, rules.count};
    scratch.search.find(*level, bands[index].rect, ofCorners, above, below, cornersOf(index));
}

void LevelDetection::order(const OrderRule& rule, DetectionScratch& scratch)
{
    CV_TRACE_FUNCTION();
    for (int i = 1; i < bandCount; i++)
    {
        if (rules.rankByHarris)
            seams[i - 1].list(found.isComplete, found, scratch.search.scratch);
        found.append(bands[i].corners);
    }
    if (rule.isRanked)
    {
        // Octave suppression passes over some representatives, so more than the quota are put in order.
        orderByRank(rule, scratch, 2 * size_t(rule.rank.quota));
    }
    else
    {
        respond(found.kept, scratch.ranked);
        leafPoints(scratch.ranked, root, rule.depth, scratch.leaves, scratch.points);
        balanced.begin(scratch.points, rule.depth);
    }
    isOrdered = true;
}

void LevelDetection::orderByRank(const OrderRule& rule, DetectionScratch& scratch, size_t enough)
{
    CV_TRACE_FUNCTION();
    depth = rule.depth;
    responses.clear();
    if (found.kept.size() <= size_t(rule.rank.quota))
    {
        respond(found.kept, scratch.ranked);
        return ranked.beginUnranked(*this, scratch.ranked);
    }
    // A tree of one leaf leaves the choice to the response.
    if (depth == 0)
        respond(found.kept, responses);
    ranked.begin(depth, *this, scratch.ranking);
    numberLeaves(root.size(), depth, scratch.leaves);
    const unsigned *columns = scratch.leaves.columns.data(), *rows = scratch.leaves.rows.data();
    RankedSequence::Adder adder(ranked);
    const std::vector<Corner>& corners = found.kept;
    for (size_t i = 0; i < corners.size(); i++)
    {
        const Corner& corner = corners[i];
        const unsigned leaf = columns[corner.x - root.x] + rows[corner.y - root.y];
        adder.add(leaf, depth == 0 ? orderOf(responses[i].response) : orderOfScore(corner.score), i);
    }
    ranked.findRepresentatives();
    if (depth > 0)
        findStrengths(scratch);
    scratch.usable.clear();
    if (!level->mask.empty())
    {
        const int side = 1 << depth;
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
    ranked.rank(rule.rank, depth == 0 ? 1 : 4, scratch.usable, enough);
}

// The strength is the fourth power of FAST * sqrt(sqrt(Harris)) * moment, so that no root is needed. A corner whose moment
// is long has a well-defined direction, and is found again with the same direction.
void LevelDetection::findStrengths(DetectionScratch& scratch)
{
    const std::vector<unsigned>& best = ranked.representatives();
    scratch.corners.resize(best.size());
    scratch.patches.resize(best.size());
    scratch.moments.resize(best.size());
    for (size_t i = 0; i < best.size(); i++)
    {
        const Corner& corner = scratch.corners[i] = found.kept[best[i]];
        const FeaturePoint patch = {corner.x, corner.y, 0};
        scratch.patches[i] = patch;
    }
    patchMoments(level->image, *rules.strengthPatch, scratch.patches.data(), best.size(),
                 scratch.moments.data());
    respond(scratch.corners, scratch.ranked);
    for (size_t i = 0; i < best.size(); i++)
    {
        const float score = float(scratch.corners[i].score), fast = score * score;
        const float response = scratch.ranked[i].response;
        const float harris = rules.rankByHarris ? std::max(response, 0.f) : 1.f;
        const int64 m10 = scratch.moments[i].m10, m01 = scratch.moments[i].m01;
        const float moment = float(uint64(m10 * m10) + uint64(m01 * m01)) * (1.f / 4294967296.f);
        ranked.strength(i) = (fast * fast * harris) * (moment * moment);
        ranked.response(i) = response;
    }
}

LeafPoint LevelDetection::point(size_t index) const
{
    const Corner& corner = found.kept[index];
    const LeafPoint point = {0, responses.empty() ? float(corner.score) : responses[index].response,
                             float(corner.x), float(corner.y), int(index)};
    return point;
}

unsigned LevelDetection::leaf(const LeafPoint& point) const
{
    return leafColumn(int(((int64(point.x) - root.x) << depth) / root.width)) +
           leafRow(int(((int64(point.y) - root.y) << depth) / root.height), depth);
}

float LevelDetection::response(const LeafPoint& point) const
{
    if (!responses.empty() || !rules.rankByHarris)
        return point.response;
    RankedCorner ofPoint;
    respond(&found.kept[point.index], 1, &ofPoint);
    return ofPoint.response;
}

PointSequence& LevelDetection::sequence(const OrderRule& rule, DetectionScratch& scratch)
{
    if (!isOrdered)
    {
        for (int i = 0; i < bandCount; i++)
            searchBand(i, scratch);
        order(rule, scratch);
    }
    if (!rule.isRanked)
        return balanced;
    ruleInUse = &rule;
    scratchInUse = &scratch;
    return *this;
}

bool LevelDetection::next(LeafPoint& point, const PointFilter* filter)
{
    if (ranked.next(point, filter))
        return true;
    if (!ranked.endsEarly())
        return false;
    const size_t passed = ranked.passed();
    orderByRank(*ruleInUse, *scratchInUse, SIZE_MAX);
    ranked.goOnAfter(passed);
    return ranked.next(point, filter);
}

void LevelDetection::list(CornerSet set, DetectionScratch& scratch, std::vector<RankedCorner>& listed)
{
    if (set != KEPT_CORNERS && !found.isComplete)
    {
        // It did not look as if they would be asked for.
        found.clear();
        const CornerRules everything = {rules.thresholds, rules.cellSize, rules.rankByHarris, 0};
        scratch.search.find(*level, root, everything, 0, 0, found);
    }
    respond(set == KEPT_CORNERS         ? found.kept
            : set == SUPPRESSED_CORNERS ? found.suppressed
                                        : found.weak,
            listed);
}

// The responses of corners.
void LevelDetection::respond(const Corner* corners, size_t count, RankedCorner* responding) const
{
    if (rules.rankByHarris)
        return harrisResponses(level->image, corners, count, responding);
    for (size_t i = 0; i < count; i++)
    {
        const RankedCorner corner = {corners[i].x, corners[i].y, float(corners[i].score)};
        responding[i] = corner;
    }
}

void LevelDetection::respond(const std::vector<Corner>& corners, std::vector<RankedCorner>& responding) const
{
    responding.resize(corners.size());
    respond(corners.data(), corners.size(), responding.data());
}

}  // namespace stages
}  // namespace aqorb
}  // namespace cv
