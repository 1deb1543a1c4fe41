// This file is part of the aqorb project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.

#include "precomp.hpp"

#include "simd_compat.hpp"

#include "blur.simd.hpp"
#include "blur.simd_declarations.hpp"

namespace cv
{
namespace aqorb
{
namespace stages
{

// cv::ORB's blur of a level is a Gaussian in float, rounded to 8 bits at the end; its value depends on
// every rounding on the way. exactBlur repeats these one by one. approximateBlur is a fast fixed-point
// version with a proven bound; only where the bound leaves a comparison open is the exact value needed.

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
    const float* tap = gaussianTaps().tap;
    PatchBuffer buffer;
    const Patch patch = patchAround(image, x, y, RADIUS, buffer);
    return exactBlurOf(patch.center, patch.step, tap);
}

// All products are the upper 16 bits of 16-bit factors. The values are scaled up as far as 16 bits
// allow, the taps by what is left. How far approximateBlur is off the exact value, in 1/256:
//   the four products of the row pass round down, which + 2 centres:            2
//   the four products of the column pass, likewise:                             2
//   the averages of two rows round up by 0 or 1/2, weighted by their taps:      0.4
//   the taps are rounded to 16 bits, (all in all, for these taps):              1.5
//   the roundings of exactBlur itself:                                          0.05
// so BLUR_BOUND = 6.
namespace
{
struct FixedTaps
{
    FixedTaps()
    {
        const float* tap = gaussianTaps().tap;
        for (int i = 0; i <= RADIUS; i++)
        {
            row[i] = ushort(cvRound(tap[i] * (i == 0 ? 65536. : 4 * 65536.)));
            column[i] = ushort(cvRound(tap[i] * (i == 0 ? 65536. : 2 * 65536.)));
        }
    }
    ushort row[RADIUS + 1], column[RADIUS + 1];
};
}  // namespace

static void rowPass(const uchar* row, int width, const ushort* taps, ushort* out)
{
    CV_CPU_DISPATCH(blurRow, (row, width, taps, out), CV_CPU_DISPATCH_MODES_ALL);
}

static void columnPass(const ushort* const* rows, int first, int width, const ushort* taps, ushort* out)
{
    const ushort* at[2 * RADIUS + 1];
    for (int i = 0; i <= 2 * RADIUS; i++)
        at[i] = rows[i] + first;
    CV_CPU_DISPATCH(blurColumn, (at, width, taps, out + first), CV_CPU_DISPATCH_MODES_ALL);
}

void BlurRegion::begin(Size size_)
{
    const int BLOCKS = 64, ALIGN = 32;  // bits of a row; whole vectors
    size = size_;
    blockWidth = int(alignSize(size_t((size.width + BLOCKS - 1) / BLOCKS), ALIGN));
    rows.assign(size.height, 0);
}

void BlurRegion::add(const Rect& rect)
{
    const Rect part = rect & Rect(Point(), size);
    if (part.empty())
        return;
    const int first = part.x / blockWidth, last = (part.x + part.width - 1) / blockWidth;
    const uint64 blocks = (~uint64(0) >> (63 - (last - first))) << first;
    for (int y = part.y; y < part.y + part.height; y++)
        rows[y] |= blocks;
}

uint64 BlurRegion::blocksNear(int y, int radius) const
{
    uint64 blocks = 0;
    for (int i = std::max(y - radius, 0); i <= std::min(y + radius, size.height - 1); i++)
        blocks |= rows[i];
    return blocks;
}

bool BlurRegion::takeRun(uint64& blocks, Range& columns) const
{
    if (blocks == 0)
        return false;
    const int BITS = 64;
    const int first = trailingZeros(blocks);
    const uint64 behind = ~(blocks >> first);
    const int end = behind ? first + trailingZeros(behind) : BITS;
    columns.start = first * blockWidth;
    columns.end = std::min(end * blockWidth, size.width);
    blocks = end < BITS ? blocks >> end << end : 0;
    return true;
}

// The row pass of columns within RADIUS of the border, by way of a copy filled up by reflection.
static void rowPassAtBorder(const uchar* source, int width, const Range& columns, const ushort* taps,
                            ushort* out)
{
    uchar padded[3 * RADIUS];
    for (int i = 0; i < columns.size() + 2 * RADIUS; i++)
        padded[i] = source[borderInterpolate(columns.start - RADIUS + i, width, BORDER_REFLECT_101)];
    rowPass(padded + RADIUS, columns.size(), taps, out + columns.start);
}

void approximateBlur(const Mat& image, const BlurRegion& region, Mat& blurred, BlurScratch& scratch)
{
    CV_TRACE_FUNCTION();
    static const FixedTaps taps;
    const int width = image.cols, height = image.rows, RING = 8;
    const Range inner(std::min(RADIUS, width), std::max(width - RADIUS, std::min(RADIUS, width)));
    if (scratch.size() < size_t(width) * RING)
        scratch.resize(size_t(width) * RING);
    int done = 0;  // rows that went through the row pass
    for (int y = 0; y < height; y++)
    {
        for (; done < std::min(y + RADIUS + 1, height); done++)
        {
            const uchar* source = image.ptr(done);
            ushort* out = scratch.data() + size_t(done % RING) * width;
            Range run;
            for (uint64 blocks = region.blocksNear(done, RADIUS); region.takeRun(blocks, run);)
            {
                const Range middle = run & inner;
                if (run.start < inner.start)
                    rowPassAtBorder(source, width, Range(0, inner.start), taps.row, out);
                if (middle.start < middle.end)
                    rowPass(source + middle.start, middle.size(), taps.row, out + middle.start);
                if (run.end > inner.end)
                    rowPassAtBorder(source, width, Range(inner.end, width), taps.row, out);
            }
        }
        const ushort* rows[2 * RADIUS + 1];
        for (int i = -RADIUS; i <= RADIUS; i++)
        {
            const int row = borderInterpolate(y + i, height, BORDER_REFLECT_101);
            rows[RADIUS + i] = scratch.data() + size_t(row % RING) * width;
        }
        Range run;
        for (uint64 blocks = region.blocksNear(y, 0); region.takeRun(blocks, run);)
            columnPass(rows, run.start, run.size(), taps.column, blurred.ptr<ushort>(y));
    }
}

void approximateBlur(const Mat& image, Mat& blurred)
{
    BlurRegion everywhere;
    everywhere.begin(image.size());
    everywhere.add(Rect(Point(), image.size()));
    blurred.create(image.size(), CV_16UC1);
    BlurScratch scratch;
    approximateBlur(image, everywhere, blurred, scratch);
}

}  // namespace stages
}  // namespace aqorb
}  // namespace cv
