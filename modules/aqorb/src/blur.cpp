// This file is part of the aqorb project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.

#include "precomp.hpp"

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

uchar exactBlur(const Mat& image, int x, int y)
{
    const float* tap = gaussianTaps().tap;
    PatchBuffer buffer;
    const Patch patch = patchAround(image, x, y, RADIUS, buffer);
    float rows[2 * RADIUS + 1];
    for (int i = -RADIUS; i <= RADIUS; i++)
    {
        const uchar* p = patch.center + i * patch.step;
        float sum = tap[RADIUS] * p[-RADIUS];
        for (int j = -RADIUS + 1; j <= RADIUS; j++)
            sum = std::fma(tap[std::abs(j)], float(p[j]), sum);
        rows[RADIUS + i] = sum;
    }
    float sum = tap[0] * rows[RADIUS];
    for (int i = 1; i <= RADIUS; i++)
        sum = std::fma(rows[RADIUS + i] + rows[RADIUS - i], tap[i], sum);
    return saturate_cast<uchar>(sum);
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

static inline ushort upperHalf(unsigned a, unsigned b)
{
    return ushort((a * b) >> 16);
}

// p is readable from -RADIUS to width + RADIUS
static void blurRow(const uchar* p, int width, const ushort* tap, ushort* out)
{
    for (int x = 0; x < width; x++, p++)
    {
        out[x] = ushort(upperHalf(p[0] << 8, tap[0]) + upperHalf((p[1] + p[-1]) << 6, tap[1]) +
                        upperHalf((p[2] + p[-2]) << 6, tap[2]) + upperHalf((p[3] + p[-3]) << 6, tap[3]) + 2);
    }
}

static inline unsigned average(unsigned a, unsigned b)
{
    return (a + b + 1) >> 1;
}

// rows[0 .. 2 RADIUS]: the blurred rows around the output's
static void blurColumn(const ushort* const* rows, int width, const ushort* tap, ushort* out)
{
    for (int x = 0; x < width; x++)
    {
        out[x] = ushort(upperHalf(rows[3][x], tap[0]) + upperHalf(average(rows[4][x], rows[2][x]), tap[1]) +
                        upperHalf(average(rows[5][x], rows[1][x]), tap[2]) +
                        upperHalf(average(rows[6][x], rows[0][x]), tap[3]) + 2);
    }
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
                padded[RADIUS + width - 1 + i] = source[borderInterpolate(width - 1 + i, width, BORDER_REFLECT_101)];
            }
            blurRow(padded.data() + RADIUS, width, taps.row, ring.data() + size_t(done % RING) * width);
        }
        const ushort* rows[2 * RADIUS + 1];
        for (int i = -RADIUS; i <= RADIUS; i++)
        {
            const int row = borderInterpolate(y + i, height, BORDER_REFLECT_101);
            rows[RADIUS + i] = ring.data() + size_t(row % RING) * width;
        }
        blurColumn(rows, width, taps.column, blurred.ptr<ushort>(y));
    }
}

}  // namespace stages
}  // namespace aqorb
}  // namespace cv
