// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#ifndef OPENCV_AQORB_POINT_SEQUENCE_HPP
#define OPENCV_AQORB_POINT_SEQUENCE_HPP

#include "types.hpp"

#include <climits>
#include <limits>

namespace cv
{
namespace aqorb
{
namespace stages
{

//! A point in a leaf of the quadtree.
struct LeafPoint
{
    unsigned leaf;   //!< Morton code of the leaf
    float response;  //!< the strength that orders points; NaN ranks last
    float x, y;      //!< break ties: lower y first, then lower x, then lower index
    int index;       //!< of the point for the caller
};

//! Decides which points a sequence passes over.
class PointFilter
{
public:
    virtual ~PointFilter() {}
    virtual bool accepts(const LeafPoint& point) const = 0;
};

//! Points in the order in which they are to be chosen.
class PointSequence
{
public:
    virtual ~PointSequence() {}
    //! Announces that at most so many points are taken. Where that is all there are, their order does not matter.
    virtual void willTake(size_t) {}
    //! The next point; false if there is none. Points that the filter rejects are passed over. The filter must always
    //! give the same answer for a point.
    virtual bool next(LeafPoint& point, const PointFilter* filter = 0) = 0;
};

//! A whole number that orders responses as their values do. NaN comes before all others, and none is INT_MIN.
inline int orderOf(float response)
{
    Cv32suf bits;
    bits.f = response + 0.f;  // makes -0 equal to 0
    return response == response ? bits.i ^ ((bits.i >> 31) & INT_MAX) : INT_MIN + 1;
}
//! The same for a FAST score.
inline int orderOfScore(int score)
{
    Cv32suf bits;
    bits.f = float(score);  // neither negative nor NaN
    return bits.i;
}
//! The response, but a NaN for any NaN, and 0 for -0.
inline float responseOf(int order)
{
    if (order == INT_MIN + 1)
        return std::numeric_limits<float>::quiet_NaN();
    Cv32suf bits;
    bits.i = order ^ ((order >> 31) & INT_MAX);
    return bits.f;
}
//! The same as an unsigned number: never 0.
inline unsigned unsignedOrderOf(float response)
{
    return unsigned(orderOf(response)) ^ 0x80000000u;
}

//! The order of points that nothing else tells apart.
struct TieBefore
{
    bool operator()(const LeafPoint& a, const LeafPoint& b) const
    {
        if (a.y != b.y)
            return a.y < b.y;
        return a.x != b.x ? a.x < b.x : a.index < b.index;
    }
};

//! Whether points are sorted by TieBefore, as corners are. If a coordinate is negative, the answer is no.
bool areSortedByTies(const std::vector<LeafPoint>& points);

}  // namespace stages
}  // namespace aqorb
}  // namespace cv

#endif
