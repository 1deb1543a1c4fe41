// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// The rule by which corners become keypoints, in the order of doc/selection.md: its points 7 to 9, over all levels.

#include "precomp.hpp"

#include "selection.hpp"

namespace cv
{
namespace aqorb
{

// ---- 7. across levels -------------------------------------------------------------------------

// The distance in pixels for which octaveSuppression stands.
static double octaveDistance(const Parameters& parameters)
{
    if (parameters.octaveSuppression >= 0)
        return parameters.octaveSuppression;
    // A user who asks for the strongest corners gets them on every level, as from cv::ORB.
    return parameters.selectionType == AdaptiveQuadtreeORB::BALANCED_SELECTION
               ? 0.5
               : 2.1 / (1 + parameters.strengthWeight);
}

// Where the pixel of a corner is in the image: by pixel centres, so that positions on coarse levels are not shifted
// against those on fine ones.
static Point2d positionInImage(const CornerResponse& corner, Size level, Size image)
{
    return Point2d((corner.x + 0.5) * image.width / level.width - 0.5,
                   (corner.y + 0.5) * image.height / level.height - 0.5);
}

namespace
{

// Points of the image in square cells, each of which is a list.
class PointGrid
{
public:
    PointGrid(Size image, double side_)
        : side(std::max(side_, 16.)),
          columns(indexOf(image.width) + 1),
          latest(size_t(columns) * (indexOf(image.height) + 1), -1)
    {
    }
    void add(const Point2d& p)
    {
        int& ofCell = latest[size_t(indexOf(p.y)) * columns + indexOf(p.x)];
        points.push_back(p);
        before.push_back(ofCell);
        ofCell = int(points.size()) - 1;
    }
    //! Whether a point is nearer than the radius.
    bool isNear(const Point2d& p, double radius) const
    {
        if (points.empty() || radius == 0)
            return false;
        const int right = std::min(indexOf(p.x + radius), columns - 1),
                  bottom = std::min(indexOf(p.y + radius), int(latest.size()) / columns - 1);
        for (int row = indexOf(p.y - radius); row <= bottom; row++)
            for (int column = indexOf(p.x - radius); column <= right; column++)
                for (int i = latest[size_t(row) * columns + column]; i >= 0; i = before[i])
                {
                    const Point2d d = points[i] - p;
                    if (d.dot(d) < radius * radius)
                        return true;
                }
        return false;
    }

private:
    int indexOf(double position) const { return int(std::max(position, 0.) / side); }

    const double side;  // of a cell
    const int columns;
    std::vector<Point2d> points;
    std::vector<int> latest, before;  // the last point of a cell, and the one before a point; -1: none
};

// Knows which corners are far enough from those that were selected on other levels.
class OctaveSuppression
{
public:
    OctaveSuppression(const Parameters& parameters, Size imageSize_, const std::vector<Level>& levels_)
        : imageSize(imageSize_),
          levels(levels_),
          count(int(levels.size())),
          reach(parameters.selectionType == AdaptiveQuadtreeORB::RANKED_SELECTION ? 1 : count)
    {
        // No two points are as far apart as the limit, which keeps the distance finite.
        const double limit = double(imageSize.width) + imageSize.height;
        for (const Level& level : levels)
        {
            distances.push_back(std::min(octaveDistance(parameters) * level.scale, limit));
            selected.push_back(PointGrid(imageSize, distances.back()));
        }
    }
    void add(int level, const CornerResponse& corner) { selected[level].add(positionOf(level, corner)); }
    //! Whether a corner keeps its distance, which is counted in pixels of its own level.
    bool allows(int level, const CornerResponse& corner) const
    {
        const Point2d p = positionOf(level, corner);
        for (int i = std::max(level - reach, 0); i <= std::min(level + reach, count - 1); i++)
            if (i != level && selected[i].isNear(p, distances[level]))
                return false;
        return true;
    }

private:
    Point2d positionOf(int level, const CornerResponse& corner) const
    {
        return positionInImage(corner, levels[level].image.size(), imageSize);
    }

    const Size imageSize;
    const std::vector<Level>& levels;
    const int count, reach;  // of levels
    std::vector<double> distances;
    std::vector<PointGrid> selected;
};

}  // namespace

CornersOfLevels selectAcrossLevels(const Parameters& parameters, Size imageSize,
                                   const std::vector<Level>& levels, const std::vector<LevelPlan>& plans,
                                   const CornersOfLevels& orders)
{
    CV_TRACE_FUNCTION();
    const int count = int(levels.size());
    OctaveSuppression suppression(parameters, imageSize, levels);
    CornersOfLevels selected(levels.size());
    std::vector<size_t> next(levels.size());  // by level: which corner of its order comes next
    int wanted = 0;
    const auto take = [&](int level)
    {
        for (size_t& i = next[level]; wanted > 0 && i < orders[level].size(); i++)
        {
            const CornerResponse& corner = orders[level][i];
            if (!suppression.allows(level, corner))
                continue;
            suppression.add(level, corner);
            selected[level].push_back(corner);
            wanted--;
        }
    };
    for (int i = count - 1; i >= 0; i--)
    {
        wanted += plans[i].quota;
        take(i);
    }
    for (int i = 0; i < count && wanted > 0; i++)
        take(i);
    return selected;
}

// ---- 8. when representatives run out ----------------------------------------------------------

void fillUp(const Parameters& parameters, Size imageSize, const std::vector<Level>& levels,
            const CornersOfLevels& corners, size_t missing, CornersOfLevels& selected)
{
    CV_TRACE_FUNCTION();
    struct Candidate
    {
        int level;
        CornerResponse corner;
        bool isTaken;
    };
    OctaveSuppression suppression(parameters, imageSize, levels);
    std::vector<Candidate> candidates;
    std::vector<uint64> keys;
    for (int i = 0; i < int(corners.size()); i++)
    {
        for (const CornerResponse& corner : selected[i])
            suppression.add(i, corner);
        std::vector<CornerResponse> taken(selected[i]), left;
        std::sort(taken.begin(), taken.end(), InRasterOrder());
        std::set_difference(corners[i].begin(), corners[i].end(), taken.begin(), taken.end(),
                            std::back_inserter(left), InRasterOrder());
        for (const CornerResponse& corner : left)
        {
            candidates.push_back({i, corner, false});
            keys.push_back(descendingKey(sortKey(corner.response * levels[i].scale)));
        }
    }
    // Of equal ones that of the finer level comes first, and then raster order.
    const std::vector<unsigned> order = sortIndices(keys);
    for (const bool withSuppression : {true, false})
    {
        for (size_t i = 0; i < order.size() && missing > 0; i++)
        {
            Candidate& candidate = candidates[order[i]];
            if (withSuppression ? !suppression.allows(candidate.level, candidate.corner) : candidate.isTaken)
                continue;
            candidate.isTaken = true;
            suppression.add(candidate.level, candidate.corner);
            selected[candidate.level].push_back(candidate.corner);
            missing--;
        }
    }
}

// ---- 9. order of output -----------------------------------------------------------------------

FeatureList listFeatures(const Parameters& parameters, const Level& level, int octave,
                         const std::vector<CornerResponse>& selected)
{
    const bool isRanked = parameters.selectionType == AdaptiveQuadtreeORB::RANKED_SELECTION;
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
        list.outputKeys.push_back(isRanked ? descendingKey(sortKey(corner.response)) : 0);
    }
    return list;
}

}  // namespace aqorb
}  // namespace cv
