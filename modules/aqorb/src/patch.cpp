// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// Copies pixels, and reflects those beyond the border.

#include "precomp.hpp"

#include "patch.hpp"

namespace cv
{
namespace aqorb
{

void copyReflected(const Mat& image, const Rect& rect, uchar* out)
{
    const Range inside(std::max(rect.x, 0), std::min(rect.x + rect.width, image.cols));
    const int left = std::min(std::max(inside.start - rect.x, 0), rect.width),
              right = std::max(inside.end - rect.x, left);
    AutoBuffer<int, 256> columns(rect.width);
    for (int x = 0; x < rect.width; x++)
    {
        if (x < left || x >= right)
            columns[x] = borderInterpolate(rect.x + x, image.cols, BORDER_REFLECT_101);
    }
    for (int y = 0; y < rect.height; y++, out += rect.width)
    {
        const bool isInside = rect.y + y >= 0 && rect.y + y < image.rows;
        const uchar* row =
            image.ptr(isInside ? rect.y + y : borderInterpolate(rect.y + y, image.rows, BORDER_REFLECT_101));
        for (int x = 0; x < left; x++)
            out[x] = row[columns[x]];
        if (left < right)
            std::copy(row + rect.x + left, row + rect.x + right, out + left);
        for (int x = right; x < rect.width; x++)
            out[x] = row[columns[x]];
    }
}

Patch patchAround(const Mat& image, int x, int y, int radius, PatchBuffer& buffer)
{
    if (x >= radius && y >= radius && x < image.cols - radius && y < image.rows - radius)
        return {image.ptr(y) + x, ptrdiff_t(image.step)};
    const int side = 2 * radius + 1;
    buffer.allocate(size_t(side) * side);
    copyReflected(image, Rect(x - radius, y - radius, side, side), buffer.data());
    return {buffer.data() + size_t(radius) * side + radius, side};
}

}  // namespace aqorb
}  // namespace cv
