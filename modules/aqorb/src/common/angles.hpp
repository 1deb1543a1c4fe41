// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// Directions and their sines, to the same bit on every system.

#ifndef OPENCV_AQORB_ANGLES_HPP
#define OPENCV_AQORB_ANGLES_HPP

#include <opencv2/core.hpp>

#include <algorithm>
#include <cfloat>
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

//! Direction of a vector in degrees, 0 to 360, by the formula of cv::fastAtan2. OpenCV's binaries round differently on
//! some CPUs, because compilers fuse multiplications and additions.
static CV_ALWAYS_INLINE float directionOf(float vectorX, float vectorY)
{
    const float DEGREES = float(180 / CV_PI);
    const float P1 = 0.9997878412794807f * DEGREES, P3 = -0.3258083974640975f * DEGREES;
    const float P5 = 0.1555786518463281f * DEGREES, P7 = -0.04432655554792128f * DEGREES;
    const float x = std::abs(vectorX), y = std::abs(vectorY);
    const float t = std::min(x, y) / (std::max(x, y) + float(DBL_EPSILON)), t2 = t * t;
    const float angle = (((P7 * t2 + P5) * t2 + P3) * t2 + P1) * t;
    // The angle, or whole - angle. No branches: the CPU cannot predict directions.
    const auto mirrored = [](bool isMirrored, float whole, float v)
    { return whole * float(isMirrored) + v * float(1 - 2 * int(isMirrored)); };
    return mirrored(vectorY < 0, 360, mirrored(vectorX < 0, 180, mirrored(x < y, 90, angle)));
}

}  // namespace aqorb
}  // namespace cv

#endif
