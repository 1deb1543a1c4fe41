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
    double strengthWeight;  //!< exponent of the strength
};

//! How the corners of a level are put in the order of selection.
struct OrderRule
{
    Rect root;      //!< of the quadtree: the region between the borders
    int depth;      //!< of the quadtree
    bool isRanked;  //!< true: by a RankedSequence; false: by a BalancedSequence
    RankRule rank;  //!< of a RankedSequence
};

//! The smallest depth with 12 leaves for each point that the region is to have, but not so deep that leaves become
//! shorter than 2 pixels.
int rankedDepth(Size size, double usable, int quota);
//! The greatest depth that rankedDepth returns for a region.
int maxRankedDepth(Size size);

//! log2 of a number > 0 that is finite, as a fixed-point number with 24 bits of fraction. It is computed in integers,
//! so it is the same on every CPU.
int64 binaryLogarithm(float v);

/** Gives points in an order that depends on the distances between points and on their strengths, and so hardly on how
 the scene lies in the image. Each leaf of a quadtree is represented by its strongest point, unless two of the leaves
 around it have stronger ones. The rank of a representative is the number of stronger ones within a disc around it;
 where a part of the disc lies outside of the region, the rank is scaled up. The representatives come first, by
 (1 + rank) / strength^weight. The other points follow by their place in their leaf, then by strength.
 An object can be used again, and then needs no new memory. */
class RankedSequence : public PointSequence
{
public:
    RankedSequence() : depth(0), count(0), given(0), sorted(0), firstSorted(0), hasOthers(false) {}
    //! Starts a sequence of at most `size` points in a quadtree of the given depth, at most maxRankedDepth.
    void begin(int depth, size_t size);
    //! The contribution of a column and of a row of leaves to the number of a leaf, which is their sum.
    unsigned leafColumn(int column) const { return unsigned(column + 1); }
    unsigned leafRow(int row) const { return unsigned(row + 1) * ((1u << depth) + 2); }
    //! Adds the next point by TieBefore. Its response is its strength; NaN ranks last.
    void add(const LeafPoint& point)
    {
        const int strength = orderOf(point.response);
        // Without branches, which would be hard to predict. Of equal points the first one stays.
        const bool isBetter = strength > grid[point.leaf];
        grid[point.leaf] = isBetter ? strength : grid[point.leaf];
        best[point.leaf] = isBetter ? unsigned(count) : best[point.leaf];
        points[count++] = point;
    }
    //! Finds the representatives, when all points have been added.
    void findRepresentatives();
    //! The representatives, in the order of their leaves.
    const std::vector<LeafPoint>& representatives() const { return chosen; }
    //! The strength of a representative by which it is ranked; at first it is that of its point.
    float& strength(size_t index) { return strengths[index]; }
    /** Ranks the representatives. It must be called once before next.
     @param power of the strength that the strengths of the representatives are: 1 or 4
     @param usable by leaf, row by row: whether points may lie there; empty: everywhere */
    void rank(const RankRule& rule, int power, const std::vector<uchar>& usable);
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
    // A whole number that orders strengths as their values do. NaN comes before all others, and none is INT_MIN.
    static int orderOf(float strength)
    {
        Cv32suf bits;
        bits.f = strength + 0.f;  // makes -0 equal to 0
        return strength == strength ? bits.i ^ ((bits.i >> 31) & INT_MAX) : INT_MIN + 1;
    }
    static uint64 keyOf(float strength, size_t index)
    {
        // Never 0. Of equally strong points the one of lower index has the greater key.
        return uint64(unsigned(orderOf(strength)) ^ 0x80000000u) << 32 | unsigned(~index);
    }
    static unsigned indexOf(uint64 key) { return ~unsigned(key); }
    struct StrongerInLeaf
    {
        bool operator()(const LeafPoint& a, const LeafPoint& b) const;
    };
    void sortByStrength();
    int leavesInside(int column, int row) const;
    void sortMore();
    void listOthers();

    int depth;
    size_t count;  // of points
    std::vector<LeafPoint> points, chosen, others;
    std::vector<float> strengths;
    std::vector<int> grid;                     // by leaf, with a border: how strong its best point is
    std::vector<unsigned> best;                // by leaf, with a border: that point
    std::vector<uchar> flags;                  // work space
    std::vector<uint64> byStrength, resorted;  // keys of the representatives; work space
    std::vector<unsigned> leaves,
        ranked;  // of the representatives, in their order and by strength, row by row
    std::vector<int> ranks, usableBefore;
    LeafDisc disc;
    RankingScratch ranking;
    std::vector<Entry> entries;
    size_t given, sorted, firstSorted;
    bool hasOthers;
};

//! By column and row of a region: what they contribute to the number of their leaf.
void numberLeaves(const Size& region, int depth, const RankedSequence& sequence, LeafScratch& scratch);

//! Adds points in any order whose strength is their response to a sequence that has begun, and ranks them.
void orderByResponse(std::vector<LeafPoint>& points, const RankRule& rule, RankedSequence& sequence);

}  // namespace stages
}  // namespace aqorb
}  // namespace cv

#endif
