// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// Turns selected corners into keypoints with descriptors.

#include "precomp.hpp"

#include "detector/keypoints.hpp"

#include "detector/fast.hpp"

namespace cv
{
namespace aqorb
{

Point2d subPixelOffset(const Mat& image, int x, int y)
{
    int s[3][3];
    cornerScores3x3(image, x, y, s);

    // Derivatives by central differences, scaled to whole numbers: twice the gradient and four times dxy.
    const int gx2 = s[1][2] - s[1][0], gy2 = s[2][1] - s[0][1];
    const int dxx = s[1][2] - 2 * s[1][1] + s[1][0], dyy = s[2][1] - 2 * s[1][1] + s[0][1];
    const int dxy4 = s[2][2] - s[2][0] - s[0][2] + s[0][0];
    const int determinant16 = 16 * dxx * dyy - dxy4 * dxy4;
    if (dxx >= 0 || determinant16 <= 0)  // no peak
        return Point2d(0, 0);
    // The peak is at minus the inverse of the Hessian times the gradient.
    const double px = 2. * (dxy4 * gy2 - 4 * dyy * gx2) / determinant16;
    const double py = 2. * (dxy4 * gx2 - 4 * dxx * gy2) / determinant16;
    return Point2d(std::min(std::max(px, -0.5), 0.5), std::min(std::max(py, -0.5), 0.5));
}

std::vector<FeatureRange> divideIntoRanges(const std::vector<FeatureList>& features, int threads)
{
    const size_t MIN_FEATURES = 64;
    size_t all = 0;
    for (const FeatureList& list : features)
        all += list.points.size();
    const size_t most = threads == 1 ? all + 1 : std::max(all / (4 * threads), MIN_FEATURES);
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
    for (size_t i = begin; i < end; i++)
    {
        const FeaturePoint& point = list.points[i];
        KeyPoint& keypoint = list.keypoints[i];
        const Point2d offset = subPixel ? subPixelOffset(image, point.x, point.y) : Point2d();
        keypoint.pt = rules.position(point.x, point.y, offset.x, offset.y);
        keypoint.angle = point.angle;
        if (subPixel && !mask.empty() && !isUsable(mask, keypoint.pt))
            usablePosition(mask, rules.position, point.x, point.y, keypoint.pt);
    }
}

void describeFeatures(const Level& level, const DescriptionRules& rules, const Range& features,
                      FeatureList& list, DescriptionScratch& scratch)
{
    const size_t end = size_t(features.end);
    if (rules.patch)
        findKeypoints(level, rules, size_t(features.start), end, list);
    if (!rules.tests)
        return;
    const int ROWS = 128;  // blurred at once; more rows would be faster and take more memory
    const int reach = rules.tests->reach, margin = rules.tests->margin();
    const int rowsEnd = level.image.rows + margin;
    const std::vector<FeaturePoint>& points = list.points;
    scratch.region.reset(level.image.size(), margin);
    for (size_t i = size_t(features.start); i < end; i++)
        scratch.region.addDisc(Point(points[i].x, points[i].y), rules.tests->halfHeights);

    BlurredRows blurred;
    blurred.step = ptrdiff_t(alignSize(size_t(level.image.cols) + 2 * margin, CACHE_LINE / sizeof(ushort)));
    const size_t capacity = size_t(std::min<int64>(ROWS + 2 * int64(reach) + 1, rowsEnd + margin));
    growTo(scratch.blurred, capacity * blurred.step);
    blurred.data = scratch.blurred.data() + margin;
    int filled = -margin;  // rows from blurred.top to `filled`, exclusive, are blurred
    bool isExact = false;
    for (size_t next, i = size_t(features.start); i < end;)
    {
        // Keeps the rows that the next features read.
        const int top = std::max(points[i].y - reach, -margin);
        if (top < filled)
            std::memmove(blurred.data - margin, blurred.row(top) - margin,
                         sizeof(ushort) * blurred.step * (filled - top));
        blurred.top = top;
        filled = std::max(filled, top);
        const int bottom = std::min(std::max(points[i].y + reach + 1, filled + ROWS), rowsEnd);
        for (next = i; next < end && (points[next].y + reach < bottom || bottom == rowsEnd);)
            next++;
        approximateBlur(level.image, scratch.region, Range(filled, bottom), blurred, scratch.blur, isExact);
        filled = bottom;
        i += computeDescriptors(level.image, blurred, &points[i], next - i, *rules.tests,
                                &list.descriptors[i * ORB::kBytes], ORB::kBytes, !isExact);
        if (i < next)
        {
            isExact = true;
            filled = -margin;
        }
    }
}

}  // namespace aqorb
}  // namespace cv
