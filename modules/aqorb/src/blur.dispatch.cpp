// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "precomp.hpp"

#include "blur.hpp"
#include "patch.hpp"

#include "blur.simd.hpp"
#include "blur.simd_declarations.hpp"

namespace cv
{
namespace aqorb
{
namespace stages
{

// cv::ORB blurs a level by a Gaussian in float and rounds it to 8 bits at the end, so its value depends on every
// rounding on the way. exactBlur repeats these roundings one by one. approximateBlur is a fast version in fixed point
// with a proven bound on its error. The exact value is needed only where the bound leaves a comparison open.

static const int RADIUS = 3;

namespace
{
struct GaussianTaps
{
    GaussianTaps()
    {
        const Mat kernel = getGaussianKernel(2 * RADIUS + 1, 2, CV_32F);
        for (int i = 0; i <= RADIUS; i++)
            tap[i] = kernel.at<float>(RADIUS + i);
    }
    float tap[RADIUS + 1];  // of the centre and of the pixels 1, 2, 3 off it
};
}  // namespace

static const GaussianTaps& gaussianTaps()
{
    static const GaussianTaps taps;
    return taps;
}

static uchar exactBlurOf(const uchar* p, ptrdiff_t step, const float* taps)
{
    CV_CPU_DISPATCH(exactBlurAt, (p, step, taps), CV_CPU_DISPATCH_MODES_ALL);
}

uchar exactBlur(const Mat& image, int x, int y)
{
    const int READ = RADIUS + 1;  // vectors read one pixel more on the right
    const float* tap = gaussianTaps().tap;
    PatchBuffer buffer;
    const Patch patch = patchAround(image, x, y, READ, buffer);
    return exactBlurOf(patch.center, patch.step, tap);
}

// All products are the upper 16 bits of the product of 16-bit factors. The values are scaled up as far as 16 bits
// allow, and the taps by what is left. The error of approximateBlur against the exact value, in 1/256, has these parts:
//   the four products of the row pass round down:                             -4
//   the four products of the column pass, likewise:                           -4
//   the averages of two rows round up by 0 or 1/2, weighted by their taps:    +0.4
//   the taps are rounded to 16 bits; their sum, for these taps:               -1.5 or +1.5
//   the roundings of exactBlur itself:                                        -0.05 or +0.05
// Hence BLUR_SHORTFALL is 10, and BLUR_EXCESS is 2. To centre the error would take two more additions.
namespace
{
struct FixedTaps
{
    FixedTaps()
    {
        const float* tap = gaussianTaps().tap;
        for (int i = 0; i <= RADIUS; i++)
        {
            taps[0][i] = ushort(cvRound(tap[i] * (i == 0 ? 65536. : 4 * 65536.)));
            taps[1][i] = ushort(cvRound(tap[i] * (i == 0 ? 65536. : 2 * 65536.)));
        }
    }
    ushort taps[2][RADIUS + 1];  // of the rows' pass, of the columns'
};
}  // namespace

static void blurTileOf(const uchar* source, ptrdiff_t step, Size size, ushort* blurred, ptrdiff_t blurredStep)
{
    static const FixedTaps fixed;
    CV_CPU_DISPATCH(blurTile, (source, step, size.width, size.height, fixed.taps, blurred, blurredStep),
                    CV_CPU_DISPATCH_MODES_ALL);
}

// The first column of tiles is the left border, the last one the right border. Each column of `needed` has one row more
// than the level, which stays 0, so that the search for the end of a tile always ends.

void BlurRegion::begin(Size size_)
{
    size = size_;
    columns = 2 + std::max(size.width - 2 * RADIUS + TILE_WIDTH - 1, 0) / TILE_WIDTH;
    needed.assign(size_t(columns) * (size.height + 1), uchar(0));
}

int BlurRegion::columnOf(int x) const
{
    return x < RADIUS ? 0 : x >= size.width - RADIUS ? columns - 1 : 1 + (x - RADIUS) / TILE_WIDTH;
}

Range BlurRegion::pixelsOf(int column) const
{
    const bool inside = column > 0 && column < columns - 1;
    const int left = inside ? RADIUS : 0, right = size.width - left;
    const int width = std::min<int>(TILE_WIDTH, right - left);
    // The last tile overlaps the one before.
    const int x =
        std::min(column == columns - 1 ? right : left + std::max(column - 1, 0) * TILE_WIDTH, right - width);
    return Range(x, x + width);
}

void BlurRegion::add(const Rect& rect)
{
    const Rect part = rect & Rect(Point(), size);
    if (part.empty())
        return;
    for (int column = columnOf(part.x); column <= columnOf(part.x + part.width - 1); column++)
    {
        uchar* rows = needed.data() + size_t(column) * (size.height + 1) + part.y;
        std::fill(rows, rows + part.height, uchar(1));
    }
}

void BlurRegion::addDisc(const Point& center, const std::vector<int>& halfHeights)
{
    const int radius = int(halfHeights.size()) - 1;
    const int left = std::max(center.x - radius, 0), right = std::min(center.x + radius, size.width - 1);
    for (int column = columnOf(left), last = columnOf(right); column <= last; column++)
    {
        // Of the pixels of the column, that nearest to the centre counts.
        const int begin = column == 0             ? left
                          : column == columns - 1 ? std::max(left, size.width - RADIUS)
                                                  : std::max(left, RADIUS + (column - 1) * TILE_WIDTH);
        const int end = column == columns - 1 ? right + 1 : std::min(right + 1, RADIUS + column * TILE_WIDTH);
        const int distance = std::max(std::max(begin - center.x, center.x - (end - 1)), 0);
        if (distance > radius)
            continue;
        const int height = halfHeights[distance];
        const int top = std::max(center.y - height, 0), bottom = std::min(center.y + height + 1, size.height);
        uchar* rows = needed.data() + size_t(column) * (size.height + 1);
        if (top < bottom)
            std::memset(rows + top, 1, size_t(bottom - top));
    }
}

bool BlurRegion::nextTile(const Range& rows, Position& position, Rect& tile) const
{
    for (; position.column < columns; position.column++, position.row = rows.start)
    {
        const uchar* column = needed.data() + size_t(position.column) * (size.height + 1);
        const void* found = std::memchr(column + position.row, 1, size_t(rows.end - position.row));
        if (!found)
            continue;
        const uchar* first = static_cast<const uchar*>(found);
        const uchar* last =
            static_cast<const uchar*>(std::memchr(first, 0, size_t(column + size.height + 1 - first)));
        const Range pixels = pixelsOf(position.column);
        tile.x = pixels.start;
        tile.width = pixels.size();
        tile.y = int(first - column);
        const int bottom = tile.y < RADIUS                 ? RADIUS
                           : tile.y < size.height - RADIUS ? size.height - RADIUS
                                                           : size.height;
        tile.height = std::min(std::min(int(last - column), rows.end), bottom) - tile.y;
        position.row = tile.y + tile.height;
        return true;
    }
    return false;
}

void approximateBlur(const Mat& image, const BlurRegion& region, const Range& rows,
                     const BlurredRows& blurred, BlurScratch& scratch)
{
    CV_TRACE_FUNCTION();
    const Rect inner(RADIUS, RADIUS, image.cols - 2 * RADIUS, image.rows - 2 * RADIUS);
    BlurRegion::Position position = {0, rows.start};
    for (Rect tile; region.nextTile(rows, position, tile);)
    {
        const uchar* source = image.ptr(tile.y) + tile.x;
        ptrdiff_t step = ptrdiff_t(image.step);
        if ((tile & inner) != tile)
        {
            const Rect read(tile.x - RADIUS, tile.y - RADIUS, tile.width + 2 * RADIUS,
                            tile.height + 2 * RADIUS);
            step = read.width;
            if (scratch.size() < size_t(read.area()))
                scratch.resize(read.area());
            copyReflected(image, read, scratch.data());
            source = scratch.data() + RADIUS * step + RADIUS;
        }
        blurTileOf(source, step, tile.size(), blurred.row(tile.y) + tile.x, blurred.step);
    }
}

}  // namespace stages
}  // namespace aqorb
}  // namespace cv
