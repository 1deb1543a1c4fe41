// This file is part of the aqorb project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.

#include "plain_reference.hpp"

#include <limits>

namespace opencv_test
{
namespace
{

using namespace aqorb::stages;

TEST(AQORB_Quadtree, depth_by_equation_9)
{
    // the smallest D with 4^D >= quota; 109 and 30 are the paper's example
    EXPECT_EQ(0, quadtreeDepth(0));
    EXPECT_EQ(0, quadtreeDepth(1));
    EXPECT_EQ(1, quadtreeDepth(2));
    EXPECT_EQ(1, quadtreeDepth(4));
    EXPECT_EQ(2, quadtreeDepth(5));
    EXPECT_EQ(3, quadtreeDepth(30));
    EXPECT_EQ(4, quadtreeDepth(109));
    EXPECT_EQ(5, quadtreeDepth(257));
    EXPECT_EQ(15, quadtreeDepth(std::numeric_limits<int>::max()));
}

TEST(AQORB_Quadtree, leaf_codes_interleave_bits)
{
    EXPECT_EQ(0u, leafCode(0, 0));
    EXPECT_EQ(1u, leafCode(1, 0));
    EXPECT_EQ(2u, leafCode(0, 1));
    EXPECT_EQ(4u, leafCode(2, 0));
    EXPECT_EQ(0x3fffffffu, leafCode(32767, 32767));
}

TEST(AQORB_Quadtree, sequence_by_definition)
{
    RNG rng(11);
    const float nan = std::numeric_limits<float>::quiet_NaN(), inf = std::numeric_limits<float>::infinity();
    const float special[] = {nan, inf, -inf, 0.f, -0.f, 1e-30f, -1e-30f};
    for (int round = 0; round < 300; round++)
    {
        const int depth = round % 7 == 6 ? 15 : round % 6;
        const unsigned leaves = std::min(1u << (2 * depth), 40u);
        std::vector<LeafPoint> points;
        for (int i = 0; i < rng.uniform(0, 90); i++)
        {
            // few values, so that every tie occurs
            const float response = round % 5 == 0 ? special[rng.uniform(0, 7)] : (float)rng.uniform(0, 6);
            const LeafPoint point = {rng.uniform(0, (int)leaves) * (depth == 15 ? 26000000u : 1u), response,
                                     (float)rng.uniform(0, 4), (float)rng.uniform(0, 4), i};
            points.push_back(point);
        }
        const std::vector<int> expected = referenceSequence(points, depth);
        BalancedSequence sequence;
        for (int repeat = 0; repeat < 2; repeat++)  // the second time in used memory
        {
            std::vector<LeafPoint> input = points;
            sequence.begin(input, depth);
            std::vector<int> order;
            LeafPoint point;
            while (sequence.next(point))
                order.push_back(point.index);
            ASSERT_EQ(expected, order) << "depth " << depth;
            ASSERT_FALSE(sequence.next(point));
        }
    }
}

KeyPoints randomKeypoints(int count, Size size, int seed)
{
    RNG rng(seed);
    KeyPoints keypoints;
    for (int i = 0; i < count; i++)
    {
        keypoints.push_back(KeyPoint(
            Point2f(rng.uniform(0.f, (float)size.width), rng.uniform(0.f, (float)size.height)),
            rng.uniform(1.f, 99.f), rng.uniform(0.f, 360.f), rng.uniform(0.f, 1.f), rng.uniform(-3, 9), i));
    }
    return keypoints;
}

TEST(AQORB_RetainUniform, keeps_order_and_fields)
{
    const Size size(640, 480);
    const KeyPoints input = randomKeypoints(3000, size, 2);
    KeyPoints kept = input;
    aqorb::retainUniform(kept, size, 500);
    ASSERT_EQ(500u, kept.size());
    KeyPoints expected;
    for (size_t i = 0; i < kept.size(); i++)
    {
        EXPECT_TRUE(i == 0 || kept[i - 1].class_id < kept[i].class_id);
        expected.push_back(input[kept[i].class_id]);
    }
    EXPECT_TRUE(sameKeypoints(expected, kept));
}

TEST(AQORB_RetainUniform, is_more_uniform_than_the_best)
{
    const Size size(640, 480);
    KeyPoints keypoints = randomKeypoints(3000, size, 4);
    for (KeyPoint& keypoint : keypoints)  // strong ones on the left
        keypoint.response += 1 - keypoint.pt.x / size.width;
    KeyPoints best = keypoints, uniform = keypoints;
    KeyPointsFilter::retainBest(best, 400);
    aqorb::retainUniform(uniform, size, 400);
    EXPECT_LT(aqorb::distributionUniformity(uniform, size) + 50, aqorb::distributionUniformity(best, size));
    EXPECT_GT(aqorb::distributionOccupancy(uniform, size), 0.85);
}

TEST(AQORB_RetainUniform, ranks_NaN_last_and_drops_what_is_outside)
{
    const Size size(100, 80);
    const float nan = std::numeric_limits<float>::quiet_NaN();
    KeyPoints keypoints;
    keypoints.push_back(KeyPoint(Point2f(10, 10), 1, -1, nan));
    keypoints.push_back(KeyPoint(Point2f(11, 10), 1, -1, -1e30f));
    keypoints.push_back(KeyPoint(Point2f(100, 10), 1, -1, 9));
    keypoints.push_back(KeyPoint(Point2f(10, -0.1f), 1, -1, 9));
    keypoints.push_back(KeyPoint(Point2f(nan, 10), 1, -1, 9));
    KeyPoints one = keypoints;
    aqorb::retainUniform(one, size, 1);
    ASSERT_EQ(1u, one.size());
    EXPECT_EQ(11.f, one[0].pt.x);
    KeyPoints all = keypoints;
    aqorb::retainUniform(all, size, 1000);
    EXPECT_EQ(2u, all.size());
    aqorb::retainUniform(all, size, 0);
    EXPECT_TRUE(all.empty());
    aqorb::retainUniform(all, size, 10);
    EXPECT_TRUE(all.empty());
}

TEST(AQORB_RetainUniform, does_not_depend_on_the_order_of_distinct_points)
{
    const Size size(320, 240);
    KeyPoints keypoints = randomKeypoints(800, size, 9);
    KeyPoints a = keypoints, b(keypoints.rbegin(), keypoints.rend());
    aqorb::retainUniform(a, size, 150);
    aqorb::retainUniform(b, size, 150);
    std::reverse(b.begin(), b.end());
    EXPECT_TRUE(sameKeypoints(a, b));
}

}  // namespace
}  // namespace opencv_test
