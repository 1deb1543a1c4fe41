// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "precomp.hpp"

#include "plan.hpp"

namespace cv
{
namespace aqorb
{

using namespace stages;

int shortestSide(const Parameters& parameters)
{
    const int FAST_RADIUS = 3;
    return int(std::min(2 * std::max<int64>(parameters.edgeThreshold, FAST_RADIUS) + 1, int64(INT_MAX)));
}

SelectionLevel planLevel(const Parameters& parameters, const Level& level, int quota, int added)
{
    const int border = parameters.edgeThreshold;
    SelectionLevel planned;
    planned.size = level.image.size();
    planned.scale = level.scale;
    planned.quota = quota + added;
    planned.order.root =
        Rect(border, border, planned.size.width - 2 * border, planned.size.height - 2 * border);
    planned.order.depth = parameters.maxDepth >= 0 ? parameters.maxDepth : quadtreeDepth(quota);
    planned.order.isRanked = parameters.selectionType == AdaptiveQuadtreeORB::RANKED_SELECTION;
    planned.order.rank = RankRule();
    return planned;
}

void planOrder(const Parameters& parameters, const Mat& mask, SelectionLevel& planned)
{
    OrderRule& order = planned.order;
    if (!order.isRanked)
        return;
    const Size size = order.root.size();
    const double usable =
        mask.empty() ? 1 : countNonZero(mask(order.root)) / (double(size.width) * size.height);
    const RankRule rule = {size, usable, std::max(planned.quota, 1), parameters.rankRadius,
                           parameters.strengthWeight};
    order.rank = rule;
    order.depth = parameters.maxDepth >= 0 ? std::min(parameters.maxDepth, maxRankedDepth(size))
                                           : rankedDepth(size, usable, rule.quota);
}

}  // namespace aqorb
}  // namespace cv
