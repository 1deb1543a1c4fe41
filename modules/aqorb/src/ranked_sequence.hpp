// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#ifndef OPENCV_AQORB_RANKED_SEQUENCE_HPP
#define OPENCV_AQORB_RANKED_SEQUENCE_HPP

#include "quadtree.hpp"
#include "ranking.hpp"
#include "types.hpp"

namespace cv
{
namespace aqorb
{
namespace stages
{

//! The region over which a RankedSequence spreads points, and how.
struct RankRule
{
    Size size;      //!< of the region, in pixels
    double usable;  //!< the share of the region in which points may lie
    int quota;      //!< the number of points that the region is to have, > 0
    double radius;  //!< of the disc in which stronger points count, in units of sqrt(usable area / quota)
    int exponent;   //!< of the strength, in units of 2^-18
};

//! How the corners of a level are put in the order of selection.
struct OrderRule
{
    Rect root;  //!< of the quadtree: the region between the borders
    int depth;  //!< of the quadtree
    bool isRanked;  //!< true: by a RankedSequence; false: by a BalancedSequence
    RankRule rank;  //!< of a RankedSequence
};

//! The exponent of a strength that is the given power of the score that strengthWeight is for.
int strengthExponent(double strengthWeight, int power);

//! The smallest depth with 8 leaves for each point that the region is to have, but not so deep that leaves become
//! shorter than 2 pixels.
int rankedDepth(Size size, double usable, int quota);
//! The greatest depth that rankedDepth returns for a region.
int maxRankedDepth(Size size);

//! log2 of a number > 0 that is finite, as a fixed-point number with 24 bits of fraction. It is computed in integers,
//! so it is the same on every CPU.
int64 binaryLogarithm(float v);

//! Numbers the leaves row by row: for each column and row of the root what it adds to the number.
void numberLeaves(const Size& root, int depth, LeafScratch& scratch);

/** Gives points in an order that depends on the distances between points and on their strengths, and so hardly on how
 the scene lies in the image. Each leaf of a quadtree is represented by its strongest point, unless two of the leaves
 around it have stronger ones. The rank of a representative is the number of stronger ones within a disc around it;
 where a part of the disc lies outside of the region, the rank is scaled up. The representatives come first, by
 (1 + rank) / strength^weight. The other points follow by their place in their leaf, then by strength.
 An object can be used again, and then needs no new memory. */
class RankedSequence : public PointSequence
{
public:
    RankedSequence() : depth(0), given(0), sorted(0), firstSorted(0), hasOthers(false) {}
    /** Starts a sequence and finds the representatives.
     @param points sorted by TieBefore, in leaves that are numbered row by row; their responses are their strengths, of
     which NaN ranks last. They are swapped in, so the caller's vector has any content afterwards.
     @param depth of the quadtree, at most maxRankedDepth */
    void begin(std::vector<LeafPoint>& points, int depth);
    //! The representatives, in the order of their leaves.
    const std::vector<LeafPoint>& representatives() const { return chosen; }
    //! The strength of a representative by which it is ranked; at first it is that of its point.
    float& strength(size_t index) { return strengths[index]; }
    /** Ranks the representatives. It must be called once before next.
     @param usable by leaf: whether points may lie there; empty: everywhere */
    void rank(const RankRule& rule, const std::vector<uchar>& usable);
    bool next(LeafPoint& point, const PointFilter* filter = 0) CV_OVERRIDE;

private:
    // A representative in the order of the sequence.
    struct Entry
    {
        bool operator<(const Entry& other) const
        {
            return key != other.key ? key < other.key : place < other.place;
        }
        int64 key;
        unsigned place;  // among the representatives by strength
        unsigned index;  // of the representative
    };
    size_t cellOf(unsigned leaf) const
    {
        const unsigned side = 1u << depth;
        return size_t((leaf >> depth) + 1) * (side + 2) + (leaf & (side - 1)) + 1;
    }
    void sortByStrength();
    int leavesInside(int column, int row) const;
    void sortMore();
    void listOthers();

    int depth;
    std::vector<LeafPoint> points, chosen, others;
    std::vector<float> strengths;
    std::vector<int> grid;       // by leaf, with a border: how strong its best point is
    std::vector<unsigned> best;  // by leaf, with a border: that point
    std::vector<uchar> flags;
    std::vector<uint64> byStrength, other;  // keys of the representatives; work space
    std::vector<unsigned> leaves;           // of the representatives, at last by strength
    std::vector<int> ranks, usableBefore;
    LeafDisc disc;
    RankingScratch ranking;
    std::vector<Entry> entries;
    size_t given, sorted, firstSorted;
    bool hasOthers;
};

//! Starts a sequence of points in any order whose strength is their response, and ranks them.
void orderByResponse(std::vector<LeafPoint>& points, int depth, const RankRule& rule, RankedSequence& sequence);

}  // namespace stages
}  // namespace aqorb
}  // namespace cv

#endif
