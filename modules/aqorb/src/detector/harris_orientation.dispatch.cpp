// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// Harris responses, and directions from the moments of circular patches.

#include "precomp.hpp"

#include "common/angles.hpp"
#include "detector/harris_orientation.hpp"
#include "detector/neighborhood.hpp"

#include "detector/harris_orientation.simd.hpp"
// Generated: CV_CPU_DISPATCH_MODES_ALL=AVX512_SKX, AVX2, BASELINE on x86-64.
#include "detector/harris_orientation.simd_declarations.hpp"

namespace cv
{
namespace aqorb
{

// Calls processRun(first, number) for runs of points inside a region, and processOther(index) for each other point.
template <typename P, typename ProcessRun, typename ProcessOther>
static void forEachRun(const P* points, size_t count, const Rect& region, const ProcessRun& processRun,
                       const ProcessOther& processOther)
{
    for (size_t first = 0, end; first < count; first = end)
    {
        end = first;
        while (end < count && region.contains(Point(points[end].x, points[end].y)))
            end++;
        if (end > first)
            processRun(first, int(end - first));
        else
            processOther(end++);
    }
}

// ---- Harris responses -------------------------------------------------------------------------

static const int HARRIS_RADIUS = 3;  // of the 5x5 block plus the Sobel operator
static const int HARRIS_REACH = 6;   // of the kernel's vectors to the right

static void respondInside(const uchar* image, ptrdiff_t step, const Corner* corners, int count,
                          CornerResponse* responses)
{
    CV_CPU_DISPATCH(cornerResponses, (image, step, corners, count, responses), CV_CPU_DISPATCH_MODES_ALL);
}

// Response of a corner near the border, from a copy of its neighbourhood with reflected pixels.
static float responseAtBorder(const Mat& image, int x, int y)
{
    NeighborhoodSpace space;
    const Neighborhood pixels = neighborhoodOf(image, x, y, HARRIS_REACH, space);
    const Corner center = {0, 0, 0};
    CornerResponse found;
    respondInside(pixels.center, pixels.step, &center, 1, &found);
    return found.response;
}

void harrisResponses(const Mat& image, const Corner* corners, size_t count, CornerResponse* responses)
{
    CV_TRACE_FUNCTION();
    const Rect inside(HARRIS_RADIUS, HARRIS_RADIUS, image.cols - HARRIS_RADIUS - HARRIS_REACH,
                      image.rows - 2 * HARRIS_RADIUS);
    forEachRun(
        corners, count, inside,
        [&](size_t first, int number)
        { respondInside(image.ptr(), ptrdiff_t(image.step), corners + first, number, responses + first); },
        [&](size_t i)
        {
            const Corner& c = corners[i];
            responses[i] = {c.x, c.y, responseAtBorder(image, c.x, c.y)};
        });
}

// ---- moments and directions --------------------------------------------------------------------

std::vector<int> circularPatch(int patchSize)
{
    // cv::ORB's circle: it rounds one octant and mirrors it, which makes the patch symmetric.
    const int radius = patchSize / 2;
    const int vmax = cvFloor(radius * std::sqrt(2.f) / 2 + 1);
    const int vmin = cvCeil(radius * std::sqrt(2.f) / 2);
    std::vector<int> halfWidths(radius + 2);
    for (int v = 0; v <= vmax; v++)
        halfWidths[v] = cvRound(std::sqrt(double(radius) * radius - double(v) * v));
    for (int v = radius, v0 = 0; v >= vmin; v--)
    {
        while (halfWidths[v0] == halfWidths[v0 + 1])
            v0++;
        halfWidths[v] = v0;
        v0++;
    }
    halfWidths.resize(radius + 1);
    halfWidths[0] = radius;  // the centre row spans the whole width
    return halfWidths;
}

// Moments of a patch of any size at any place, without the kernel.
static Moments plainMoments(const Mat& image, int x, int y, const OrientationPatch& weights)
{
    const int radius = int(weights.halfWidths.size()) - 1;
    const bool isInside = x >= radius && y >= radius && x < image.cols - radius && y < image.rows - radius;
    NeighborhoodSpace space(size_t(2 * radius + 1));  // one row: copying a whole large patch is slow

    // Unsigned sums: moments of very large patches wrap around, as in cv::ORB.
    unsigned sum01 = 0, sum10 = 0;
    const int last = radius - radius % weights.rowStep;
    for (int v = -last; v <= last; v += weights.rowStep)
    {
        if (!isInside)
            copyReflected(image, Rect(x - radius, y + v, 2 * radius + 1, 1), space.data());
        const uchar* const row = isInside ? image.ptr(y + v) + x : space.data() + radius;
        const int halfWidth = weights.halfWidths[std::abs(v)];
        unsigned sum = 0;
        for (int u = -halfWidth; u <= halfWidth; u++)
        {
            sum += row[u];
            sum10 += unsigned(u) * row[u];
        }
        sum01 += unsigned(v) * sum;
    }
    return {int(sum10), int(sum01)};
}

OrientationPatch::OrientationPatch(const std::vector<int>& halfWidths_, int rowStep_)
    : halfWidths(halfWidths_), rowStep(rowStep_)
{
    const int radius = int(halfWidths.size()) - 1, LANES = 32;
    if (radius > PatchWeights::MAX_RADIUS || !CV_SIMD)
        return;
    weights.resize(1);
    PatchWeights& table = weights[0];
    table.radius = radius;
    table.rowStep = rowStep;
    table.width = int(alignSize(size_t(2 * radius + 1), LANES));
    for (int v = 0; v <= radius; v++)
    {
        for (int x = 0; x < table.width; x++)
        {
            const bool inPatch = std::abs(x - radius) <= halfWidths[v];
            table.u[v][x] = short(inPatch ? x - radius : 0);
            table.v[v][x] = short(inPatch ? v : 0);
        }
    }
}

static void momentsInside(const Mat& image, const PatchWeights& weights, const FeaturePoint* points,
                          int count, Moments* moments)
{
    CV_CPU_DISPATCH(momentsAround, (image.ptr(), ptrdiff_t(image.step), weights, points, count, moments),
                    CV_CPU_DISPATCH_MODES_ALL);
}

void patchMoments(const Mat& image, const OrientationPatch& patch, const FeaturePoint* points, size_t count,
                  Moments* moments)
{
    Rect inside;  // region of the kernel; empty without weights
    if (!patch.weights.empty())
    {
        const int radius = patch.weights[0].radius;
        inside = Rect(radius, radius, image.cols - patch.weights[0].width, image.rows - 2 * radius);
    }
    forEachRun(
        points, count, inside,
        [&](size_t first, int number)
        { momentsInside(image, patch.weights[0], points + first, number, moments + first); },
        [&](size_t i) { moments[i] = plainMoments(image, points[i].x, points[i].y, patch); });
}

void orientations(const Mat& image, const OrientationPatch& patch, FeaturePoint* points, size_t count)
{
    CV_TRACE_FUNCTION();
    std::vector<Moments> moments(count);
    patchMoments(image, patch, points, count, moments.data());
    for (size_t i = 0; i < count; i++)
        points[i].angle = directionOf(float(moments[i].m10), float(moments[i].m01));
}

}  // namespace aqorb
}  // namespace cv
