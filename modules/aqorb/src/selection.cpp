// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "precomp.hpp"

#include "selection.hpp"

namespace cv
{
namespace aqorb
{

void FeatureSelector::reset(Size imageSize_, int levelCount_, double octaveSuppression_, int reach_)
{
    imageSize = imageSize_;
    levelCount = levelCount_;
    octaveSuppression = octaveSuppression_;
    reach = reach_;
    wanted = 0;
    while (levels.size() < size_t(levelCount))
        levels.push_back(LevelState());
    for (LevelState& level : levels)
        level.chosen.clear();
}

void FeatureSelector::addLevel(int index, const LevelPlan& plan)
{
    LevelState& level = levels[index];
    level.plan = plan;
    level.next = 0;
    level.hasBegun = level.isExhausted = false;
    wanted += plan.quota;
}

// The exact position in the image, by pixel centres, so that positions on coarse levels are not shifted against those on
// fine ones.
Point2d FeatureSelector::position(int level, const CornerResponse& corner) const
{
    const Size size = levels[level].plan.size;
    return Point2d((corner.x + 0.5) * imageSize.width / size.width - 0.5,
                   (corner.y + 0.5) * imageSize.height / size.height - 0.5);
}

// Lists the keypoints of some levels, but not of the level itself, in the blocks of the level in which they are near a
// pixel. As a rule these blocks are few.
void FeatureSelector::listKeypoints(int level, int first, int last)
{
    const Size size = levels[level].plan.size;
    const double radius = octaveSuppression * levels[level].plan.scale;
    const double toX = double(size.width) / imageSize.width, toY = double(size.height) / imageSize.height;
    const double reachX = radius * toX + 0.01, reachY = radius * toY + 0.01;  // more than what is rounded
    blockShift = 3;  // smaller blocks would cost more to clear than they save
    while (blockShift < 30 && (1 << blockShift) < octaveSuppression)
        blockShift++;
    blockColumns = (size.width >> blockShift) + 1;
    const int blockRows = (size.height >> blockShift) + 1;
    const auto block = [&](double coordinate, int count)
    { return int(std::min(std::max(coordinate, 0.) / (1 << blockShift), count - 1.)); };
    heads.assign(size_t(blockColumns) * blockRows, -1);
    keypoints.clear();
    for (int i = std::max(first, 0); octaveSuppression > 0 && i <= std::min(last, levelCount - 1); i++)
    {
        for (size_t j = 0; i != level && j < levels[i].chosen.size(); j++)
        {
            const Point2d p = position(i, levels[i].chosen[j]);
            const double x = (p.x + 0.5) * toX - 0.5, y = (p.y + 0.5) * toY - 0.5;
            const int right = block(x + reachX, blockColumns), bottom = block(y + reachY, blockRows);
            for (int row = block(y - reachY, blockRows); row <= bottom; row++)
            {
                for (int column = block(x - reachX, blockColumns); column <= right; column++)
                {
                    int& head = heads[size_t(row) * blockColumns + column];
                    keypoints.push_back({p, head});
                    head = int(keypoints.size()) - 1;
                }
            }
        }
    }
}

// Octave suppression.
bool FeatureSelector::isNearKeypoint(int level, const CornerResponse& corner) const
{
    int i = heads[size_t(corner.y >> blockShift) * blockColumns + (corner.x >> blockShift)];
    if (i < 0)
        return false;
    const Point2d p = position(level, corner);
    const double radius = octaveSuppression * levels[level].plan.scale;
    for (; i >= 0; i = keypoints[i].next)
    {
        const Point2d d = keypoints[i].position - p;
        if (d.x * d.x + d.y * d.y < radius * radius)
            return true;
    }
    return false;
}

void FeatureSelector::take(int index, const std::vector<CornerResponse>& corners)
{
    CV_TRACE_FUNCTION();
    LevelState& level = levels[index];
    if (level.isExhausted)
        return;
    const bool isRanked = level.plan.isRanked, again = level.hasBegun && !isRanked;
    // A level that goes on does so in the same order, although finer levels have got keypoints.
    listKeypoints(index, again ? index + 1 : index - reach, index + reach);
    if (!isRanked)
        orderByRule(index, corners, again ? corners.size() : wanted, true);
    if (again)
        listKeypoints(index, index - reach, index + reach);
    level.hasBegun = true;
    for (; wanted > 0 && level.next < (isRanked ? corners.size() : order.size()); level.next++)
    {
        const CornerResponse& corner = corners[isRanked ? level.next : order[level.next]];
        if ((isRanked || again) && isNearKeypoint(index, corner))
            continue;
        level.chosen.push_back(corner);
        wanted--;
    }
    level.isExhausted = !isRanked && wanted > 0;
}

void FeatureSelector::fill(int index, const std::vector<CornerResponse>& corners)
{
    CV_TRACE_FUNCTION();
    LevelState& level = levels[index];
    chosen(index, 0, taken);
    filling.clear();
    std::set_difference(corners.begin(), corners.end(), taken.begin(), taken.end(),
                        std::back_inserter(filling), InRasterOrder());
    if (filling.size() > size_t(wanted))
    {
        orderByRule(index, filling, wanted, false);
        taken.assign(filling.begin(), filling.end());
        for (int i = 0; i < wanted; i++)
            filling[i] = taken[order[i]];
        filling.resize(wanted);
    }
    level.chosen.insert(level.chosen.end(), filling.begin(), filling.end());
    wanted -= int(filling.size());
}

// Finds the order of corners of a level by its rule, with their responses for strengths.
void FeatureSelector::orderByRule(int index, const std::vector<CornerResponse>& corners, size_t count,
                                  bool withSuppression)
{
    const LevelPlan& plan = levels[index].plan;
    leaves.reset(plan.root, plan.depth);
    points.resize(corners.size());
    unsuppressed.resize(corners.size());
    size_t size = 0;
    for (size_t i = 0; i < corners.size(); i++)
    {
        points[size] = {leaves.leaf(corners[i].x, corners[i].y), sortKey(corners[i].response)};
        unsuppressed[size] = unsigned(i);
        size += !withSuppression || !isNearKeypoint(index, corners[i]);
    }
    points.resize(size);
    if (plan.isRanked)
        rankedOrder(points, plan.depth, plan.rankRule, rankedScratch, order);
    else
        balancedOrder(points, plan.depth, count, balancedScratch, order);
    for (unsigned& i : order)
        i = unsuppressed[i];
}

void FeatureSelector::chosen(int index, size_t first, std::vector<CornerResponse>& corners)
{
    const LevelState& level = levels[index];
    rasterKeys.clear();
    for (size_t i = first; i < level.chosen.size(); i++)
        rasterKeys.push_back(uint64(level.chosen[i].y) * level.plan.size.width + level.chosen[i].x);
    sortIndices(rasterKeys, sorting, order);
    corners.resize(rasterKeys.size());
    for (size_t i = 0; i < corners.size(); i++)
        corners[i] = level.chosen[first + order[i]];
}

}  // namespace aqorb
}  // namespace cv
