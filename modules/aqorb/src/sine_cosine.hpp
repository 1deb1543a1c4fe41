// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#ifndef OPENCV_AQORB_SINE_COSINE_HPP
#define OPENCV_AQORB_SINE_COSINE_HPP

#include <cmath>

namespace cv
{
namespace aqorb
{

/** Sine and cosine of an angle in radians, the same on every system.

 C libraries differ in the last bit of these functions, and so does cv::ORB. These are, to the bit, those of the GNU C
 library up to version 2.41, which has them from Arm's Optimized Routines: polynomials in double, rounded to float at the
 end. They are not always the floats nearest to the exact values. From 120 on they are the C library's; directions are
 below 2 pi. */
inline void sineAndCosine(float angle, float& sine, float& cosine)
{
    if (!(std::abs(angle) < 120.f))  // NaN, too
    {
        sine = std::sin(angle);
        cosine = std::cos(angle);
        return;
    }
    // The angle is n quarters of a turn plus x, which is at most an eighth of a turn.
    const double QUARTER = 1.5707963267948966, QUARTERS_PER_RADIAN = 0.6366197723675814;
    const int BITS = 24, HALF = 1 << (BITS - 1);
    const int n = (int(angle * (QUARTERS_PER_RADIAN * (1 << BITS))) + HALF) >> BITS;
    const double x = angle - n * QUARTER, x2 = x * x, x3 = x2 * x, x4 = x2 * x2;
    const double lowSine = x + x3 * -0.16666654943701084;
    const double highSine = 0.008332178146138854 + x2 * -0.00019517298981385725;
    const double lowCosine = 1 + x2 * -0.49999999725108224 + x4 * 0.041666623324344516;
    const double highCosine = -0.001388676379437604 + x2 * 2.4390450703564542e-05;
    const float s = float(lowSine + x3 * x2 * highSine), c = float(lowCosine + x4 * x2 * highCosine);
    // Branches on a direction would be hard to predict.
    const float both[] = {s, c};
    sine = both[n & 1] * float(1 - (n & 2));
    cosine = both[~n & 1] * float(1 - ((n + 1) & 2));
}

}  // namespace aqorb
}  // namespace cv

#endif
