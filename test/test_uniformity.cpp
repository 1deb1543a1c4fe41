// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "reference.hpp"

#include <climits>

namespace opencv_test
{
namespace
{

KeyPoints randomKeypoints(int count, Size size, int seed)
{
    RNG rng(seed);
    KeyPoints keypoints;
    for (int i = 0; i < count; i++)
    {
        // a third of them in one corner
        const float part = i % 3 ? 1.f : 0.2f;
        keypoints.push_back(KeyPoint(rng.uniform(0.f, part * size.width),
                                     rng.uniform(0.f, part * size.height), rng.uniform(1.f, 99.f),
                                     rng.uniform(-1.f, 360.f), rng.uniform(-5.f, 5.f), rng.uniform(-3, 99),
                                     i));  // class_id tells which it was
    }
    return keypoints;
}

void expectAsReference(const KeyPoints& given, Size size, int npoints)
{
    const KeyPoints expected = reference::retainUniform(given, size, npoints);
    KeyPoints kept = given;
    aqorb::retainUniform(kept, size, npoints);
    EXPECT_TRUE(sameKeypoints(kept, expected));
    aqorb::retainUniform(kept, size, npoints);  // once more changes nothing
    EXPECT_TRUE(sameKeypoints(kept, expected));
}

//! A side of an image: any, or at a power of two, where the cells of a tree change.
int randomSide(RNG& rng, bool isAny)
{
    return isAny ? rng.uniform(1, 300) : (1 << rng.uniform(0, 30)) + rng.uniform(0, 9);
}

TEST(Aqorb_RetainUniform, equals_reference)
{
    const Point2f outside[] = {Point2f(-0.5f, 0),   Point2f(0, -1e-6f),       Point2f(2e9f, 0),
                               Point2f(0, 2e9f),    Point2f(NOT_A_NUMBER, 0), Point2f(0, NOT_A_NUMBER),
                               Point2f(ENDLESS, 0), Point2f(0, -ENDLESS)};
    for (int seed = 1; seed <= 250; seed++)
    {
        SCOPED_TRACE(seed);
        RNG rng(seed);
        const Size size(randomSide(rng, seed % 3 > 0), randomSide(rng, seed % 3 > 0));
        KeyPoints keypoints = randomKeypoints(rng.uniform(0, 500), size, seed);
        for (size_t i = 0; i < keypoints.size(); i++)
        {
            keypoints[i].response = randomResponse(rng, seed % 5);
            Point2f& p = keypoints[i].pt;
            const int kind = rng.uniform(0, 8);
            if (kind == 0)
                p = keypoints[rng.uniform(0, int(keypoints.size()))].pt;  // a duplicate
            else if (kind == 1)
                p = Point2f(float(cvFloor(p.x)), float(cvFloor(p.y)));
            else if (kind == 2)
                (i % 2 ? p.x : p.y) = 0;
            else if (kind == 3)  // the last number before the side
                (i % 2 ? p.x : p.y) = std::nextafter(float(i % 2 ? size.width : size.height), 0.f);
            else if (kind == 4)
                (i % 2 ? p.x : p.y) = float(i % 2 ? size.width : size.height);
            else if (kind == 5)
                p = outside[rng.uniform(0, 8)];
        }
        for (int n = 0; n < 500; n += rng.uniform(1, 150))
            expectAsReference(keypoints, size, n);
        expectAsReference(keypoints, size, INT_MAX);
    }
}

#if CV_SSE2
// GCC's start-up code sets these bits in programs that are linked with -ffast-math.
TEST(Aqorb_RetainUniform, counts_subnormal_responses_as_zero_where_the_cpu_flushes_them)
{
    const Size size(200, 150);
    KeyPoints keypoints = randomKeypoints(900, size, 1), zeros = keypoints;
    for (size_t i = 0; i < keypoints.size(); i++)
    {
        keypoints[i].response = 1e-41f * (1 + i * 7 % 300);
        zeros[i].response = 0;
    }
    const auto classesOf = [&](KeyPoints kept)
    {
        aqorb::retainUniform(kept, size, 100);
        std::vector<int> classes;
        for (const KeyPoint& keypoint : kept)
            classes.push_back(keypoint.class_id);
        return classes;
    };
    EXPECT_NE(classesOf(zeros), classesOf(keypoints));
    const unsigned before = _mm_getcsr(), FLUSH_RESULTS = 0x8000, FLUSH_OPERANDS = 0x40;
    _mm_setcsr(before | FLUSH_RESULTS | FLUSH_OPERANDS);
    EXPECT_EQ(classesOf(zeros), classesOf(keypoints));
    _mm_setcsr(before);
}
#endif

// Many detectors, and points converted to keypoints, leave all responses equal.
TEST(Aqorb_RetainUniform, spreads_keypoints_of_equal_responses)
{
    const Size size(640, 480);
    KeyPoints grid, random = randomKeypoints(3000, size, 5);
    for (int i = 0; i < 192; i++)
        grid.push_back(KeyPoint(float(i % 16 * 40 + 20), float(i / 16 * 40 + 20), 7));
    for (KeyPoint& keypoint : random)
        keypoint.response = 1;
    for (KeyPoints keypoints : {grid, random})
    {
        aqorb::retainUniform(keypoints, size, 48);
        EXPECT_GE(aqorb::distributionOccupancy(keypoints, size, Size(4, 3)), .9);
    }
}

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

double uniformityAt(const std::vector<Point2f>& places, Size size)
{
    return aqorb::distributionUniformity(keypointsAt(places), size);
}

TEST(Aqorb_Distribution, uniformity_of_counts_by_hand)
{
    // 100 x 60, four keypoints at the left end of the middle row: all left, all top (y <= H/2); below the
    // main diagonal (y W - x H = 30*100 - 5*60 > 0), before the other (3000 + 300 - 6000 < 0), all outside
    // the centre. Every halving is 4 : 0, so sigma = 2.
    const Size size(100, 60);
    std::vector<Point2f> places(4, Point2f(5, 30));
    EXPECT_DOUBLE_EQ(uniformityOf(2), uniformityAt(places, size));
    // Positions that are not finite do not count.
    places.insert(places.end(), {Point2f(NOT_A_NUMBER, 5), Point2f(5, NOT_A_NUMBER), Point2f(ENDLESS, 5),
                                 Point2f(5, -ENDLESS)});
    EXPECT_DOUBLE_EQ(uniformityOf(2), uniformityAt(places, size));
    // Four in the centre: (50, 30) is left and top, on both diagonals (so in neither first half), central.
    EXPECT_DOUBLE_EQ(uniformityOf(2), uniformityAt(std::vector<Point2f>(4, Point2f(50, 30)), size));
    // Six at (5, 30), two at (95, 30). First halves: left 6, top 8, main diagonal 2, other 6, centre 0 of 8:
    // deviations 2, 4, 2, 2, 4; sigma = sqrt(44 / 5).
    places.assign(6, Point2f(5, 30));
    places.insert(places.end(), 2, Point2f(95, 30));
    EXPECT_DOUBLE_EQ(uniformityOf(std::sqrt(44. / 5)), uniformityAt(places, size));
    // One place in each of the 8 sectors, four of them central: every halving is even, and sigma is 0.
    places = {Point2f(60, 45), Point2f(55, 60), Point2f(40, 55), Point2f(45, 40),
              Point2f(90, 60), Point2f(40, 90), Point2f(10, 40), Point2f(60, 10)};
    EXPECT_EQ(0, uniformityAt(places, Size(100, 100)));
    EXPECT_EQ(0, uniformityAt({}, Size(10, 10)));
    EXPECT_EQ(0, uniformityAt({Point2f(5, 5)}, Size(10, 10)));
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
    places = {Point2f(-1, 50), Point2f(160, 50), Point2f(50, 120), Point2f(NOT_A_NUMBER, 50)};
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
