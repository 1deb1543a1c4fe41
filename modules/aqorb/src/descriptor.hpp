// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// Descriptors of cv::ORB. The exact blur decides the tests that the approximate blur leaves open.

#ifndef OPENCV_AQORB_DESCRIPTOR_HPP
#define OPENCV_AQORB_DESCRIPTOR_HPP

#include "types.hpp"
#include "blur.hpp"

#include <opencv2/aqorb/features.hpp>

#include <cmath>

namespace cv
{
namespace aqorb
{

//! Angle of at least 120 radians in quarter turns, modulo 4, in units of 2^-62.
uint64 quartersOf(float angle);

/** Sine and cosine of an angle, the same on every system.

 C libraries differ in the last bit of sine and cosine, and so does cv::ORB. This function equals, to the bit, sinf and
 cosf of the GNU C library up to version 2.41, which come from Arm's Optimized Routines: polynomials in double, rounded
 to float at the end. The results are not always the floats nearest to the exact values. */
inline void sineAndCosine(float angle, float& sine, float& cosine)
{
    // The angle is n quarter turns plus x, with |x| at most an eighth of a turn.
    const double QUARTER = 1.5707963267948966, QUARTERS_PER_RADIAN = 0.6366197723675814;
    int n;
    double x;
    if (std::abs(angle) < 120)
    {
        const int BITS = 24, HALF = 1 << (BITS - 1);
        n = (int(angle * (QUARTERS_PER_RADIAN * (1 << BITS))) + HALF) >> BITS;
        x = angle - n * QUARTER;
    }
    else
    {
        const int BITS = 62;
        const uint64 quarters = quartersOf(angle), HALF = uint64(1) << (BITS - 1);
        n = int((quarters + HALF) >> BITS);
        x = double(int64(quarters - (uint64(n) << BITS))) * (QUARTER / (uint64(1) << BITS));
    }
    const double x2 = x * x, x3 = x2 * x, x4 = x2 * x2;
    const double lowSine = x + x3 * -0.16666654943701084;
    const double highSine = 0.008332178146138854 + x2 * -0.00019517298981385725;
    const double lowCosine = 1 + x2 * -0.49999999725108224 + x4 * 0.041666623324344516;
    const double highCosine = -0.001388676379437604 + x2 * 2.4390450703564542e-05;
    const float s = float(lowSine + x3 * x2 * highSine), c = float(lowCosine + x4 * x2 * highCosine);
    // A table instead of branches: the CPU cannot predict directions.
    const float both[] = {s, c};
    sine = both[n & 1] * float(1 - (n & 2));
    cosine = both[~n & 1] * float(1 - ((n + 1) & 2));
}

//! Points of rBRIEF's tests, WTA_K for each test, as cv::ORB draws them.
std::vector<Point> descriptorPattern(int patchSize, int WTA_K);

//! The 256 tests of a descriptor with WTA_K 2. A bit is 1 if point 0 is darker than point 1.
struct PairTests
{
    enum
    {
        COUNT = 256
    };
    float x[2 * COUNT], y[2 * COUNT];  //!< the first points of all tests, then the second points
};

//! Pattern, prepared for any number of descriptors.
struct DescriptorTests
{
    DescriptorTests(const std::vector<Point>& pattern, int WTA_K);

    std::vector<Point> pattern;
    int WTA_K;
    int reach;                     //!< largest distance from the keypoint at which a descriptor reads
    std::vector<int> halfHeights;  //!< half height of the disc of radius `reach`, by horizontal distance
    //! One element for the kernel; empty if WTA_K is not 2 or the reach is too far.
    AlignedVector<PairTests> pairs;
    //! Margin that the blurred rows need.
    int margin() const { return blurMargin(pairs.empty() ? 0 : reach); }
};

/** Computes the 32-byte descriptors of cv::ORB at pixels of a level.
 @param image the level
 @param blurred approximateBlur of the level, at least in the discs around the points, with tests.margin() around it
 @param points pixels and directions
 @param count number of points
 @param tests the pattern
 @param descriptors receives one descriptor per row
 @param step bytes from row to row
 @param mayStop stops early when so many tests need exactBlur that blurring all pixels exactly is faster
 @return number of points with a descriptor */
size_t computeDescriptors(const Mat& image, const BlurredRows& blurred, const FeaturePoint* points,
                          size_t count, const DescriptorTests& tests, uchar* descriptors, size_t step,
                          bool mayStop = false);

}  // namespace aqorb
}  // namespace cv

#endif
