// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// Patterns of cv::ORB, and descriptors for any pattern.

#include "precomp.hpp"

#include "common/angles.hpp"
#include "detector/blur.hpp"
#include "detector/descriptor.hpp"
#include "detector/orb_pattern.hpp"

#include "detector/descriptor.simd.hpp"
// Generated: CV_CPU_DISPATCH_MODES_ALL=AVX512_SKX, AVX2, BASELINE on x86-64.
#include "detector/descriptor.simd_declarations.hpp"

namespace cv
{
namespace aqorb
{

std::vector<Point> descriptorPattern(int patchSize, int WTA_K)
{
    const int POINTS = 512, TUPLES = 128;
    std::vector<Point> points(POINTS);
    if (patchSize == 31)
    {
        for (int i = 0; i < POINTS; i++)
            points[i] = Point(LEARNED_POINTS[i][0], LEARNED_POINTS[i][1]);
    }
    else
    {
        RNG rng(0x34985739);  // the seed of cv::ORB
        for (int i = 0; i < POINTS; i++)
        {
            points[i].x = rng.uniform(-patchSize / 2, patchSize / 2 + 1);
            points[i].y = rng.uniform(-patchSize / 2, patchSize / 2 + 1);
        }
    }
    if (WTA_K == 2)
        return points;

    // Draws tuples of distinct points from the 512.
    RNG rng(0x12345678);  // the seed of cv::ORB
    std::vector<Point> tuples;
    tuples.reserve(TUPLES * WTA_K);
    for (int i = 0; i < TUPLES; i++)
    {
        const size_t first = tuples.size();
        while (tuples.size() < first + WTA_K)
        {
            const Point point = points[rng.uniform(0, POINTS)];
            if (std::find(tuples.begin() + first, tuples.end(), point) == tuples.end())
                tuples.push_back(point);
        }
    }
    return tuples;
}

namespace
{

// Exactly blurred pixels around a keypoint.
struct BlurredLevel
{
    // Value at a point of the pattern.
    int at(Point offset) const
    {
        const Point p = keypoint + Point(cvRound(offset.x * cosine - offset.y * sine),
                                         cvRound(offset.x * sine + offset.y * cosine));
        if (p.x < 0 || p.y < 0 || p.x >= image.cols || p.y >= image.rows)
            return image.at<uchar>(borderInterpolate(p.y, image.rows, BORDER_REFLECT_101),
                                   borderInterpolate(p.x, image.cols, BORDER_REFLECT_101));
        // The exact value lies between the rounded bounds of the approximate value.
        const int approximate = blurred.row(p.y)[p.x];
        const int highest = (approximate + BLUR_SHORTFALL + 128) >> 8;
        const int lowest = (approximate - BLUR_EXCESS + 127) >> 8;
        if (highest == lowest)
            return highest;
        exactCount++;
        return exactBlur(image, p.x, p.y);
    }

    const Mat& image;
    const BlurredRows& blurred;
    Point keypoint;
    float cosine, sine;
    int64& exactCount;  // number of exactly blurred pixels
};

}  // namespace

// Index of the brightest point, with cv::ORB's order of ties.
static int brightest(const int* v, int WTA_K)
{
    if (WTA_K == 2)
        return v[1] > v[0];
    if (WTA_K == 3)
        return v[2] > v[1] ? (v[2] > v[0] ? 2 : 0) : (v[1] > v[0] ? 1 : 0);
    const int u = v[1] > v[0] ? 1 : 0, w = v[3] > v[2] ? 3 : 2;
    return v[u] > v[w] ? u : w;
}

// Computes the descriptor of any pattern, without the kernel.
static void computePlainly(const BlurredLevel& level, const std::vector<Point>& pattern, int WTA_K,
                           uchar* descriptor)
{
    const int bitsOfTest = WTA_K == 2 ? 1 : 2;
    const Point* p = &pattern[0];
    for (int i = 0; i < ORB::kBytes; i++)
    {
        int byte = 0;
        for (int bit = 0; bit < 8; bit += bitsOfTest, p += WTA_K)
        {
            int values[4];
            for (int k = 0; k < WTA_K; k++)
                values[k] = level.at(p[k]);
            byte |= brightest(values, WTA_K) << bit;
        }
        descriptor[i] = uchar(byte);
    }
}

static void decidePairs(const ushort* center, ptrdiff_t step, float a, float b, const PairTests& tests,
                        uchar* descriptor, uint64* undecided)
{
    CV_CPU_DISPATCH(comparePairs, (center, step, a, b, tests, descriptor, undecided),
                    CV_CPU_DISPATCH_MODES_ALL);
}

// Largest distance from the keypoint at which the descriptor reads.
static int reachOf(const std::vector<Point>& pattern)
{
    int64 squared = 0;
    for (const Point& p : pattern)
        squared = std::max(squared, int64(p.x) * p.x + int64(p.y) * p.y);
    return cvCeil(std::sqrt(double(squared))) + 1;
}

DescriptorTests::DescriptorTests(const std::vector<Point>& pattern_, int WTA_K_)
    : pattern(pattern_), WTA_K(WTA_K_), reach(reachOf(pattern_))
{
    for (int x = 0; x <= reach; x++)
        halfHeights.push_back(cvFloor(std::sqrt(double(reach) * reach - double(x) * x)));
    const int MAX_REACH = 64;  // limits the memory of the margin
    if (WTA_K != 2 || reach > MAX_REACH)
        return;
    pairs.resize(1);
    for (int i = 0; i < PairTests::COUNT; i++)
    {
        for (int k = 0; k < 2; k++)
        {
            pairs[0].x[k * PairTests::COUNT + i] = float(pattern[2 * i + k].x);
            pairs[0].y[k * PairTests::COUNT + i] = float(pattern[2 * i + k].y);
        }
    }
}

size_t computeDescriptors(const Mat& image, const BlurredRows& blurred, const FeaturePoint* points,
                          size_t count, const DescriptorTests& tests, uchar* descriptors, size_t step,
                          bool mayStop)
{
    CV_TRACE_FUNCTION();
    const int64 MAX_EXACT = 500, MAX_EXACT_PER_POINT = 50;  // photographs: one a point, at most six
    int64 exactCount = 0;
    for (size_t i = 0; i < count; i++, descriptors += step)
    {
        if (mayStop && exactCount > MAX_EXACT + MAX_EXACT_PER_POINT * int64(i))
            return i;
        const Point keypoint(points[i].x, points[i].y);
        float cosine, sine;
        sineAndCosine(points[i].angle * float(CV_PI / 180.f), sine, cosine);
        const BlurredLevel level = {image, blurred, keypoint, cosine, sine, exactCount};
        if (tests.pairs.empty())
        {
            computePlainly(level, tests.pattern, tests.WTA_K, descriptors);
            continue;
        }
        uint64 undecided[PairTests::COUNT / 64];
        decidePairs(blurred.row(keypoint.y) + keypoint.x, blurred.step, cosine, sine, tests.pairs[0],
                    descriptors, undecided);
        for (int first = 0; first < PairTests::COUNT; first += 64)
        {
            for (uint64 left = undecided[first / 64]; left; left &= left - 1)
            {
                const int test = first + trailingZeros(left);
                const Point* const p = &tests.pattern[2 * test];
                descriptors[test / 8] |= uchar(int(level.at(p[0]) < level.at(p[1])) << (test % 8));
            }
        }
    }
    return count;
}

}  // namespace aqorb
}  // namespace cv
