// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// Blurs the parts of a level around its keypoints.

#include "precomp.hpp"

#include "detector/types.hpp"
#include "detector/blur.hpp"
#include "detector/neighborhood.hpp"

#include "detector/blur.simd.hpp"
// Generated: CV_CPU_DISPATCH_MODES_ALL=AVX512_SKX, AVX2, BASELINE on x86-64.
#include "detector/blur.simd_declarations.hpp"

namespace cv
{
namespace aqorb
{

// cv::ORB blurs a level by a Gaussian in float and rounds to 8 bits at the end, so each intermediate rounding counts.
// exactBlur repeats all of them. approximateBlur is fast fixed-point arithmetic with a proven error bound. Descriptors
// need exactBlur only where the bound leaves a comparison open.

static const int RADIUS = 3;

// Each product is the upper 16 bits of a product of 16-bit factors. Pixels are scaled up as far as 16 bits allow, and
// taps by the remaining bits. The error of approximateBlur has these parts, in units of 1/256:
//   the four products of the row pass round down:                             -4
//   the four products of the column pass, likewise:                           -4
//   the averages of two rows round up by 0 or 1/2, weighted by their taps:    +0.4
//   the taps are rounded to 16 bits; their sum, for these taps:               -1.5 or +1.5
//   the roundings of exactBlur itself:                                        -0.05 or +0.05
// Hence BLUR_SHORTFALL is 10 and BLUR_EXCESS is 2. Centring the error would cost two more additions.
namespace
{
// Gaussian weights at distances 0 to 3, for exactBlur and for approximateBlur.
struct GaussianTaps
{
    GaussianTaps()
    {
        const Mat kernel = getGaussianKernel(2 * RADIUS + 1, 2, CV_32F);
        for (int i = 0; i <= RADIUS; i++)
        {
            exact[i] = kernel.at<float>(RADIUS + i);
            fixed[0][i] = ushort(cvRound(exact[i] * (i == 0 ? 65536. : 4 * 65536.)));
            fixed[1][i] = ushort(cvRound(exact[i] * (i == 0 ? 65536. : 2 * 65536.)));
        }
    }
    float exact[RADIUS + 1];
    ushort fixed[2][RADIUS + 1];  // row pass, column pass
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
    NeighborhoodSpace space;
    const Neighborhood pixels =
        neighborhoodOf(image, x, y, RADIUS + 1, space);  // the kernel reads 8 x 8 pixels
    return exactBlurOf(pixels.center, pixels.step, gaussianTaps().exact);
}

static void exactTileOf(const uchar* source, ptrdiff_t step, int height, ushort* blurred,
                        ptrdiff_t blurredStep)
{
    CV_CPU_DISPATCH(exactTile, (source, step, height, gaussianTaps().exact, blurred, blurredStep),
                    CV_CPU_DISPATCH_MODES_ALL);
}

static void approximateTileOf(const uchar* source, ptrdiff_t step, int height, ushort* blurred,
                              ptrdiff_t blurredStep)
{
    CV_CPU_DISPATCH(blurTile, (source, step, height, gaussianTaps().fixed, blurred, blurredStep),
                    CV_CPU_DISPATCH_MODES_ALL);
}

static void blurTileOf(const uchar* source, ptrdiff_t step, int height, ushort* blurred,
                       ptrdiff_t blurredStep, bool isExact)
{
    (isExact ? exactTileOf : approximateTileOf)(source, step, height, blurred, blurredStep);
}

int blurMargin(int reach)
{
    return int(alignSize(size_t(reach + RADIUS), BLUR_TILE_WIDTH)) - RADIUS;
}

void BlurRegion::reset(Size size_, int margin_)
{
    size = size_;
    margin = margin_;
    borderTiles = (margin + RADIUS) / BLUR_TILE_WIDTH;
    innerTiles = std::max(size.width - 2 * RADIUS + BLUR_TILE_WIDTH - 1, 0) / BLUR_TILE_WIDTH;
    needed.assign(size_t(2 * borderTiles + innerTiles) * (size.height + 2 * margin), uchar(0));
}

// Border tiles depend on reflected pixels. They reach RADIUS pixels into the level.

int BlurRegion::columnOf(int x) const
{
    const int right = size.width - RADIUS;
    return x < RADIUS  ? (x + margin) / BLUR_TILE_WIDTH
           : x < right ? borderTiles + (x - RADIUS) / BLUR_TILE_WIDTH
                       : borderTiles + innerTiles + (x - right) / BLUR_TILE_WIDTH;
}

int BlurRegion::firstPixelOf(int column) const
{
    const int right = size.width - RADIUS, rightTile = column - borderTiles - innerTiles;
    return column < borderTiles ? column * BLUR_TILE_WIDTH - margin
           : rightTile >= 0
               ? right + rightTile * BLUR_TILE_WIDTH
               // the last inner tile overlaps the tile before it
               : std::min(RADIUS + (column - borderTiles) * BLUR_TILE_WIDTH, right - BLUR_TILE_WIDTH);
}

const uchar* BlurRegion::rowsOf(int column) const
{
    return needed.data() + size_t(column) * (size.height + 2 * margin) + margin;
}

void BlurRegion::addDisc(const Point& center, const std::vector<int>& halfHeights)
{
    const int radius = int(halfHeights.size()) - 1;
    const int left = std::max(center.x - radius, -margin),
              right = std::min(center.x + radius, size.width + margin - 1);
    for (int column = columnOf(left), last = columnOf(right); column <= last; column++)
    {
        // The column's pixel nearest to the centre determines the height.
        const int begin = firstPixelOf(column), end = begin + BLUR_TILE_WIDTH;
        const int height = halfHeights[std::max(std::max(begin - center.x, center.x - (end - 1)), 0)];
        const int top = std::max(center.y - height, -margin),
                  bottom = std::min(center.y + height + 1, size.height + margin);
        std::memset(const_cast<uchar*>(rowsOf(column)) + top, 1, size_t(bottom - top));
    }
}

static void blurAtBorder(const Mat& image, const Rect& tile, const BlurredRows& blurred,
                         std::vector<uchar>& space, bool isExact)
{
    const Rect read(tile.x - RADIUS, tile.y - RADIUS, tile.width + 2 * RADIUS, tile.height + 2 * RADIUS);
    growTo(space, size_t(read.width) * read.height);
    copyReflected(image, read, space.data());
    const uchar* source = space.data() + RADIUS * read.width + RADIUS;
    blurTileOf(source, read.width, tile.height, blurred.row(tile.y) + tile.x, blurred.step, isExact);
    // Columns of the tile inside the level.
    const int left = std::max(-tile.x, 0), right = std::max(std::min(image.cols - tile.x, tile.width), left);
    for (int y = tile.y; y < tile.y + tile.height; y++, source += read.width)
    {
        ushort* const out = blurred.row(y) + tile.x;
        const bool isInside = y >= 0 && y < image.rows;
        for (int x = 0; x < (isInside ? left : tile.width); x++)
            out[x] = ushort(source[x] << 8);
        for (int x = right; x < tile.width; x++)
            out[x] = ushort(source[x] << 8);
    }
}

void approximateBlur(const Mat& image, const BlurRegion& region, const Range& rows,
                     const BlurredRows& blurred, std::vector<uchar>& space, bool isExact)
{
    CV_TRACE_FUNCTION();
    const Rect inner(RADIUS, RADIUS, image.cols - 2 * RADIUS, image.rows - 2 * RADIUS);
    for (int column = 0; column < region.columns(); column++)
    {
        const int x = region.firstPixelOf(column);
        const uchar* const needed = region.rowsOf(column);
        const auto find = [&](int value, int y)
        {
            const void* found = y < rows.end ? std::memchr(needed + y, value, size_t(rows.end - y)) : 0;
            return found ? int(static_cast<const uchar*>(found) - needed) : rows.end;
        };
        for (int y = find(1, rows.start), end; y < rows.end; y = find(1, end))
        {
            const int bottom = y < inner.y ? inner.y : y < inner.br().y ? inner.br().y : rows.end;
            end = std::min(find(0, y), bottom);
            const Rect tile(x, y, BLUR_TILE_WIDTH, end - y);
            if ((tile & inner) == tile)
                blurTileOf(image.ptr(y) + x, ptrdiff_t(image.step), tile.height, blurred.row(y) + x,
                           blurred.step, isExact);
            else
                blurAtBorder(image, tile, blurred, space, isExact);
        }
    }
}

}  // namespace aqorb
}  // namespace cv
