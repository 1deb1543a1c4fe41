// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// Selection of keypoints from corners, points 7 to 9 of doc/selection.md: the method, and selection over all levels.

#include "precomp.hpp"

#include "common/for_each.hpp"
#include "common/simd_compat.hpp"
#include "detector/position.hpp"
#include "detector/quadtree.hpp"
#include "detector/selection.hpp"

namespace cv
{
namespace aqorb
{

// ---- the method ------------------------------------------------------------------------------

SelectionMethod selectionMethod(const Parameters& parameters)
{
    if (parameters.selectionType == AdaptiveQuadtreeORB::QUADTREE_SELECTION)
        return {true, false, false, 0};
    // Harris responses of neighbouring pixels hardly differ: without suppression a strong corner would be chosen three
    // times. A high strengthWeight lowers the distance, so strong corners are chosen on every level, as by cv::ORB.
    const double distance = parameters.octaveSuppression >= 0 ? parameters.octaveSuppression
                                                              : 2.1 / (1 + parameters.strengthWeight);
    return {false, parameters.useHarris(), parameters.subPixel, distance};
}

// Orders the candidates among the corners of a level, the best first.
static std::vector<CornerResponse> orderCorners(const Parameters& parameters, const SelectionMethod& method,
                                                const OrientationPatch& patch, const LevelPlan& plan,
                                                const Level& level, const std::vector<Corner>& corners)
{
    if (!method.isQuadtree)
        return rankedOrder(parameters, patch, plan, level, corners);
    return quadtreeOrder(responsesOf(level.image, corners, parameters.useHarris()), plan.region,
                         quadtreeDepth(plan.quota), plan.quota);
}

// ---- 7. across levels -------------------------------------------------------------------------

namespace
{

// Points of the image, listed by square cells.
class PointGrid
{
public:
    //! @param radius typical radius of isNear
    PointGrid(Size image, double radius)
        : side(std::max(radius / 4, 16.)),
          columns(indexOf(image.width) + 1),
          latest(size_t(columns) * (indexOf(image.height) + 1), -1)
    {
    }
    void add(const Point2d& p)
    {
        int& cell = latest[size_t(indexOf(p.y)) * columns + indexOf(p.x)];
        points.push_back(p);
        before.push_back(cell);
        cell = int(points.size()) - 1;
    }
    //! Whether a point of the grid is nearer than the radius.
    bool isNear(const Point2d& p, double radius) const
    {
        const auto hasNear = [&](int column, int row)
        {
            for (int i = latest[size_t(row) * columns + column]; i >= 0; i = before[i])
            {
                const Point2d d = points[i] - p;
                if (d.dot(d) < radius * radius)
                    return true;
            }
            return false;
        };
        // Where points are dense, the cell of p itself decides.
        if (hasNear(indexOf(p.x), indexOf(p.y)))
            return true;
        const int right = std::min(indexOf(p.x + radius), columns - 1),
                  bottom = std::min(indexOf(p.y + radius), int(latest.size()) / columns - 1);
        for (int row = indexOf(p.y - radius); row <= bottom; row++)
            for (int column = indexOf(p.x - radius); column <= right; column++)
                if (hasNear(column, row))
                    return true;
        return false;
    }

private:
    int indexOf(double position) const { return int(std::max(position, 0.) / side); }

    const double side;  // side of a cell
    const int columns;
    std::vector<Point2d> points;
    std::vector<int> latest, before;  // last point of each cell, and the point before each point; -1: none
};

// Distance of corners from the selected corners of neighbouring levels.
class OctaveSuppression
{
public:
    OctaveSuppression(double distance, Size imageSize_, const std::vector<Level>& levels_)
        : imageSize(imageSize_), levels(levels_)
    {
        // Keeps the distance finite: no two points of the image are as far apart as the limit.
        const double limit = double(imageSize.width) + imageSize.height;
        for (const Level& level : levels)
        {
            distances.push_back(std::min(distance * level.scale, limit));
            selected.push_back(PointGrid(imageSize, distances.back()));
        }
    }
    void add(int level, const CornerResponse& corner) { selected[level].add(positionOf(level, corner)); }
    //! Whether a corner keeps the distance, in pixels of its own level.
    bool allows(int level, const CornerResponse& corner) const
    {
        const Point2d p = positionOf(level, corner);
        const auto isNear = [&](int other)
        { return other >= 0 && other < int(levels.size()) && selected[other].isNear(p, distances[level]); };
        return !isNear(level - 1) && !isNear(level + 1);
    }

private:
    Point2d positionOf(int level, const CornerResponse& corner) const
    {
        return scaleByCenters(corner.x, corner.y, levels[level].image.size(), imageSize);
    }

    const Size imageSize;
    const std::vector<Level>& levels;
    std::vector<double> distances;
    std::vector<PointGrid> selected;
};

}  // namespace

// Corners by level.
typedef std::vector<std::vector<CornerResponse>> LevelCorners;

static std::vector<LevelPlan> planLevels(const Parameters& parameters, const SelectionMethod& method,
                                         const std::vector<Rect>& regions, const std::vector<Level>& levels)
{
    std::vector<Size> sizes;
    std::vector<float> scales;
    std::vector<LevelPlan> plan;
    for (size_t i = 0; i < levels.size(); i++)
    {
        sizes.push_back(regions[i].size());
        scales.push_back(levels[i].scale);
    }
    const std::vector<int> quotas =
        method.isQuadtree ? quadtreeQuotas(parameters.nfeatures, parameters.scaleFactor, parameters.nlevels)
                          : rankedQuotas(parameters.nfeatures, sizes, scales);
    for (size_t i = 0; i < levels.size(); i++)
        plan.push_back({regions[i], quotas[i]});
    // The paper also gives quotas to levels too small for a keypoint. The last usable level takes these.
    for (size_t i = levels.size(); i < quotas.size() && !plan.empty(); i++)
        plan.back().quota += quotas[i];
    return plan;
}

static LevelCorners selectAcrossLevels(const std::vector<LevelPlan>& plan, const LevelCorners& ordered,
                                       OctaveSuppression& suppression)
{
    CV_TRACE_FUNCTION();
    const int count = int(plan.size());
    LevelCorners selected(plan.size());
    std::vector<size_t> next(plan.size());  // by level: index of the next corner
    int wanted = 0;
    const auto take = [&](int level)
    {
        for (size_t& i = next[level]; wanted > 0 && i < ordered[level].size(); i++)
        {
            const CornerResponse& corner = ordered[level][i];
            if (!suppression.allows(level, corner))
                continue;
            suppression.add(level, corner);
            selected[level].push_back(corner);
            wanted--;
        }
    };
    for (int i = count - 1; i >= 0; i--)
    {
        wanted += plan[i].quota;
        take(i);
    }
    for (int i = 0; i < count && wanted > 0; i++)
        take(i);
    return selected;
}

// ---- 8. when representatives run out ----------------------------------------------------------

// Lists the corners of the blocks of a level that are not taken.
// @param taken corners of these blocks
static std::vector<CornerResponse> otherCorners(const Mat& image, const std::vector<CornerBlock>& blocks,
                                                std::vector<CornerResponse> taken, bool useHarris)
{
    const auto fastScore = [&](int x, int y)
    {
        int scores[3][3];
        cornerScores3x3(image, x, y, scores);
        return scores[1][1] - 1;
    };
    std::sort(taken.begin(), taken.end(), InRasterOrder());
    std::vector<Corner> others;
    auto next = taken.begin();
    for (const CornerBlock& block : blocks)
    {
        for (uint64 columns = block.columns; columns; columns &= columns - 1)
        {
            const int x = block.x + trailingZeros(columns), y = block.y;
            if (next != taken.end() && next->x == x && next->y == y)
                ++next;
            else
                others.push_back({x, y, useHarris ? 0 : fastScore(x, y)});
        }
    }
    return responsesOf(image, others, useHarris);
}

// Adds `missing` other corners, the highest response times scale first. Levels below their quota go first, and corners
// near a keypoint of another level last.
static void fillUp(const std::vector<LevelPlan>& plan, const std::vector<Level>& levels,
                   const LevelCorners& corners, size_t missing, OctaveSuppression& suppression,
                   LevelCorners& selected)
{
    CV_TRACE_FUNCTION();
    struct Candidate
    {
        int level;
        CornerResponse corner;
        bool isTaken, isNear;
    };
    std::vector<Candidate> candidates;
    std::vector<uint64> keys;
    for (int i = 0; i < int(corners.size()); i++)
    {
        for (const CornerResponse& corner : corners[i])
        {
            candidates.push_back({i, corner, false, false});
            keys.push_back(descendingKey(sortKey(corner.response * levels[i].scale)));
        }
    }
    // Ties go to the finer level, then to raster order.
    const std::vector<unsigned> order = sortIndices(keys);
    struct Rules
    {
        bool quota, distance;
    };
    for (const Rules& rules : {Rules{true, true}, Rules{false, true}, Rules{false, false}})
    {
        for (size_t i = 0; i < order.size() && missing > 0; i++)
        {
            Candidate& candidate = candidates[order[i]];
            const int level = candidate.level;
            if (candidate.isTaken || (rules.distance && candidate.isNear) ||
                (rules.quota && selected[level].size() >= size_t(plan[level].quota)))
                continue;
            // A corner near a keypoint stays near.
            candidate.isNear = rules.distance && !suppression.allows(level, candidate.corner);
            if (candidate.isNear)
                continue;
            candidate.isTaken = true;
            suppression.add(level, candidate.corner);
            selected[level].push_back(candidate.corner);
            missing--;
        }
    }
}

// Selects the corners of all levels that become keypoints.
static LevelCorners selectCorners(const Parameters& parameters, const OrientationPatch& patch, Size imageSize,
                                  const std::vector<Level>& levels, const Thresholds& thresholds, int threads,
                                  CornerSpace& space)
{
    const SelectionMethod method = selectionMethod(parameters);
    std::vector<Rect> regions;
    for (const Level& level : levels)
        regions.push_back(parameters.keypointRegion(level.image.size()));
    const std::vector<LevelPlan> plan = planLevels(parameters, method, regions, levels);
    LevelCorners corners(levels.size());
    // Blocks to list for each feature. Photographs whose ordered corners run out have fewer corners.
    const int64 LISTED = 8;
    std::atomic<int64> room(LISTED * parameters.nfeatures);
    const CornerRules rules = {thresholds, method.suppressNear, &room};
    findCorners(levels, regions, rules, threads, space);
    forEach(levels.size(), threads,
            [&](size_t i, int) {
                corners[i] =
                    orderCorners(parameters, method, patch, plan[i], levels[i], space.levels[i].chosen);
            });
    OctaveSuppression suppression(method.octaveDistance, imageSize, levels);
    LevelCorners selected = selectAcrossLevels(plan, corners, suppression);
    size_t missing = size_t(parameters.nfeatures);
    for (const std::vector<CornerResponse>& level : selected)
        missing -= level.size();
    if (missing == 0)
        return selected;

    // The ordered corners do not suffice: other corners fill up. A search that had no room to list these is repeated.
    if (room < 0)
    {
        room = INT64_MAX;
        findCorners(levels, regions, rules, threads, space);
    }
    forEach(levels.size(), threads,
            [&](size_t i, int) {
                corners[i] =
                    otherCorners(levels[i].image, space.levels[i].all, selected[i], parameters.useHarris());
            });
    fillUp(plan, levels, corners, missing, suppression, selected);
    return selected;
}

// ---- 9. order of output -----------------------------------------------------------------------

// Lists the features of a level in raster order.
static FeatureList listFeatures(const Parameters& parameters, const Level& level, int octave,
                                const std::vector<CornerResponse>& selected)
{
    std::vector<uint64> rasterKeys;
    for (const CornerResponse& corner : selected)
        rasterKeys.push_back(uint64(corner.y) * level.image.cols + corner.x);
    FeatureList list;
    for (unsigned i : sortIndices(rasterKeys))
    {
        const CornerResponse& corner = selected[i];
        list.points.push_back({corner.x, corner.y, 0});
        list.keypoints.push_back(
            KeyPoint(Point2f(), parameters.patchSize * level.scale, -1, corner.response, octave));
        list.outputKeys.push_back(descendingKey(sortKey(corner.response)));
    }
    return list;
}

std::vector<FeatureList> selectFeatures(const Parameters& parameters, const OrientationPatch& patch,
                                        Size imageSize, const std::vector<Level>& levels,
                                        const Thresholds& thresholds, int threads, CornerSpace& space)
{
    const LevelCorners selected =
        selectCorners(parameters, patch, imageSize, levels, thresholds, threads, space);
    std::vector<FeatureList> features(levels.size());
    forEach(levels.size(), threads,
            [&](size_t i, int) { features[i] = listFeatures(parameters, levels[i], int(i), selected[i]); });
    return features;
}

}  // namespace aqorb
}  // namespace cv
