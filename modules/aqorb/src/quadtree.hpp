// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#ifndef OPENCV_AQORB_QUADTREE_HPP
#define OPENCV_AQORB_QUADTREE_HPP

#include "types.hpp"

namespace cv
{
namespace aqorb
{

//! A point that is to be put in order. Points come in the order that breaks ties.
struct LeafPoint
{
    unsigned leaf;  //!< as LeafGrid numbers it
    int key;        //!< the greater, the better: a FAST score, or the sortKey of a response
};

//! The leaves of a quadtree over a region: 2^depth columns and rows, numbered row by row.
class LeafGrid
{
public:
    //! The same grid again takes no time.
    void reset(const Rect& region_, int depth_)
    {
        if (region == region_ && depth == depth_)
            return;
        region = Rect();  // it stays invalid if memory runs out below
        depth = depth_;
        columns.resize(region_.width);
        for (int x = 0; x < region_.width; x++)
            columns[x] = index(x, region_.width, depth);
        rows.resize(region_.height);
        for (int y = 0; y < region_.height; y++)
            rows[y] = index(y, region_.height, depth) << depth;
        region = region_;
    }
    //! The leaf of a pixel of the region.
    unsigned leaf(int x, int y) const { return columns[x - region.x] + rows[y - region.y]; }
    //! The pixel in the centre of a leaf.
    Point centre(unsigned leaf) const
    {
        const int64 column = leaf & ((1u << depth) - 1), row = leaf >> depth;
        return region.tl() + Point(int(((2 * column + 1) * region.width) >> (depth + 1)),
                                   int(((2 * row + 1) * region.height) >> (depth + 1)));
    }
    //! The leaf of a position in a region that begins at (0, 0).
    static unsigned leafAt(const Point2f& position, const Size& region, int depth)
    {
        return index(position.x, region.width, depth) | index(position.y, region.height, depth) << depth;
    }

private:
    //! Where a position on an axis of so many pixels lies: floor(position * 2^depth / length).
    static unsigned index(double position, int length, int depth)
    {
        return unsigned(position * (1 << depth) / length);
    }

    Rect region;
    int depth = 0;
    std::vector<unsigned> columns, rows;  // by pixel: what it contributes to the number of its leaf
};

}  // namespace aqorb
}  // namespace cv

#endif
