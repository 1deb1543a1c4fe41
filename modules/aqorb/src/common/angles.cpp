// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// Quarter turns of large angles.

#include "precomp.hpp"

#include "common/angles.hpp"

namespace cv
{
namespace aqorb
{

uint64 quartersOf(float angle)
{
    // Bits of 2 / pi after the binary point.
    const unsigned QUARTERS_PER_RADIAN[] = {0xa2f9836eu, 0x4e441529u, 0xfc2757d1u, 0xf534ddc0u,
                                            0xdb629599u, 0x3c439041u, 0xfe5163abu};
    int exponent;
    const uint64 significand = uint64(std::ldexp(std::frexp(std::abs(angle), &exponent), 24));
    uint64 quarters = 0;
    int shift = 62 + exponent - 24;
    for (const unsigned word : QUARTERS_PER_RADIAN)
    {
        shift -= 32;
        const uint64 product = significand * word;
        // Bits shifted out to the left are whole turns.
        if (shift > -64 && shift < 64)
            quarters += shift < 0 ? product >> -shift : product << shift;
    }
    return angle < 0 ? 0 - quarters : quarters;
}

}  // namespace aqorb
}  // namespace cv
