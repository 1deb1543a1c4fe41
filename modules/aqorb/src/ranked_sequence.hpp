// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#ifndef OPENCV_AQORB_RANKED_SEQUENCE_HPP
#define OPENCV_AQORB_RANKED_SEQUENCE_HPP

#include "index_sort.hpp"
#include "point_sequence.hpp"
#include "quadtree.hpp"
#include "ranking.hpp"

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

//! The contribution of a column and of a row of leaves to the number of a leaf, which is their sum.
inline unsigned leafColumn(int column)
{
    return unsigned(column + 1);
}
inline unsigned leafRow(int row, int depth)
{
    return unsigned(row + 1) * ((1u << depth) + 2);
}
//! By column and row of a region: what they contribute to the number of their leaf.
void numberLeaves(const Size& region, int depth, LeafScratch& scratch);

//! The points of a sequence, by their index, which grows in the order of TieBefore.
class PointSource
{
public:
    virtual ~PointSource() {}
    virtual size_t count() const = 0;
    //! A point with its strength as the response; its leaf need not be set.
    virtual LeafPoint point(size_t index) const = 0;
    virtual unsigned leaf(const LeafPoint& point) const = 0;
    //! The response that a point is to have when it is given.
    virtual float response(const LeafPoint& point) const = 0;
};

//! Points in a vector, whose strength is their response.
class PointList : public PointSource
{
public:
    explicit PointList(std::vector<LeafPoint>& points_) : points(points_) {}
    //! Sorts the points, if they are not sorted yet. It must be called once they are complete.
    void sort();
    size_t count() const CV_OVERRIDE { return points.size(); }
    LeafPoint point(size_t index) const CV_OVERRIDE { return points[index]; }
    unsigned leaf(const LeafPoint& point) const CV_OVERRIDE { return point.leaf; }
    float response(const LeafPoint& point) const CV_OVERRIDE { return point.response; }

private:
    std::vector<LeafPoint>& points;
};

//! Work space of a RankedSequence from begin to rank.
struct RankedScratch
{
    std::vector<int> grid;       // by leaf, with a border: how strong its best point is
    std::vector<unsigned> best;  // by leaf, with a border: that point
    std::vector<uchar> flags;
    // Of the representatives, in the order of their leaves: leaf, row by row, point and numbers.
    std::vector<unsigned> leaves, points;
    std::vector<float> strengths, responses;
    // Of the representatives, by strength: which one, its leaf and its rank.
    std::vector<unsigned> byStrength, ranked;
    std::vector<int> ranks;
    std::vector<unsigned> candidates;  // which of those may be among the first
    // Of the first one of each block of those: the part of the strength in the key, and, in any order, the key.
    std::vector<int64> strengthsOfBlocks, keysOfBlocks;
    std::vector<int> usableBefore, inside;
    LeafDisc disc;
    RankingScratch ranking;
    std::vector<uint64> numbers;  // to sort by
    std::vector<unsigned> sorted;
    SortScratch sorting;
};

/** Gives points in an order that depends on the distances between points and on their strengths, and so hardly on how
 the scene lies in the image. Each leaf of a quadtree is represented by its strongest point, unless two of the leaves
 around it have stronger ones. The rank of a representative is the number of stronger ones within a disc around it;
 where a part of the disc lies outside of the region, the rank is scaled up. The representatives come first, by
 (1 + rank) / strength^weight. The other points follow by their place in their leaf, then by strength.
 An object can be used again, and then needs no new memory. */
class RankedSequence : public PointSequence
{
public:
    RankedSequence()
        : depth(0), source(0), scratch(0), given(0), takesAll(false), isCutShort(false), hasOthers(false)
    {
    }
    //! Starts a sequence in a quadtree of the given depth, at most maxRankedDepth. The points must stay until the last one
    //! was given, the work space until they are ranked.
    void begin(int depth, const PointSource& points, RankedScratch& scratch);
    //! Adds the points, in their order.
    void addAll();
    //! Finds the representatives, when all points have been added.
    void findRepresentatives();
    //! The points of the representatives, in the order of their leaves.
    const std::vector<unsigned>& representatives() const { return scratch->points; }
    //! The strength of a representative by which it is ranked, and the response with which it is given; at first both are
    //! the strength of its point.
    float& strength(size_t index) { return scratch->strengths[index]; }
    float& response(size_t index) { return scratch->responses[index]; }
    /** Ranks the representatives. It must be called once before next.
     @param power of the strength that the strengths of the representatives are: 1 or 4
     @param usable by leaf, row by row: whether points may lie there; empty: everywhere
     @param enough if there are far more representatives than that, the sequence may end after about as many, see
     endsEarly */
    void rank(const RankRule& rule, int power, const std::vector<uchar>& usable, size_t enough = SIZE_MAX);
    //! Starts a sequence of points that are not ranked, for a caller that takes all of them.
    void beginUnranked(const PointSource& points, const std::vector<RankedCorner>& responses);
    void willTake(size_t count) CV_OVERRIDE { takesAll = count >= source->count() - given; }
    bool next(LeafPoint& point, const PointFilter* filter = 0) CV_OVERRIDE;
    //! Whether the sequence ends before the last point.
    bool endsEarly() const { return isCutShort; }
    //! How many points have been given or passed over.
    size_t passed() const { return given; }
    //! Goes on after so many points, which another beginning of the same sequence has given or passed over.
    void goOnAfter(size_t passed) { given = passed; }

    //! Adds points one by one, which is what addAll does, for a caller that has them at hand.
    class Adder
    {
    public:
        explicit Adder(RankedSequence& sequence)
            : grid(sequence.scratch->grid.data()), best(sequence.scratch->best.data())
        {
        }
        //! @param strength the order of the response
        void add(unsigned leaf, int strength, size_t index)
        {
            // Without branches, which would be hard to predict. Of equal points the first one stays.
            const bool isBetter = strength > grid[leaf];
            grid[leaf] = isBetter ? strength : grid[leaf];
            best[leaf] = isBetter ? unsigned(index) : best[leaf];
        }

    private:
        int* grid;
        unsigned* best;
    };

private:
    struct Entry
    {
        unsigned point;
        float response;
    };
    struct KeyRule;
    void sortByStrength();
    int64 keyOf(size_t index, int64 ofStrength, const KeyRule& rule) const;
    int64 findCandidates(const KeyRule& rule, size_t enough);
    void sortByKeys(const KeyRule& rule, size_t enough);
    void countUsable(const std::vector<uchar>& usable);
    void countInside();
    int leavesInside(int column, int row) const;
    void listOthers();
    void numberByPlaces();

    int depth;
    const PointSource* source;
    RankedScratch* scratch;
    std::vector<Entry> entries;    // the representatives, in their order
    std::vector<unsigned> others;  // the other points, in their order
    // Work space of listOthers.
    std::vector<uchar> isRepresentative;  // by point
    std::vector<uint64> placeNumbers;     // by point
    std::vector<unsigned> byPlace;
    SortScratch sorting;
    size_t given;
    bool takesAll, isCutShort, hasOthers;
};

}  // namespace stages
}  // namespace aqorb
}  // namespace cv

#endif
