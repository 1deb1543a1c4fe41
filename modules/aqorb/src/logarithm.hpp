// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#ifndef OPENCV_AQORB_LOGARITHM_HPP
#define OPENCV_AQORB_LOGARITHM_HPP

#include <opencv2/core.hpp>

#include <cfloat>

namespace cv
{
namespace aqorb
{
namespace stages
{

//! log2 of numbers > 0 that are finite, as fixed-point numbers with 24 bits of fraction. It is computed in integers, so it
//! is the same on every CPU.
class BinaryLogarithm
{
public:
    //! The only object of this type, which the first call makes.
    static const BinaryLogarithm& shared();

    int64 operator()(float v) const
    {
        int exponent = -127;
        if (v < FLT_MIN)
        {
            v *= 18446744073709551616.f;  // 2^64, so that it is normal
            exponent -= 64;
        }
        Cv32suf bits;
        bits.f = v;
        exponent += int(bits.u >> 23);
        const int STEP_BITS = 23 - SIZE_BITS;
        const unsigned fraction = bits.u & 0x7fffff, i = fraction >> STEP_BITS;
        const int64 step = fraction & ((1 << STEP_BITS) - 1);
        const int64 low = table[i], high = table[i + 1];
        return int64(exponent) * (1 << FRACTION_BITS) +
               ((low * (1 << STEP_BITS) + (high - low) * step) >> (STEP_BITS + TABLE_BITS - FRACTION_BITS));
    }

private:
    BinaryLogarithm();

    enum
    {
        FRACTION_BITS = 24,
        TABLE_BITS = 26,
        SIZE_BITS = 12,
        SIZE = 1 << SIZE_BITS
    };
    int table[SIZE + 1];  // floor(2^TABLE_BITS log2(1 + i / SIZE))
};

}  // namespace stages
}  // namespace aqorb
}  // namespace cv

#endif
