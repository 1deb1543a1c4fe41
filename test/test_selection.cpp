// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "reference.hpp"

#include "selection.hpp"

namespace opencv_test
{
namespace
{

using namespace aqorb;

typedef std::vector<CornerResponse> Corners;

//! Levels of which each is half the size of the one before.
struct Selection : FeatureSelector
{
    void reset(const std::vector<int>& quotas, double suppression, bool isRanked = true)
    {
        plans.clear();
        for (size_t i = 0; i < quotas.size(); i++)
        {
            LevelPlan plan = LevelPlan();
            plan.root = Rect(0, 0, 256 >> i, 256 >> i);
            plan.size = plan.root.size();
            plan.scale = float(1 << i);
            plan.quota = quotas[i];
            plan.isRanked = isRanked;
            const RankRule rule = {plan.size, 1, std::max(plan.quota, 1), 1, 0.15};
            plan.rankRule = rule;
            plans.push_back(plan);
        }
        FeatureSelector::reset(Size(256, 256), int(plans.size()), suppression, int(plans.size()));
    }
    void add(int level) { addLevel(level, plans[level]); }

private:
    std::vector<LevelPlan> plans;
};

//! Corners at (0, row), (step, row), ..., best first.
Corners line(int count, int row, int step)
{
    Corners corners;
    for (int i = 0; i < count; i++)
    {
        const CornerResponse corner = {i * step, row, float(100 - i)};
        corners.push_back(corner);
    }
    return corners;
}

//! The columns of the corners of a level that were chosen, in raster order.
std::vector<int> columns(FeatureSelector& selector, int level, size_t first = 0)
{
    Corners chosen;
    selector.chosen(level, first, chosen);
    std::vector<int> xs;
    for (const CornerResponse& corner : chosen)
        xs.push_back(corner.x);
    return xs;
}

TEST(Aqorb_Selection, takes_the_quotas_and_no_more)
{
    Selection selector;
    selector.reset({3, 2}, 0);
    for (int level = 1; level >= 0; level--)  // from coarse to fine
    {
        selector.add(level);
        EXPECT_EQ(selector.missing(), level == 1 ? 2 : 3);
        selector.take(level, line(9, 5, 10));
        EXPECT_EQ(selector.missing(), 0);
    }
    EXPECT_EQ(columns(selector, 0), std::vector<int>({0, 10, 20}));
    EXPECT_EQ(columns(selector, 1), std::vector<int>({0, 10}));
}

TEST(Aqorb_Selection, of_nothing_is_nothing)
{
    Selection selector;
    selector.reset({}, 0.5);
    EXPECT_EQ(selector.missing(), 0);
    selector.reset({0, 4}, 0.5);
    selector.add(1);
    selector.take(1, Corners());
    selector.fill(1, Corners());
    EXPECT_EQ(selector.missing(), 4);
    EXPECT_TRUE(columns(selector, 1).empty());
}

// A list may have grown, and is then gone on with.
TEST(Aqorb_Selection, goes_on_along_an_order_and_hands_on_what_is_missing)
{
    Selection selector;
    for (int repeat = 0; repeat < 2; repeat++)  // the second time with the memory of the first
    {
        selector.reset({2, 3}, 0);
        selector.add(1);
        selector.take(1, line(2, 7, 3));
        EXPECT_EQ(selector.missing(), 1);
        selector.add(0);
        EXPECT_EQ(selector.missing(), 3);
        selector.take(0, line(2, 7, 3));
        EXPECT_EQ(selector.missing(), 1);
        selector.take(1, line(9, 7, 3));
        EXPECT_EQ(selector.missing(), 0);
        EXPECT_EQ(columns(selector, 1), std::vector<int>({0, 3, 6}));
        EXPECT_EQ(columns(selector, 1, 2), std::vector<int>({6}));
    }
}

TEST(Aqorb_Selection, passes_over_corners_near_those_of_other_levels)
{
    // Pixel (10, 5) of level 1 lies at (20.5, 10.5) of level 0, 0.71 pixels from the first of these.
    const CornerResponse coarse = {10, 5, 9.f};
    const CornerResponse fine[] = {{20, 10, 9.f}, {60, 10, 8.f}, {90, 10, 7.f}};
    for (bool isRanked : {true, false})
        for (double octaveSuppression : {0., 0.5, 0.8, 1e300})
        {
            SCOPED_TRACE(format("ranked %d, suppression %g", isRanked, octaveSuppression));
            Selection selector;
            selector.reset({2, 1}, octaveSuppression, isRanked);
            selector.add(1);
            selector.take(1, Corners(1, coarse));
            selector.add(0);
            selector.take(0, Corners(fine, fine + 3));
            if (octaveSuppression > 1)
                EXPECT_TRUE(columns(selector, 0).empty());
            else
                EXPECT_EQ(columns(selector, 0)[0], octaveSuppression == 0.8 ? 60 : 20);
        }
}

TEST(Aqorb_Selection, fills_up_with_no_corner_twice)
{
    for (bool isRanked : {true, false})
    {
        Selection selector;
        selector.reset({5}, 0.5, isRanked);
        selector.add(0);
        const Corners corners = line(2, 9, 5), others = line(9, 4, 5);
        selector.take(0, corners);
        Corners offered = others;
        offered.insert(offered.end(), corners.begin(), corners.end());
        selector.fill(0, offered);
        EXPECT_EQ(selector.missing(), 0);
        // The best three of the others, in raster order before the two that were taken.
        EXPECT_EQ(columns(selector, 0), std::vector<int>({0, 5, 10, 0, 5}));
        EXPECT_EQ(columns(selector, 0, 2), std::vector<int>({0, 5, 10}));
    }
}

//! The number of corners that are not near a keypoint of the coarser level, one by one.
TEST(Aqorb_Selection, near_keypoints_are_found_at_any_radius)
{
    RNG rng(1);
    for (int round = 0; round < 200; round++)
    {
        const double suppressions[] = {0.3, 0.5, 1.5, 2.1, 9, 50, 1e6};
        const double suppression = suppressions[rng.uniform(0, 7)];
        Selection selector;
        selector.reset({1000, 20}, suppression, round % 2 == 0);
        Corners coarse, fine;
        for (int i = 0; i < 20; i++)
        {
            const CornerResponse a = {rng.uniform(0, 50), 2 * i, 1.f}, b = {rng.uniform(0, 100), 4 * i, 2.f};
            coarse.push_back(a);
            fine.push_back(b);
        }
        selector.add(1);
        selector.take(1, coarse);
        selector.add(0);
        selector.take(0, fine);
        int expected = 1000;
        for (const CornerResponse& corner : fine)
        {
            const auto isNear = [&](const CornerResponse& other)
            {
                const Point2d d(2 * other.x + 0.5 - corner.x, 2 * other.y + 0.5 - corner.y);
                return d.dot(d) < suppression * suppression;
            };
            expected -= std::none_of(coarse.begin(), coarse.end(), isNear);
        }
        EXPECT_EQ(selector.missing(), expected) << suppression;
    }
}

}  // namespace
}  // namespace opencv_test
