// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// Copies pixels, with reflection at the border.

#include "precomp.hpp"

#include "detector/neighborhood.hpp"

namespace cv
{
namespace aqorb
{

// Copies pixels of a row from x on, with repeated reflection at both ends.
static void copyRow(const uchar* row, int length, int x, int width, uchar* out)
{
    if (length == 1)
    {
        std::fill_n(out, width, row[0]);
        return;
    }
    const int period = 2 * (length - 1);
    for (int run; width > 0; x += run, width -= run, out += run)
    {
        const int phase = x % period, begin = phase < 0 ? phase + period : phase;
        run = std::min(width, (begin < length ? length : period) - begin);
        if (begin < length)
            std::copy(row + begin, row + begin + run, out);
        else
            std::reverse_copy(row + period - begin - run + 1, row + period - begin + 1, out);
    }
}

void copyReflected(const Mat& image, const Rect& rect, uchar* out)
{
    for (int y = rect.y; y < rect.y + rect.height; y++, out += rect.width)
    {
        const bool isInside = y >= 0 && y < image.rows;
        copyRow(image.ptr(isInside ? y : borderInterpolate(y, image.rows, BORDER_REFLECT_101)), image.cols,
                rect.x, rect.width, out);
    }
}

Neighborhood neighborhoodOf(const Mat& image, int x, int y, int radius, NeighborhoodSpace& space)
{
    if (x >= radius && y >= radius && x < image.cols - radius && y < image.rows - radius)
        return {image.ptr(y) + x, ptrdiff_t(image.step)};
    const int side = 2 * radius + 1;
    space.allocate(size_t(side) * side);
    copyReflected(image, Rect(x - radius, y - radius, side, side), space.data());
    return {space.data() + size_t(radius) * side + radius, side};
}

}  // namespace aqorb
}  // namespace cv
