// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#ifndef OPENCV_AQORB_RANKING_HPP
#define OPENCV_AQORB_RANKING_HPP

#include "types.hpp"

namespace cv
{
namespace aqorb
{
namespace stages
{

//! A disc of leaves, that is, of cells of a grid.
struct LeafDisc
{
    //! The leaves at offsets (dx, dy) with dx^2 * cell.width^2 + dy^2 * cell.height^2 <= squaredRadius.
    void begin(const Size& cell, int64 squaredRadius, int side);

    std::vector<int> halfWidths;  //!< by |dy|: the greatest |dx|
    int widest;                   //!< of the half widths
    int total;                    //!< leaves of the disc
};

//! Work space of leafRanks.
struct RankingScratch
{
    std::vector<uint64> bits, masks;
    std::vector<int> words;
};

/** Finds the leaves that represent their neighbourhood: those with a point of which at most one of the eight leaves around
 has a stronger one. Of leaves with equally strong points the first one counts as stronger.
 @param strengths by leaf, row by row, in rows of side + 2 elements with a border of one element on each side. A greater
 number is stronger; INT_MIN stands for no point, and for the border.
 @param side of the grid, in leaves
 @param leaves their numbers in ascending order */
void representativeLeaves(const std::vector<int>& strengths, int side, std::vector<uchar>& flags,
                          std::vector<unsigned>& leaves);

/** Finds the rank of leaves: the number of leaves before it in the list that lie within the disc around it.
 @param leaves numbers of leaves of a grid of side x side leaves, row by row
 @param depth log2 of side */
void leafRanks(const unsigned* leaves, size_t count, int depth, const LeafDisc& disc, RankingScratch& scratch,
               int* ranks);

// ---- for the kernel: plain structs only, see types.hpp ---------------------------------------

//! A grid of bits with a border, in which each word holds 64 bits of a row, and the next word begins 32 bits later. So a
//! word holds any 33 neighbouring bits.
struct RankingGrid
{
    uint64* bits;
    int depth;          //!< leaves have 2^depth columns
    int stride;         //!< words of a row
    int left, top;      //!< width of the border, in bits and rows
    const int* words;   //!< the disc: offsets from the word that holds the column `left` bits before the leaf
    const uint64* masks;  //!< the disc: which bits of each of these words count
    int wordCount;
};

}  // namespace stages
}  // namespace aqorb
}  // namespace cv

#endif
