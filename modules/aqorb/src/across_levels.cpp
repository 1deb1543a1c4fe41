// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// The rule by which corners become keypoints, in the order of doc/selection.md: its points 1 and 7 to 9, over all
// levels.

#include "precomp.hpp"

#include "selection.hpp"

namespace cv
{
namespace aqorb
{

// ---- 1. quotas --------------------------------------------------------------------------------

void takeExcess(int64 excess, std::vector<int>& quotas)
{
    for (size_t level = 0; excess > 0; level++)
    {
        const int taken = int(std::min<int64>(excess, quotas[level]));
        quotas[level] -= taken;
        excess -= taken;
    }
}

std::vector<int> rankedQuotas(int nfeatures, const std::vector<Size>& regions,
                              const std::vector<float>& scales)
{
    std::vector<double> shares;
    for (size_t level = 0; level < regions.size(); level++)
    {
        const double scale = scales[level], area = double(regions[level].width) * regions[level].height;
        shares.push_back((level == 0 ? 1.5 : 1.) * area * (scale * std::sqrt(std::sqrt(scale))));
    }
    const double whole = std::accumulate(shares.begin(), shares.end(), 0.);
    std::vector<int> quotas(regions.size());
    int64 rest = nfeatures;
    for (size_t level = 1; level < regions.size(); level++)
    {
        quotas[level] = cvRound(nfeatures * (shares[level] / whole));
        rest -= quotas[level];
    }
    if (!quotas.empty())
        quotas[0] = int(std::max<int64>(rest, 0));
    takeExcess(-rest, quotas);  // where many levels round up
    return quotas;
}

// The share of the region that the mask does not exclude. Rows are counted one by one, because countNonZero counts by
// int.
static double usableShare(const Mat& mask, const Rect& region)
{
    double usable = 0;
    for (int y = region.y; y < region.y + region.height && !mask.empty(); y++)
        usable += countNonZero(mask.row(y).colRange(region.x, region.x + region.width));
    return mask.empty() ? 1 : usable / (double(region.width) * region.height);
}

std::vector<LevelPlan> planLevels(const Parameters& parameters, const std::vector<Level>& levels)
{
    const bool isRanked = parameters.selectionType == AdaptiveQuadtreeORB::RANKED_SELECTION;
    std::vector<Size> regions;
    std::vector<float> scales;
    for (const Level& level : levels)
    {
        regions.push_back(parameters.keypointRegion(level.image.size()).size());
        scales.push_back(level.scale);
    }
    const std::vector<int> quotas =
        isRanked ? rankedQuotas(parameters.nfeatures, regions, scales)
                 : balancedQuotas(parameters.nfeatures, parameters.scaleFactor, parameters.nlevels);
    std::vector<LevelPlan> plans;
    for (size_t i = 0; i < levels.size(); i++)
    {
        LevelPlan plan;
        plan.root = parameters.keypointRegion(levels[i].image.size());
        plan.usable = usableShare(levels[i].mask, plan.root);
        plan.quota = quotas[i];
        plan.depth = isRanked ? rankedDepth(regions[i], plan.usable, std::max(quotas[i], 1))
                              : balancedDepth(quotas[i]);
        plans.push_back(plan);
    }
    // The paper's quotas include those of levels too small for a keypoint, which go to the last level that is not.
    if (!plans.empty())
        plans.back().quota = std::accumulate(quotas.begin() + plans.size() - 1, quotas.end(), 0);
    return plans;
}

// ---- 7. across levels -------------------------------------------------------------------------

namespace
{

class Selector
{
public:
    Selector(const Parameters& parameters_, Size imageSize_, const std::vector<Level>& levels_,
             std::vector<uchar>& marks_)
        : selected(levels_.size()),
          parameters(parameters_),
          imageSize(imageSize_),
          levels(levels_),
          next(levels_.size()),
          marks(marks_)
    {
    }
    //! Takes corners of a level from where it stopped before. Returns how many are still wanted.
    int take(int level, int wanted, const LevelOrder& order);
    //! Leaves out the corners near keypoints of other levels.
    void dropNear(int level, std::vector<CornerResponse>& corners);
    Selected selected;

private:
    void markNear(int level);
    bool isMarked(int level, const CornerResponse& corner) const
    {
        const size_t pixel = size_t(corner.y) * levels[level].image.cols + corner.x;
        return (marks[pixel / 8] >> (pixel % 8) & 1) != 0;
    }

    const Parameters& parameters;
    const Size imageSize;
    const std::vector<Level>& levels;
    std::vector<size_t> next;   // by level: the corner of its order that is to be looked at next
    std::vector<uchar>& marks;  // a bit by pixel of a level: whether it is near a keypoint of another level
};

// The exact positions in the image of the pixels of a level along one axis: by pixel centres, so that positions on
// coarse levels are not shifted against those on fine ones.
std::vector<double> exactPositions(int imageLength, int length)
{
    std::vector<double> positions(length);
    for (int i = 0; i < length; i++)
        positions[i] = (i + 0.5) * imageLength / length - 0.5;
    return positions;
}

// The distance in pixels for which octaveSuppression stands.
double octaveDistance(const Parameters& parameters)
{
    if (parameters.octaveSuppression >= 0)
        return parameters.octaveSuppression;
    // A user who asks for the strongest corners gets them on every level, as from cv::ORB.
    return parameters.selectionType == AdaptiveQuadtreeORB::BALANCED_SELECTION
               ? 0.5
               : 2.1 / (1 + parameters.strengthWeight);
}

// Marks the pixels of a level that are near keypoints of other levels: with RANKED_SELECTION of its neighbours.
void Selector::markNear(int level)
{
    const bool isRanked = parameters.selectionType == AdaptiveQuadtreeORB::RANKED_SELECTION;
    const int reach = isRanked ? 1 : int(levels.size()), count = int(levels.size());
    const Size size = levels[level].image.size();
    const double radius = octaveDistance(parameters) * levels[level].scale;
    const double toX = double(size.width) / imageSize.width, toY = double(size.height) / imageSize.height;
    const std::vector<double> xs = exactPositions(imageSize.width, size.width),
                              ys = exactPositions(imageSize.height, size.height);
    marks.assign(size_t(size.width) * size.height / 8 + 1, uchar(0));
    for (int i = std::max(level - reach, 0); radius > 0 && i <= std::min(level + reach, count - 1); i++)
    {
        const Size other = levels[i].image.size();
        for (size_t j = 0; i != level && j < selected[i].size(); j++)
        {
            const double x = (selected[i][j].x + 0.5) * imageSize.width / other.width - 0.5,
                         y = (selected[i][j].y + 0.5) * imageSize.height / other.height - 0.5;
            const int left = int(std::max((x - radius + 0.5) * toX - 1, 0.)),
                      top = int(std::max((y - radius + 0.5) * toY - 1, 0.));
            const int right = int(std::min((x + radius + 0.5) * toX, size.width - 1.)),
                      bottom = int(std::min((y + radius + 0.5) * toY, size.height - 1.));
            for (int row = top; row <= bottom; row++)
            {
                const double dy2 = (ys[row] - y) * (ys[row] - y);
                for (int column = left; column <= right; column++)
                {
                    const size_t pixel = size_t(row) * size.width + column;
                    const int isNear = (xs[column] - x) * (xs[column] - x) + dy2 < radius * radius;
                    marks[pixel / 8] = uchar(marks[pixel / 8] | isNear << (pixel % 8));
                }
            }
        }
    }
}

void Selector::dropNear(int level, std::vector<CornerResponse>& corners)
{
    markNear(level);
    const auto isNear = [&](const CornerResponse& corner) { return isMarked(level, corner); };
    corners.erase(std::remove_if(corners.begin(), corners.end(), isNear), corners.end());
}

int Selector::take(int level, int wanted, const LevelOrder& order)
{
    if (wanted > 0)
        markNear(level);
    for (size_t& i = next[level]; wanted > 0 && i < order.corners.size(); i++)
    {
        const CornerResponse& corner = order.corners[i];
        if (isMarked(level, corner))
            continue;
        selected[level].push_back(corner);
        wanted--;
    }
    return wanted;
}

}  // namespace

Selected selectAcrossLevels(const Parameters& parameters, Size imageSize, const std::vector<Level>& levels,
                            const std::vector<LevelPlan>& plans,
                            const std::vector<std::vector<Corner>>& corners, std::vector<LevelOrder>& orders,
                            std::vector<uchar>& marks)
{
    CV_TRACE_FUNCTION();
    const int count = int(levels.size());
    Selector selector(parameters, imageSize, levels, marks);
    int wanted = 0;
    std::vector<uchar> hasBegun(levels.size());
    const auto take = [&](int level)
    {
        // For the paper's order a corner near a keypoint of another level does not exist.
        if (wanted > 0 && !hasBegun[level] &&
            parameters.selectionType == AdaptiveQuadtreeORB::BALANCED_SELECTION)
        {
            selector.dropNear(level, orders[level].corners);
            balance(plans[level], orders[level].corners);
            hasBegun[level] = 1;
        }
        wanted = selector.take(level, wanted, orders[level]);
        // The corners that are no representatives are put in order when they are needed, which is seldom.
        if (wanted == 0 || orders[level].indices.size() == corners[level].size())
            return;
        appendOthers(parameters, levels[level], plans[level], corners[level], orders[level]);
        wanted = selector.take(level, wanted, orders[level]);
    };
    for (int i = count - 1; i >= 0; i--)
    {
        wanted += plans[i].quota;
        take(i);
    }
    for (int i = 0; i < count; i++)
        take(i);
    return std::move(selector.selected);
}

// ---- 8. when corners run out ------------------------------------------------------------------

void fillUp(const std::vector<std::vector<CornerResponse>>& corners, size_t missing, Selected& selected)
{
    CV_TRACE_FUNCTION();
    struct Candidate
    {
        size_t level;
        CornerResponse corner;
    };
    std::vector<Candidate> candidates;
    for (size_t i = 0; i < corners.size(); i++)
    {
        std::vector<CornerResponse> taken(selected[i]), left;
        std::sort(taken.begin(), taken.end(), InRasterOrder());
        std::set_difference(corners[i].begin(), corners[i].end(), taken.begin(), taken.end(),
                            std::back_inserter(left), InRasterOrder());
        for (const CornerResponse& corner : left)
            candidates.push_back({i, corner});
    }
    // Of equal responses that of the finer level comes first, and then raster order.
    std::stable_sort(candidates.begin(), candidates.end(),
                     [](const Candidate& a, const Candidate& b)
                     { return a.corner.response > b.corner.response; });
    for (size_t i = 0; i < std::min(missing, candidates.size()); i++)
        selected[candidates[i].level].push_back(candidates[i].corner);
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
