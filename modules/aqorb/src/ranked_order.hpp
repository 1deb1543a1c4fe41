// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#ifndef OPENCV_AQORB_RANKED_ORDER_HPP
#define OPENCV_AQORB_RANKED_ORDER_HPP

#include "index_sort.hpp"
#include "quadtree.hpp"

#include <opencv2/core/utils/trace.hpp>

namespace cv
{
namespace aqorb
{

//! The region over which points are spread, and how.
struct RankRule
{
    Size size;      //!< of the region, in pixels
    double usable;  //!< the share of the region in which points may lie
    int quota;      //!< the number of points that the region is to have, > 0
    double radius;  //!< of the disc in which stronger points count, in units of sqrt(usable area / quota)
    double strengthWeight;  //!< exponent of the strength
};

//! A disc of leaves, that is, of cells of a grid.
struct LeafDisc
{
    //! The leaves at offsets (dx, dy) with dx^2 * cell.width^2 + dy^2 * cell.height^2 <= squaredRadius.
    //! @param squaredRadius 0 to 4 * 10^18
    //! @param side of the grid, in leaves
    void reset(const Size& cell, int64 squaredRadius, int side);

    std::vector<int> halfWidths;  //!< by |dy|: the greatest |dx|; both below the side of the grid
    int widest;                   //!< of the half widths
    int64 total;                  //!< leaves of the disc, with those that are too far away for any grid
};

//! A leaf has a representative if at most so many of its eight neighbors have a better point.
const int MOST_BETTER_NEIGHBORS = 2;

//! The points that represent their leaves, in the order of these.
struct Representatives
{
    std::vector<unsigned> leaves;
    std::vector<unsigned> points;  //!< their indices
};

//! Work space of the functions below.
struct RankedScratch
{
    std::vector<int> grid;       // by leaf, with a border: the key of its best point
    std::vector<unsigned> best;  // by leaf, with a border: that point
    std::vector<uchar> flags;
    // By strength: the representatives, their leaves and their ranks.
    std::vector<unsigned> byStrength, leaves;
    std::vector<int> ranks;
    std::vector<int> usableBefore, inside;
    LeafDisc disc;
    std::vector<uint64> bits, masks;  // of the grid in which ranks are counted, and of the disc
    std::vector<int> words;
    std::vector<uint64> keys;
    std::vector<unsigned> sorted;
    SortScratch sorting;
    // Of rankedOrder.
    Representatives representatives;
    std::vector<unsigned> others;
    std::vector<float> strengths;
};

/** Finds the leaves that represent their neighbourhood: those with a point where at most two of the eight leaves
 around have a better one. Of leaves with equally good points the first one counts as better.
 @param keys by leaf, row by row, in rows of side + 2 elements with a border of one element on each side: the key of its
 best point. INT_MIN stands for no point, and for the border.
 @param side of the grid, in leaves
 @param leaves their numbers in ascending order */
void representativeLeaves(const std::vector<int>& keys, int side, std::vector<uchar>& flags,
                          std::vector<unsigned>& leaves);

/** Finds the rank of leaves: the number of leaves before it in the list that lie within the disc around it.
 @param leaves numbers of leaves of a grid of side x side leaves, row by row
 @param depth log2 of side */
void leafRanks(const unsigned* leaves, size_t count, int depth, const LeafDisc& disc, RankedScratch& scratch,
               int* ranks);

/*  The order of RANKED_SELECTION depends on the distances between points and on their strengths, and so hardly on how the
 scene lies in the image. It is made in three steps. A caller whose strengths are costly finds them after the first step
 for the representatives only; rankedOrder does all three. */

/** 1. Each leaf is represented by its best point, unless three of the eight leaves around it have better ones.
 @param pointAt gives the LeafPoint of an index below count, so that a caller need not hold them all */
template <typename PointAt>
void findRepresentatives(size_t count, const PointAt& pointAt, int depth, RankedScratch& scratch,
                         Representatives& representatives)
{
    CV_TRACE_FUNCTION();
    const unsigned side = 1u << depth;
    // The grid has a border of one leaf.
    const auto inGrid = [=](unsigned leaf) { return leaf + 2 * (leaf >> depth) + side + 3; };
    scratch.grid.assign(size_t(side + 2) * (side + 2), INT_MIN);
    scratch.best.resize(scratch.grid.size());
    int* const grid = scratch.grid.data();
    unsigned* const best = scratch.best.data();
    for (size_t i = 0; i < count; i++)
    {
        // Without branches, which would be hard to predict. Of equal points the first one stays.
        const LeafPoint point = pointAt(i);
        const unsigned leaf = inGrid(point.leaf);
        const bool isBetter = point.key > grid[leaf];
        grid[leaf] = isBetter ? point.key : grid[leaf];
        best[leaf] = isBetter ? unsigned(i) : best[leaf];
    }
    representativeLeaves(scratch.grid, int(side), scratch.flags, representatives.leaves);
    representatives.points.clear();
    for (unsigned leaf : representatives.leaves)
        representatives.points.push_back(best[inGrid(leaf)]);
}

/** 2. The representatives come first. The rank of one is the number of stronger ones within a disc around it; where a part
 of the disc lies outside of the region, or is masked, the rank is scaled up. They come by (1 + rank) / strength^weight.
 @param leaves, strengths of the representatives
 @param power 4 if `strengths` are the fourth powers of the strengths, 1 if they are the strengths
 @param usable by leaf: whether points may lie there; empty: everywhere
 @param order gets indices of the list of representatives */
void orderRepresentatives(const std::vector<unsigned>& leaves, const std::vector<float>& strengths, int power,
                          int depth, const std::vector<uchar>& usable, const RankRule& rule,
                          RankedScratch& scratch, std::vector<unsigned>& order);

//! 3. The other points follow by their place in their leaf, then by their keys.
//! @param representatives indices of points, in any order
void orderOthers(const std::vector<LeafPoint>& points, const std::vector<unsigned>& representatives,
                 RankedScratch& scratch, std::vector<unsigned>& others);

//! Puts points in order whose keys are those of their strengths.
//! @param order gets the indices of the points
void rankedOrder(const std::vector<LeafPoint>& points, int depth, const RankRule& rule,
                 RankedScratch& scratch, std::vector<unsigned>& order);

//! For tests: log2(v) in units of 2^-24, for v > 0 and finite, as orderRepresentatives computes it.
int64 binaryLogarithm(float v);

// ---- for the kernel: plain structs only, see types.hpp ---------------------------------------

//! A grid of bits with a border. Each word holds 32 bits of a row and, in its upper half, those of the next row. The next
//! word begins 16 bits later, so a word holds any 17 neighbouring bits of both rows.
struct RankingGrid
{
    uint64* bits;
    int depth;         //!< leaves have 2^depth columns
    int stride;        //!< words of a row
    int left, top;     //!< width of the border, in bits and rows
    const int* words;  //!< the disc: offsets from the word that holds the column `left` bits before the leaf
    const uint64* masks;  //!< the disc: which bits of each of these words count
    int wordCount;
};

}  // namespace aqorb
}  // namespace cv

#endif
