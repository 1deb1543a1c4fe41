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
namespace stages
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
    LeafGrid() : depth(0) {}
    void reset(const Rect& region, int depth);
    //! The leaf of a pixel of the region.
    unsigned leaf(int x, int y) const { return columns[x - region.x] + rows[y - region.y]; }
    //! The pixel in the centre of a leaf.
    Point centre(unsigned leaf) const;
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
    int depth;
    std::vector<unsigned> columns, rows;  // by pixel: what it contributes to the number of its leaf
};

}  // namespace stages
}  // namespace aqorb
}  // namespace cv

#endif
