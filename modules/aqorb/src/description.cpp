// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "precomp.hpp"

#include "description.hpp"

namespace cv
{
namespace aqorb
{

std::vector<FeatureRange> divideIntoRanges(const std::vector<FeatureList>& features, int threads)
{
    const size_t LEAST = 64;
    size_t all = 0;
    for (const FeatureList& list : features)
        all += list.points.size();
    const size_t most = threads == 1 ? all + 1 : std::max(all / (4 * threads), LEAST);
    std::vector<FeatureRange> ranges;
    for (size_t level = 0; level < features.size(); level++)
    {
        const size_t count = features[level].points.size(), parts = (count + most - 1) / most;
        for (size_t i = 0; i < parts; i++)
            ranges.push_back({int(level), Range(int(count * i / parts), int(count * (i + 1) / parts))});
    }
    return ranges;
}

// Finds the directions of features and completes their keypoints.
static void findKeypoints(const Level& level, const DescriptionRules& rules, size_t begin, size_t end,
                          FeatureList& list)
{
    CV_TRACE_FUNCTION();
    const Mat &image = level.image, &mask = *rules.imageMask;
    const bool subPixel = rules.position.subPixel;
    orientations(image, *rules.patch, &list.points[begin], end - begin);
    // Step by step for some features at a time: within a step they do not depend on each other.
    const size_t AT_ONCE = 64;
    for (size_t first = begin; first < end; first += AT_ONCE)
    {
        const size_t some = std::min(end - first, AT_ONCE);
        Point2d offsets[AT_ONCE];
        for (size_t i = 0; i < some && subPixel; i++)
            offsets[i] = subPixelOffset(image, list.points[first + i].x, list.points[first + i].y);
        for (size_t i = 0; i < some; i++)
        {
            const FeaturePoint& point = list.points[first + i];
            KeyPoint& keypoint = list.keypoints[first + i];
            keypoint.pt = rules.position(point.x, point.y, offsets[i].x, offsets[i].y);
            keypoint.angle = point.angle;
            if (subPixel && !mask.empty() && !isUsable(mask, keypoint.pt))
                usablePosition(mask, rules.position, point.x, point.y, keypoint.pt);
        }
    }
}

void describeFeatures(const Level& level, const DescriptionRules& rules, const Range& features,
                      FeatureList& list, DescriptionScratch& scratch)
{
    const size_t end = size_t(features.end);
    if (!rules.tests)
    {
        if (rules.patch)
            findKeypoints(level, rules, size_t(features.start), end, list);
        return;
    }
    const int ROWS = 64;  // that are blurred at once
    const int reach = rules.tests->reach, margin = rules.tests->margin();
    const int rowsEnd = level.image.rows + margin;  // of all that can be read
    const std::vector<FeaturePoint>& points = list.points;
    scratch.region.reset(level.image.size(), margin);
    for (size_t i = size_t(features.start); i < end; i++)
        scratch.region.addDisc(Point(points[i].x, points[i].y), rules.tests->halfHeights);

    BlurredRows blurred;
    blurred.step = ptrdiff_t(alignSize(size_t(level.image.cols) + 2 * margin, CACHE_LINE / sizeof(ushort)));
    const size_t capacity = size_t(std::min<int64>(ROWS + 2 * int64(reach) + 1, rowsEnd + margin));
    growTo(scratch.blurred, capacity * blurred.step);
    blurred.data = scratch.blurred.data() + margin;
    int filled = -margin;  // the rows from blurred.top to before it are blurred
    for (size_t next, i = size_t(features.start); i < end; i = next)
    {
        // The rows that the next features read are kept.
        const int top = std::max(points[i].y - reach, -margin);
        if (top < filled)
            std::memmove(blurred.data - margin, blurred.row(top) - margin,
                         sizeof(ushort) * blurred.step * (filled - top));
        blurred.top = top;
        filled = std::max(filled, top);
        const int bottom = std::min(std::max(points[i].y + reach + 1, filled + ROWS), rowsEnd);
        for (next = i; next < end && (points[next].y + reach < bottom || bottom == rowsEnd);)
            next++;
        if (rules.patch)
            findKeypoints(level, rules, i, next, list);
        approximateBlur(level.image, scratch.region, Range(filled, bottom), blurred, scratch.blur);
        filled = bottom;
        computeDescriptors(level.image, blurred, &points[i], next - i, *rules.tests,
                           &list.descriptors[i * DESCRIPTOR_BYTES], DESCRIPTOR_BYTES);
    }
}

}  // namespace aqorb
}  // namespace cv
