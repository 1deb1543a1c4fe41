// This file is part of the aqorb project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.

#include "precomp.hpp"

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

static void columnPass(const ushort* const* rows, int width, const ushort* taps, ushort* out)
{
    CV_CPU_DISPATCH(blurColumn, (rows, width, taps, out), CV_CPU_DISPATCH_MODES_ALL);
}

void approximateBlur(const Mat& image, Mat& blurred)
{
    CV_TRACE_FUNCTION();
    static const FixedTaps taps;
    const int width = image.cols, height = image.rows, RING = 8;
    blurred.create(image.size(), CV_16UC1);
    AutoBuffer<uchar> padded(width + 2 * RADIUS);
    AutoBuffer<ushort> ring(size_t(width) * RING);
    int done = 0;  // rows that went through the row pass
    for (int y = 0; y < height; y++)
    {
        for (; done < std::min(y + RADIUS + 1, height); done++)
        {
            const uchar* source = image.ptr(done);
            std::copy(source, source + width, padded.data() + RADIUS);
            for (int i = 1; i <= RADIUS; i++)
            {
                padded[RADIUS - i] = source[borderInterpolate(-i, width, BORDER_REFLECT_101)];
                padded[RADIUS + width - 1 + i] =
                    source[borderInterpolate(width - 1 + i, width, BORDER_REFLECT_101)];
            }
            rowPass(padded.data() + RADIUS, width, taps.row, ring.data() + size_t(done % RING) * width);
        }
        const ushort* rows[2 * RADIUS + 1];
        for (int i = -RADIUS; i <= RADIUS; i++)
        {
            const int row = borderInterpolate(y + i, height, BORDER_REFLECT_101);
            rows[RADIUS + i] = ring.data() + size_t(row % RING) * width;
        }
        columnPass(rows, width, taps.column, blurred.ptr<ushort>(y));
    }
}

}  // namespace stages
}  // namespace aqorb
}  // namespace cv
