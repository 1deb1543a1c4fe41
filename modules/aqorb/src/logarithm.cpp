// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "precomp.hpp"

#include "logarithm.hpp"

namespace cv
{
namespace aqorb
{
namespace stages
{

BinaryLogarithm::BinaryLogarithm()
{
    for (int i = 0; i < SIZE; i++)
    {
        // A number in [1, 2) with 62 bits of fraction. Each squaring yields one more bit of its logarithm.
        uint64 v = uint64(SIZE + i) << (62 - SIZE_BITS);
        int logarithm = 0;
        for (int bit = 0; bit < TABLE_BITS; bit++)
        {
            const uint64 high = v >> 32, low = v & 0xffffffff;
            v = 4 * high * high + (high * low >> 29) + (low * low >> 62);
            const int isTwoOrMore = int(v >> 63);
            logarithm = 2 * logarithm + isTwoOrMore;
            v >>= isTwoOrMore;
        }
        table[i] = logarithm;
    }
    table[SIZE] = 1 << TABLE_BITS;
}

const BinaryLogarithm& BinaryLogarithm::shared()
{
    static const BinaryLogarithm logarithm;
    return logarithm;
}

}  // namespace stages
}  // namespace aqorb
}  // namespace cv
