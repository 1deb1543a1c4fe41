// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "reference.hpp"

#include "balanced_sequence.hpp"
#include "quadtree.hpp"
#include "selection.hpp"

namespace opencv_test
{
namespace
{

using namespace aqorb::stages;

// Levels of which each is half the size of the one before, and whose corners lie on a line, best first.
class Levels
{
public:
    explicit Levels(const std::vector<int>& quotas)
    {
        for (size_t i = 0; i < quotas.size(); i++)
        {
            const OrderRule order = {Rect(0, 0, 256 >> i, 256 >> i), 0, false, RankRule()};
            const SelectionLevel level = {order.root.size(), float(1 << i), quotas[i], order};
            levels.push_back(level);
        }
    }
    // Corners of a level at (0, row), (step, row), ...
    static std::vector<RankedCorner> line(int count, int row, int step)
    {
        std::vector<RankedCorner> corners;
        for (int i = 0; i < count; i++)
        {
            const RankedCorner corner = {i * step, row, float(100 - i)};
            corners.push_back(corner);
        }
        return corners;
    }
    void begin(FeatureSelector& selector, double octaveSuppression) const
    {
        selector.begin(Size(256, 256), octaveSuppression, int(levels.size()));
        for (const SelectionLevel& level : levels)
            selector.addLevel(level);
    }
    void beginSequence(int level, const std::vector<RankedCorner>& corners, BalancedSequence& sequence) const
    {
        LeafScratch scratch;
        std::vector<LeafPoint> points;
        leafPoints(corners, levels[level].order.root, levels[level].order.depth, scratch, points);
        sequence.begin(points, levels[level].order.depth);
    }

private:
    std::vector<SelectionLevel> levels;
};

TEST(Aqorb_Selection, asks_for_nothing_more_where_quotas_are_met)
{
    const Levels levels({3, 2});
    FeatureSelector selector;
    levels.begin(selector, 0);
    CornerRequest request;
    for (int level = 1; level >= 0; level--)  // from coarse to fine
    {
        ASSERT_EQ(selector.wantsOf(level), level == 1 ? 2 : 3);
        BalancedSequence sequence;
        levels.beginSequence(level, Levels::line(9, 5, 10), sequence);
        selector.offer(sequence);
        EXPECT_EQ(selector.count(level), level == 1 ? 2u : 3u);
    }
    EXPECT_FALSE(selector.wants(request));
    EXPECT_FALSE(selector.wants(request));
    std::vector<RankedCorner> chosen;
    selector.chosen(0, 0, chosen);
    ASSERT_EQ(chosen.size(), 3u);
    EXPECT_EQ(chosen[2].x, 20);
    selector.chosen(1, 0, chosen);
    EXPECT_EQ(chosen.size(), 2u);
}

TEST(Aqorb_Selection, asks_for_nothing_without_levels_or_quotas)
{
    FeatureSelector selector;
    CornerRequest request;
    Levels({}).begin(selector, 0.5);
    EXPECT_FALSE(selector.wants(request));
    Levels({0, 0}).begin(selector, 0.5);
    EXPECT_EQ(selector.wantsOf(1), 0);
    EXPECT_EQ(selector.wantsOf(0), 0);
    EXPECT_FALSE(selector.wants(request));
}

// Each set is asked for from fine to coarse, and only as long as features are missing.
TEST(Aqorb_Selection, asks_for_what_the_rules_passed_over_in_the_order_of_the_rules)
{
    const Levels levels({2, 2});
    FeatureSelector selector;
    BalancedSequence sequences[2];
    for (int repeat = 0; repeat < 2; repeat++)  // the second time with the memory of the first
    {
        levels.begin(selector, 0.5);
        for (int i = 0; i < 2; i++)
            levels.beginSequence(i, std::vector<RankedCorner>(), sequences[i]);
        for (int level = 1; level >= 0; level--)
        {
            ASSERT_EQ(selector.wantsOf(level),
                      level == 1 ? 2 : 4);  // what is missing is left to finer levels
            selector.offer(sequences[level]);
        }
        const int expectedLevels[] = {0, 1, 0, 1, 0, 1, 0};
        const CornerSet expectedSets[] = {SEQUENCE_CORNERS,   SEQUENCE_CORNERS,   KEPT_CORNERS, KEPT_CORNERS,
                                          SUPPRESSED_CORNERS, SUPPRESSED_CORNERS, WEAK_CORNERS};
        CornerRequest request;
        for (int i = 0; i < 7; i++)
        {
            SCOPED_TRACE(i);
            ASSERT_TRUE(selector.wants(request));
            EXPECT_EQ(request.level, expectedLevels[i]);
            EXPECT_EQ(request.set, expectedSets[i]);
            if (request.set == SEQUENCE_CORNERS)
                selector.offer(sequences[request.level]);
            else
                selector.offer(Levels::line(i < 6 ? 0 : 9, 7, 3));
        }
        EXPECT_FALSE(selector.wants(request));
        std::vector<RankedCorner> chosen;
        selector.chosen(0, 0, chosen);
        EXPECT_EQ(chosen.size(), 4u);
        selector.chosen(1, 0, chosen);
        EXPECT_TRUE(chosen.empty());
    }
}

TEST(Aqorb_Selection, passes_over_corners_near_those_of_coarser_levels)
{
    // Pixel (10, 5) of level 1 lies at (20.5, 10.5) of level 0.
    const Levels levels({2, 1});
    const RankedCorner coarse = {10, 5, 9.f};
    const RankedCorner fine[] = {{20, 10, 9.f}, {60, 10, 8.f}, {90, 10, 7.f}};
    for (double octaveSuppression : {0., 0.5, 0.8})
    {
        FeatureSelector selector;
        levels.begin(selector, octaveSuppression);
        CornerRequest request;
        BalancedSequence sequence;
        ASSERT_EQ(selector.wantsOf(1), 1);
        levels.beginSequence(1, std::vector<RankedCorner>(1, coarse), sequence);
        selector.offer(sequence);
        ASSERT_EQ(selector.wantsOf(0), 2);
        levels.beginSequence(0, std::vector<RankedCorner>(fine, fine + 3), sequence);
        selector.offer(sequence);
        EXPECT_FALSE(selector.wants(request));
        std::vector<RankedCorner> chosen;
        selector.chosen(0, 0, chosen);
        ASSERT_EQ(chosen.size(), 2u);
        // They are 0.71 pixels of level 0 apart.
        EXPECT_EQ(chosen[0].x, octaveSuppression == 0.8 ? 60 : 20);
    }
}

TEST(Aqorb_Selection, chooses_no_corner_twice_and_gives_them_in_raster_order)
{
    const Levels levels({5});
    FeatureSelector selector;
    levels.begin(selector, 0.5);
    std::vector<RankedCorner> corners = Levels::line(2, 9, 5), others = Levels::line(3, 4, 5);
    BalancedSequence sequence;
    levels.beginSequence(0, corners, sequence);
    ASSERT_EQ(selector.wantsOf(0), 5);
    selector.offer(sequence);
    CornerRequest request;
    while (selector.wants(request))
    {
        if (request.set == SEQUENCE_CORNERS)
        {
            selector.offer(sequence);
            continue;
        }
        std::vector<RankedCorner> offered = others;
        offered.insert(offered.end(), corners.begin(), corners.end());
        selector.offer(offered);
    }
    std::vector<RankedCorner> chosen;
    selector.chosen(0, 0, chosen);
    ASSERT_EQ(chosen.size(), 5u);
    const int expected[][2] = {{0, 4}, {5, 4}, {10, 4}, {0, 9}, {5, 9}};
    for (int i = 0; i < 5; i++)
    {
        EXPECT_EQ(chosen[i].x, expected[i][0]) << i;
        EXPECT_EQ(chosen[i].y, expected[i][1]) << i;
    }
    // Without the first two, which the sequence gave.
    ASSERT_EQ(selector.count(0), 5u);
    selector.chosen(0, 2, chosen);
    ASSERT_EQ(chosen.size(), 3u);
    for (int i = 0; i < 3; i++)
    {
        EXPECT_EQ(chosen[i].x, expected[i][0]) << i;
        EXPECT_EQ(chosen[i].y, expected[i][1]) << i;
    }
}

}  // namespace
}  // namespace opencv_test
