// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "reference.hpp"

#include <limits>

namespace opencv_test
{
namespace
{

KeyPoints keypointsAt(const std::vector<Point2f>& places)
{
    KeyPoints keypoints;
    for (const Point2f& place : places)
        keypoints.push_back(KeyPoint(place, 1));
    return keypoints;
}

double uniformityOf(double sigma)
{
    return 101 * std::log10(sigma);
}

TEST(Aqorb_Distribution, uniformity_of_counts_by_hand)
{
    // 100 x 60, four keypoints at the left end of the middle row: all left, all top (y <= H/2); below the
    // main diagonal (y W - x H = 30*100 - 5*60 > 0), before the other (3000 + 300 - 6000 < 0), all outside
    // the centre. Every halving is 4 : 0, so sigma = 2.
    const Size size(100, 60);
    EXPECT_DOUBLE_EQ(
        aqorb::distributionUniformity(keypointsAt(std::vector<Point2f>(4, Point2f(5, 30))), size),
        uniformityOf(2));
    // Four in the centre: (50, 30) is left and top, on both diagonals (so in neither first half), central.
    EXPECT_DOUBLE_EQ(
        aqorb::distributionUniformity(keypointsAt(std::vector<Point2f>(4, Point2f(50, 30))), size),
        uniformityOf(2));
    // Six at (5, 30), two at (95, 30). First halves: left 6, top 8, main diagonal 2, other 6, centre 0 of 8:
    // deviations 2, 4, 2, 2, 4; sigma = sqrt(44 / 5).
    std::vector<Point2f> places(6, Point2f(5, 30));
    places.push_back(Point2f(95, 30));
    places.push_back(Point2f(95, 30));
    EXPECT_DOUBLE_EQ(aqorb::distributionUniformity(keypointsAt(places), size),
                     uniformityOf(std::sqrt(44. / 5)));
}

TEST(Aqorb_Distribution, uniformity_is_zero_for_an_even_distribution_and_for_none)
{
    EXPECT_EQ(aqorb::distributionUniformity(KeyPoints(), Size(10, 10)), 0);
    EXPECT_EQ(
        aqorb::distributionUniformity(keypointsAt(std::vector<Point2f>(1, Point2f(5, 5))), Size(10, 10)), 0);
    // one place in each of the 8 sectors, four of them central: every halving is even, sigma is 0
    const Point2f even[] = {Point2f(60, 45), Point2f(55, 60), Point2f(40, 55), Point2f(45, 40),
                            Point2f(90, 60), Point2f(40, 90), Point2f(10, 40), Point2f(60, 10)};
    EXPECT_EQ(
        aqorb::distributionUniformity(keypointsAt(std::vector<Point2f>(even, even + 8)), Size(100, 100)), 0);
}

TEST(Aqorb_Distribution, uniformity_ignores_positions_that_are_not_finite)
{
    const float nan = std::numeric_limits<float>::quiet_NaN();
    const float inf = std::numeric_limits<float>::infinity();
    std::vector<Point2f> places(4, Point2f(5, 30));
    places.push_back(Point2f(nan, 5));
    places.push_back(Point2f(5, nan));
    places.push_back(Point2f(inf, 5));
    places.push_back(Point2f(5, -inf));
    EXPECT_DOUBLE_EQ(aqorb::distributionUniformity(keypointsAt(places), Size(100, 60)), uniformityOf(2));
}

TEST(Aqorb_Distribution, occupancy_of_cells_by_hand)
{
    std::vector<Point2f> places;
    EXPECT_EQ(aqorb::distributionOccupancy(keypointsAt(places), Size(160, 120)), 0);
    places.push_back(Point2f(0, 0));
    places.push_back(Point2f(9.99f, 9.99f));  // the same cell
    EXPECT_DOUBLE_EQ(aqorb::distributionOccupancy(keypointsAt(places), Size(160, 120)), 1. / 192);
    places.push_back(Point2f(10, 9.99f));
    places.push_back(Point2f(159.9f, 119.9f));
    EXPECT_DOUBLE_EQ(aqorb::distributionOccupancy(keypointsAt(places), Size(160, 120)), 3. / 192);
    EXPECT_DOUBLE_EQ(aqorb::distributionOccupancy(keypointsAt(places), Size(160, 120), Size(2, 1)), 1);
    EXPECT_DOUBLE_EQ(aqorb::distributionOccupancy(keypointsAt(places), Size(160, 120), Size(2, 2)), 0.5);

    // Keypoints outside the image do not count.
    const float nan = std::numeric_limits<float>::quiet_NaN();
    const Point2f outside[] = {Point2f(-1, 50), Point2f(160, 50), Point2f(50, 120), Point2f(nan, 50)};
    places.assign(outside, outside + 4);
    EXPECT_EQ(aqorb::distributionOccupancy(keypointsAt(places), Size(160, 120)), 0);
}

// The uniformity of cv::ORB's 500 keypoints, column A of the paper's tables.
TEST(Aqorb_Distribution, uniformity_gives_the_papers_values)
{
    AQORB_NEEDS_DATA();
    const std::pair<std::string, std::vector<double>> sets[] = {
        {"bikes", {210.06, 201.62, 209.01, 209.61}},
        {"leuven", {203.30, 214.93, 217.05, 216.57, 215.70, 216.82}}};
    for (const auto& set : sets)
        for (size_t i = 0; i < set.second.size(); i++)
        {
            SCOPED_TRACE(set.first + format(" img%d", int(i + 1)));
            const Mat image = imread(oxfordImage(set.first, int(i + 1)), IMREAD_COLOR);
            ASSERT_FALSE(image.empty());
            KeyPoints keypoints;
            ORB::create(500)->detect(image, keypoints);
            EXPECT_NEAR(aqorb::distributionUniformity(keypoints, image.size()), set.second[i], 0.3);
        }
}

}  // namespace
}  // namespace opencv_test
