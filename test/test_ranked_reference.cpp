// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "reference.hpp"

#include <limits>

// The reference of RANKED_SELECTION decides what is right, so its order is checked by examples worked out by hand.

namespace opencv_test
{
namespace
{

using reference::LeafCorner;
using reference::RankedRule;

typedef std::vector<int> Ints;

const float INF = std::numeric_limits<float>::infinity();
const float NOT_A_NUMBER = std::numeric_limits<float>::quiet_NaN();

//! Corners in leaves, of which the order is asked.
class Order
{
public:
    explicit Order(const RankedRule& rule_) : rule(rule_) {}
    //! Adds a corner with its place in the leaf, in units that are finer than a leaf.
    Order& add(int column, int row, float strength, float x = 0, float y = 0)
    {
        corners.push_back({column, row, x, y, strength, int(corners.size())});
        return *this;
    }
    Order& maskLeaf(int column, int row)
    {
        masked.push_back(Point(column, row));
        return *this;
    }
    Ints get() const
    {
        return rankedSequence(
            corners, rule,
            [this](int column, int row)
            { return std::find(masked.begin(), masked.end(), Point(column, row)) == masked.end(); },
            [](const LeafCorner& corner) { return corner.base; });
    }

private:
    RankedRule rule;
    std::vector<LeafCorner> corners;
    std::vector<Point> masked;
};

//! 4 x 4 leaves, and a disc of a leaf and its four neighbours.
RankedRule crossRule(double strengthWeight)
{
    return {Size(100, 100), 2, 1, 16, 1, strengthWeight, 1 << 18};
}

TEST(Aqorb_RankedReference, ranks_by_hand)
{
    // In a row 4, 8, 16, and 2 far away. Nothing is stronger near 16 and 2. Near 8 there is one, and 4 of the 5
    // leaves of its disc are inside: 1 + r = 1 + 5/4. Near 4, in the corner, it is 1 + 5/3.
    Order order(crossRule(0));
    order.add(0, 0, 4).add(1, 0, 8).add(3, 3, 2).add(2, 0, 16);
    EXPECT_EQ(order.get(), Ints({3, 2, 1, 0}));
    // By (1 + r)^4 / S, as S is a fourth power. Now 1/8 is the strongest: 8 and, far away, 17. The two beside it have
    // 16 * (9/4)^4 = 410 and 64 * (8/3)^4 = 3236.
    Order weighted(crossRule(1));
    weighted.add(0, 0, 1 / 64.f).add(1, 0, 1 / 8.f).add(3, 3, 1 / 17.f).add(2, 0, 1 / 16.f);
    EXPECT_EQ(weighted.get(), Ints({1, 2, 3, 0}));
}

TEST(Aqorb_RankedReference, weight_by_hand)
{
    // A corner of strength 4^4 beside one of 3^4, and one of 1.1^4 far away. By (1 + r) / s^P they have 1 / 4^P, 2 / 3^P
    // and 1 / 1.1^P. The last two are equal if (3 / 1.1)^P = 2, which is P = .691.
    for (double P : {0., 0.5, 0.68, 0.70, 1., 1000.})
    {
        Order order(crossRule(P));
        order.add(3, 0, std::pow(1.1f, 4.f)).add(1, 2, 256.f).add(2, 2, 81.f);
        EXPECT_EQ(order.get(), P < 0.69 ? Ints({1, 0, 2}) : Ints({1, 2, 0})) << P;
    }
}

TEST(Aqorb_RankedReference, masked_leaves_are_no_part_of_the_disc)
{
    // 1 at (1, 2) beside 2 at (1, 3): 1 + 5/5. 8 at (1, 0) beside 16 at (2, 0): 1 + 5/4.
    Order order(crossRule(0));
    order.add(1, 2, 1).add(1, 3, 2).add(1, 0, 8).add(2, 0, 16);
    EXPECT_EQ(order.get(), Ints({3, 1, 0, 2}));
    // With two leaves masked it is 1 + 5/3 for the first.
    order.maskLeaf(0, 2).maskLeaf(2, 2);
    EXPECT_EQ(order.get(), Ints({3, 1, 2, 0}));

    // The leaf of a representative counts even if its centre is masked.
    Order masked(crossRule(0));
    masked.add(1, 2, 1).add(1, 3, 2).add(1, 0, 8).add(2, 0, 16).maskLeaf(1, 2).maskLeaf(1, 3);
    EXPECT_EQ(masked.get(), Ints({3, 1, 0, 2}));
}

TEST(Aqorb_RankedReference, disc_reaches_as_far_as_its_radius)
{
    // 16 x 16 leaves of 12.5 x 6.25 pixels. With quota 8 and half of the area usable the spacing is
    // sqrt(100 * 100 / 8) pixels, so that its square is 8 squared widths or 32 squared heights.
    struct Case
    {
        int dx, dy;
        double squaredRadius;
    };
    const Case cases[] = {{2, 0, 4 / 8.}, {0, 5, 25 / 32.}, {2, 4, 1.},
                          {-2, -4, 1.},   {3, 0, 9 / 8.},   {1, -6, 40 / 32.}};
    for (const Case& c : cases)
        for (int side = -1; side <= 1; side += 2)
        {
            SCOPED_TRACE(format("%d, %d, %d", c.dx, c.dy, side));
            RankedRule rule = {Size(200, 100), 4, 0.5, 8, 0, 0, 1 << 18};
            rule.rankRadius = std::sqrt(c.squaredRadius) + side * 1e-9;
            Order order(rule);
            order.add(8, 8, 5).add(8 + c.dx, 8 + c.dy, 6).add(15, 15, 4);  // The last one is alone.
            EXPECT_EQ(order.get(), side > 0 ? Ints({1, 2, 0}) : Ints({1, 0, 2}));
        }
    // R = 0: every leaf is alone.
    RankedRule alone = crossRule(0);
    alone.rankRadius = 0;
    Order order(alone);
    order.add(0, 0, 4).add(1, 0, 8).add(3, 3, 2).add(2, 0, 16);
    EXPECT_EQ(order.get(), Ints({3, 1, 0, 2}));
}

TEST(Aqorb_RankedReference, strengths_that_are_no_numbers_or_not_positive)
{
    // With R = 0 every rank is 0. No leaf has a neighbour.
    RankedRule rule = crossRule(0.15);
    rule.depth = 4;
    rule.rankRadius = 0;
    const float strengths[] = {NOT_A_NUMBER, 1.f, 0.f, INF, -1.f, -INF, 1e-42f, -0.f, INF, 2.f, NOT_A_NUMBER};
    Order order(rule), even(RankedRule({Size(100, 100), 4, 1, 16, 0, 0, 1 << 18}));
    for (int i = 0; i < 11; i++)
    {
        order.add(2 * (i % 8), 2 * (i / 8), strengths[i]);
        even.add(2 * (i % 8), 2 * (i / 8), strengths[i]);
    }
    EXPECT_EQ(order.get(), Ints({3, 8, 9, 1, 6, 2, 7, 4, 5, 0, 10}));
    EXPECT_EQ(even.get(), Ints({3, 8, 9, 1, 6, 2, 7, 4, 5, 0, 10}));

    // Infinity comes first whatever its rank, and zero last; with P = 0 the ranks decide.
    for (double P : {0.15, 0.})
    {
        Order ranked(crossRule(P));
        ranked.add(0, 0, INF).add(1, 0, INF).add(3, 3, 0.f).add(2, 3, 5.f).add(0, 3, 7.f);
        EXPECT_EQ(ranked.get(), P > 0 ? Ints({0, 1, 4, 3, 2}) : Ints({0, 4, 3, 1, 2})) << P;
    }
}

TEST(Aqorb_RankedReference, no_more_than_two_better_neighbours)
{
    // In a row 2.5, 3, 2, below the last two of them 1, which is passed over, and beside that one 4. 1 + r is 1 + 5/3,
    // 1, 1 + 5/4, and 1.
    Order order(crossRule(0));
    order.add(0, 0, 2.5f).add(1, 0, 3).add(2, 0, 2).add(2, 1, 1).add(3, 2, 4);
    EXPECT_EQ(order.get(), Ints({4, 1, 2, 0, 3}));
    // Nothing represents the leaf below. If it is masked, the third has 1 + 5/3, too.
    order.maskLeaf(2, 1);
    EXPECT_EQ(order.get(), Ints({4, 1, 0, 2, 3}));

    // Of four equal ones beside each other the first three in raster order stay.
    Order equal(crossRule(0));
    equal.add(1, 1, 5).add(0, 1, 5).add(1, 0, 5).add(0, 0, 5).add(3, 3, 5);
    EXPECT_EQ(equal.get(), Ints({3, 4, 2, 1, 0}));
    // Passed-over ones come before the second of any leaf, by their base.
    Order mixed(crossRule(0.15));
    mixed.add(0, 0, 9, 1, 1).add(0, 0, 8, 2, 1).add(1, 0, 7, 30, 1).add(0, 1, 5, 1, 30).add(1, 1, 6, 30, 30);
    EXPECT_EQ(mixed.get(), Ints({0, 4, 2, 3, 1}));
}

TEST(Aqorb_RankedReference, the_others_follow_by_their_place_in_the_leaf)
{
    Order order(crossRule(0.15));
    order.add(0, 0, 9, 1, 1).add(0, 0, 8, 2, 1).add(0, 0, 7, 3, 1);  // one leaf: first, second, third
    order.add(3, 3, 2, 70, 5).add(3, 3, 2, 71, 4);                   // The one of lower y is the first.
    order.add(0, 3, 2, 80, 4).add(0, 3, 2, 72, 4);                   // of lower x
    order.add(3, 0, 1, 5, 5).add(3, 0, 1, 5, 5);                     // of lower index
    order.add(2, 1, NOT_A_NUMBER, 1, 9).add(2, 1, -INF, 2, 9);
    EXPECT_EQ(order.get(), Ints({0, 6, 4, 7, 10, /* second */ 1, 5, 3, 8, 9, /* third */ 2}));
}

}  // namespace
}  // namespace opencv_test
