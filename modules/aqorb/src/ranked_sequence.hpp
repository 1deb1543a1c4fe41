// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#ifndef OPENCV_AQORB_RANKED_SEQUENCE_HPP
#define OPENCV_AQORB_RANKED_SEQUENCE_HPP

#include "quadtree.hpp"
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

//! The smallest depth with 16 leaves for each point that the region is to have, but not so deep that leaves become
//! shorter than 2 pixels.
int rankedDepth(Size size, double usable, int quota);
//! The greatest depth that rankedDepth returns for a region.
int maxRankedDepth(Size size);

//! log2 of a number > 0 that is finite, as a fixed-point number with 24 bits of fraction. It is computed in integers,
//! so it is the same on every CPU.
int64 binaryLogarithm(float v);

//! Assigns corners, all of them inside the root, to the leaves of a quadtree, which are numbered row by row.
void leafCells(const std::vector<RankedCorner>& corners, const Rect& root, int depth, LeafScratch& scratch,
               std::vector<LeafPoint>& points);

/** Gives points in an order that depends on the distances between points and on their strengths, and so hardly on how
 the scene lies in the image. Each leaf of a quadtree is represented by its strongest point. The rank of such a point is
 the number of stronger ones within a disc around it; where a part of the disc lies outside of the region, the rank is
 scaled up. The representatives come first, by (1 + rank) / strength^weight. The other points follow by their place in
 their leaf, then by strength.
 An object can be used again, and then needs no new memory. */
class RankedSequence : public PointSequence
{
public:
    RankedSequence() : depth(0), given(0), sorted(0), hasOthers(false) {}
    /** Starts a sequence and finds the representatives.
     @param points in leaves that are numbered row by row. They are swapped in, so the caller's vector has any content
     afterwards. It is fastest for points in raster order.
     @param strengths by the index of the points. NaN ranks last.
     @param depth at most MAX_RANKED_DEPTH */
    void begin(std::vector<LeafPoint>& points, const std::vector<float>& strengths, int depth);
    //! The representatives, in the order of their leaves.
    const std::vector<LeafPoint>& representatives() const { return chosen; }
    /** Ranks the representatives. It must be called once before next.
     @param scores the strengths of the representatives, which replace those given to begin
     @param usable by leaf: whether points may lie there; empty: everywhere */
    void rank(const std::vector<float>& scores, const RankRule& rule, const std::vector<uchar>& usable);
    bool next(LeafPoint& point, const PointFilter* filter = 0) CV_OVERRIDE;

private:
    // A representative in the order of the sequence.
    struct Entry
    {
        bool operator<(const Entry& other) const
        {
            if (key != other.key)
                return key < other.key;
            return strength != other.strength ? strength > other.strength : index < other.index;
        }
        int64 key;
        int strength;    // orders strengths
        unsigned index;  // of the representative
    };
    void sortMore();
    void listOthers();

    int depth;
    std::vector<LeafPoint> points, chosen;
    std::vector<float> strengths;
    std::vector<uint64> best;  // by leaf
    std::vector<int> grid;     // by leaf, with a border
    std::vector<int> scoreOrder;
    std::vector<int> usableBefore;
    std::vector<Entry> entries;
    std::vector<LeafPoint> others;
    size_t given, sorted;
    bool hasOthers;
};

//! Starts a sequence of points whose strength is their response.
void orderByResponse(std::vector<LeafPoint>& points, int depth, const RankRule& rule, RankedSequence& sequence);

}  // namespace stages
}  // namespace aqorb
}  // namespace cv

#endif
