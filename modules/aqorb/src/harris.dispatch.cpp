// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "precomp.hpp"

#include "harris.hpp"
#include "patch.hpp"

#include "harris.simd.hpp"
#include "harris.simd_declarations.hpp"

namespace cv
{
namespace aqorb
{

static const int RADIUS = 3;  // of the 5x5 block and the Sobel operators around its pixels
static const int REACH = 6;   // to the right, where vectors read on

static void respondInside(const uchar* image, ptrdiff_t step, const Corner* corners, int count,
                          CornerResponse* responses)
{
    CV_CPU_DISPATCH(harrisOfCorners, (image, step, corners, count, responses), CV_CPU_DISPATCH_MODES_ALL);
}

// The response of a corner near the border, from a copy of its patch with reflected pixels.
static float responseAtBorder(const Mat& image, int x, int y)
{
    PatchBuffer buffer;
    const Patch patch = patchAround(image, x, y, REACH, buffer);
    const Corner center = {0, 0, 0};
    CornerResponse found;
    respondInside(patch.center, patch.step, &center, 1, &found);
    return found.response;
}

void harrisResponses(const Mat& image, const Corner* corners, size_t count, CornerResponse* responses)
{
    CV_TRACE_FUNCTION();
    const Rect inside(RADIUS, RADIUS, image.cols - RADIUS - REACH, image.rows - 2 * RADIUS);
    size_t end;
    for (size_t i = 0; i < count; i = end)
    {
        end = i;
        while (end < count && inside.contains(Point(corners[end].x, corners[end].y)))
            end++;
        respondInside(image.ptr(), ptrdiff_t(image.step), corners + i, int(end - i), responses + i);
        if (end < count)
        {
            const Corner& c = corners[end];
            responses[end++] = {c.x, c.y, responseAtBorder(image, c.x, c.y)};
        }
    }
}

}  // namespace aqorb
}  // namespace cv
