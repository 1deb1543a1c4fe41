// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "precomp.hpp"

#include "quadtree.hpp"

namespace cv
{
namespace aqorb
{
namespace stages
{

void LeafGrid::reset(const Rect& region_, int depth_)
{
    region = region_;
    depth = depth_;
    columns.resize(region.width);
    for (int x = 0; x < region.width; x++)
        columns[x] = index(x, region.width, depth);
    rows.resize(region.height);
    for (int y = 0; y < region.height; y++)
        rows[y] = index(y, region.height, depth) << depth;
}

Point LeafGrid::centre(unsigned leaf) const
{
    const int64 column = leaf & ((1u << depth) - 1), row = leaf >> depth;
    return region.tl() + Point(int(((2 * column + 1) * region.width) >> (depth + 1)),
                               int(((2 * row + 1) * region.height) >> (depth + 1)));
}

}  // namespace stages
}  // namespace aqorb
}  // namespace cv
