// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "precomp.hpp"

#include "point_sequence.hpp"

namespace cv
{
namespace aqorb
{
namespace stages
{

// Floats that are not negative have the order of their bits, so no branches are needed.
bool areSortedByTies(const std::vector<LeafPoint>& points)
{
    const uint64 SIGNS = uint64(0x80000000u) << 32 | 0x80000000u;
    uint64 before = 0, all = 0;
    bool sorted = true;
    for (size_t i = 0; i < points.size(); i++)
    {
        Cv32suf x, y;
        x.f = points[i].x;
        y.f = points[i].y;
        const uint64 bits = uint64(y.u) << 32 | x.u;
        sorted &= (i == 0) | (before < bits);
        all |= bits;
        before = bits;
    }
    return sorted && (all & SIGNS) == 0;
}

}  // namespace stages
}  // namespace aqorb
}  // namespace cv
