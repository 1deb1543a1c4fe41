// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "reference.hpp"

namespace opencv_test
{
namespace
{

using aqorb::knnMatchArrays;
using aqorb::matchArrays;
using aqorb::matchByPosition;
using aqorb::matchGuided;

ReferenceTests randomTests(RNG& rng)
{
    ReferenceTests tests;
    tests.ratio = rng.uniform(0, 2) ? rng.uniform(0.4, 1.2) : 0;
    tests.crossCheck = rng.uniform(0, 2) != 0;
    tests.maxDistance = rng.uniform(0, 2) ? rng.uniform(0, 200) : -1;
    tests.normType = rng.uniform(0, 3) ? NORM_HAMMING : NORM_HAMMING2;
    return tests;
}

TEST(Aqorb_MatchArrays, finds_k_nearest)
{
    for (int seed = 1; seed <= 300; seed++)
    {
        RNG rng(seed);
        const int bytes = rng.uniform(1, 70), k = rng.uniform(1, 10);
        const Mat query = randomDescriptors(rng, rng.uniform(1, 60), bytes);
        const Mat train = randomDescriptors(rng, rng.uniform(1, 60), bytes);
        Mat indices, distances;
        knnMatchArrays(query, train, indices, distances, k);
        Mat expectedIndices(query.rows, k, CV_32SC1, Scalar(-1)), expectedDistances = expectedIndices.clone();
        for (int i = 0; i < query.rows; i++)
        {
            const std::vector<DMatch> expected =
                referenceMatches(query, i, std::vector<Mat>(1, train), std::vector<Mat>(), NORM_HAMMING);
            for (int j = 0; j < std::min(k, train.rows); j++)
            {
                expectedIndices.at<int>(i, j) = expected[j].trainIdx;
                expectedDistances.at<int>(i, j) = int(expected[j].distance);
            }
        }
        ASSERT_TRUE(sameMat(expectedIndices, indices) && sameMat(expectedDistances, distances)) << seed;
    }
}

TEST(Aqorb_MatchArrays, empty_descriptors)
{
    const std::vector<Mat> matrices = {Mat(), Mat(0, 32, CV_8UC1), Mat(7, 0, CV_8UC1), Mat(0, 0, CV_8UC1),
                                       Mat::zeros(7, 32, CV_8UC1)};
    for (const Mat& query : matrices)
        for (const Mat& train : matrices)
        {
            if (!query.empty() && !train.empty())
                continue;
            SCOPED_TRACE(testing::Message() << query.size() << " queries, " << train.size() << " trains");
            for (const bool crossCheck : {false, true})
            {
                std::vector<Mat> pairs(3, Mat::ones(2, 2, CV_8UC1)), distances = pairs;
                matchArrays(query, train, pairs[0], distances[0], 0.8, crossCheck);
                matchByPosition(query, std::vector<Point2f>(query.rows), train, KeyPoints(train.rows),
                                Size2f(9, ENDLESS), pairs[1], distances[1], 0, crossCheck);
                matchGuided(query, KeyPoints(query.rows), train, KeyPoints(train.rows), Matx33d::eye(), 9,
                            pairs[2], distances[2]);
                for (int i = 0; i < 3; i++)
                    EXPECT_TRUE(pairs[i].empty() && distances[i].empty()) << i;
            }
            Mat indices, distances;
            knnMatchArrays(query, train, indices, distances, 2);
            EXPECT_TRUE(sameMat(Mat(query.empty() ? 0 : 7, 2, CV_32SC1, Scalar(-1)), indices));
            EXPECT_TRUE(sameMat(indices, distances));
        }
}

// Sums and differences of these overflow as floats, and need more bits than a double has.
float extreme(RNG& rng)
{
    const float values[] = {0, FLT_MIN, 1e-30f, 1, 100, 1e30f, 3e38f, FLT_MAX};
    return values[rng.uniform(0, 8)];
}

// Positions of which some are equal, some far away and some not finite.
Point2f randomPosition(RNG& rng, bool isOnLine)
{
    const int kind = rng.uniform(0, 40);
    Point2f p(float(rng.uniform(0, 200)) / 2, isOnLine ? 7 : float(rng.uniform(0, 100)) / 2);
    if (kind == 0)
        p *= 1e30f;
    if (kind == 1)
        p.x = NOT_A_NUMBER;
    if (kind == 2)
        p.y = -ENDLESS;
    if (kind < 10)
        (kind % 2 ? p.x : p.y) = rng.uniform(0, 2) ? extreme(rng) : -extreme(rng);
    return p;
}

TEST(Aqorb_MatchArrays, applies_the_tests_everywhere_or_within_the_window_only)
{
    size_t found = 0;  // in the window
    for (int seed = 1; seed <= 600; seed++)
    {
        RNG rng(seed);
        const int bytes = rng.uniform(0, 4) ? 32 : rng.uniform(1, 140);
        const Mat query = randomDescriptors(rng, rng.uniform(1, 80), bytes);
        const Mat train = randomDescriptors(rng, rng.uniform(1, 80), bytes);
        const bool isOnLine = rng.uniform(0, 5) == 0;
        std::vector<Point2f> predicted;
        KeyPoints keypoints(train.rows);
        for (int i = 0; i < query.rows; i++)
            predicted.push_back(randomPosition(rng, false));
        for (int i = 0; i < train.rows; i++)
            keypoints[i].pt = randomPosition(rng, isOnLine);
        Size2f reach(float(rng.uniform(0, 80)) / 2, float(rng.uniform(0, 40)) / 2);
        if (rng.uniform(0, 4) == 0)
            reach.width = ENDLESS;
        if (rng.uniform(0, 3) == 0)
            (rng.uniform(0, 2) ? reach.width : reach.height) = extreme(rng);
        const ReferenceTests tests = randomTests(rng);
        const auto isAllowed = [&](int i, int j) { return isInWindow(predicted[i], keypoints[j].pt, reach); };
        Mat pairs, distances;
        matchArrays(query, train, pairs, distances, tests.ratio, tests.crossCheck, tests.maxDistance,
                    tests.normType);
        ASSERT_TRUE(isMatchedAs(referenceTested(query, train, tests, [](int, int) { return true; }), pairs,
                                distances))
            << seed;
        const std::vector<DMatch> expected = referenceTested(query, train, tests, isAllowed);
        matchByPosition(query, predicted, train, keypoints, reach, pairs, distances, tests.ratio,
                        tests.crossCheck, tests.maxDistance, tests.normType);
        ASSERT_TRUE(isMatchedAs(expected, pairs, distances)) << seed;
        found += expected.size();
    }
    EXPECT_GT(found, 1000u);
}

KeyPoints randomKeypoints(RNG& rng, int count)
{
    KeyPoints keypoints;
    const float sizes[] = {2, 31, 44.6f, 300, ENDLESS, NOT_A_NUMBER};
    for (int i = 0; i < count; i++)
        keypoints.push_back(KeyPoint(randomPosition(rng, false), sizes[rng.uniform(0, rng.uniform(1, 7))]));
    return keypoints;
}

// Any matrix, that of rectified images, or one of rank 2 whose epipole in image 1 is a position of keypoints.
Matx33d randomFundamental(RNG& rng)
{
    Matx33d F;
    for (double& element : F.val)
        element = rng.uniform(-1., 1.);
    const int kind = rng.uniform(0, 3);
    if (kind == 0)
        return Matx33d(0, 0, 0, 0, 0, -1, 0, 1, 0);
    const double x = rng.uniform(0, 200) / 2., y = rng.uniform(0, 100) / 2.;
    return kind == 1 ? F : F * Matx33d(0, -1, y, 1, 0, -x, -y, x, 0);
}

TEST(Aqorb_MatchGuided, compares_along_epipolar_lines_only)
{
    size_t found = 0;
    for (int seed = 1; seed <= 900; seed++)
    {
        RNG rng(seed);
        const int bytes = rng.uniform(0, 3) ? 32 : rng.uniform(1, 140);
        const Mat query = randomDescriptors(rng, rng.uniform(1, seed % 50 ? 60 : 700), bytes),
                  train = randomDescriptors(rng, rng.uniform(1, 80), bytes);
        const KeyPoints queries = randomKeypoints(rng, query.rows), trains = randomKeypoints(rng, train.rows);
        const Matx33d F = randomFundamental(rng);
        const float reach = rng.uniform(0, 4) ? float(rng.uniform(0, 60)) / 4 : extreme(rng);
        ReferenceTests tests = randomTests(rng);
        const int limit = tests.maxDistance;
        if (limit == -1)
            tests.maxDistance = bytes * 8 * (tests.normType == NORM_HAMMING ? 90 : 67) / 256;
        const std::vector<DMatch> expected = referenceGuided(query, queries, train, trains, F, reach, tests);
        const Threads threads(rng.uniform(1, 5));
        for (const double scale : {1., std::ldexp(1., 900), -std::ldexp(1., -900)})
        {
            Mat matches, distances;
            matchGuided(query, queries, train, trains, scale * F, reach, matches, distances, tests.ratio,
                        limit, tests.normType);
            ASSERT_TRUE(isMatchedAs(expected, matches, distances)) << seed;
        }
        found += expected.size();
    }
    EXPECT_GT(found, 2000u);
}

TEST(Aqorb_MatchGuided, takes_F_of_either_type_and_everything_within_an_endless_reach)
{
    RNG rng(1);
    const Mat query = randomDescriptors(rng, 50, 32), train = query.clone();
    KeyPoints keypoints;
    for (int i = 0; i < 50; i++)
        keypoints.push_back(KeyPoint(Point2f(float(i * 9), float(i * i % 70)), 31));
    const Matx33f F(0, 0, 0, 0, 0, -0.1f, 0, 0.1f, 0);
    Mat matches[3], distances[3];
    matchGuided(query, keypoints, train, keypoints, F, 2, matches[0], distances[0]);
    matchGuided(query, keypoints, train, keypoints, Mat(Matx33d(F)), 2, matches[1], distances[1]);
    EXPECT_TRUE(sameMat(matches[0], matches[1]) && sameMat(distances[0], distances[1]));
    EXPECT_GT(matches[0].rows, 10);
    matchGuided(query, keypoints, train, keypoints, F, ENDLESS, matches[1], distances[1], 0, 256);
    matchArrays(query, train, matches[2], distances[2], 0, false);
    EXPECT_TRUE(sameMat(matches[2], matches[1]) && sameMat(distances[2], distances[1]));
    matchGuided(query, keypoints, train, keypoints, Matx33d(0, 0, 0, 0, 0, 0, 0, 0, 1), ENDLESS, matches[0],
                distances[0]);
    EXPECT_TRUE(matches[0].empty() && distances[0].empty());
}

TEST(Aqorb_MatchGuided, refuses_bad_input)
{
    const Mat some = Mat::zeros(3, 32, CV_8UC1);
    const KeyPoints three(3), four(4);
    const Matx33d F = Matx33d::eye();
    Mat a, b;
    const auto call = [&](const KeyPoints& queries, const KeyPoints& trains, InputArray matrix, float reach)
    { matchGuided(some, queries, some, trains, matrix, reach, a, b); };
    AQORB_BAD("queryKeypoints", "4", call(four, three, F, 3));
    AQORB_BAD("trainKeypoints", "4", call(three, four, F, 3));
    AQORB_BAD("reach", "-1", call(three, three, F, -1));
    AQORB_BAD("reach", "nan", call(three, three, F, NOT_A_NUMBER));
    AQORB_BAD("F", "0", call(three, three, Matx33d(), 3));
    AQORB_BAD("F", "inf", call(three, three, F * -ENDLESS, 3));
    AQORB_BAD("F", "nan", call(three, three, Matx33f(1, NOT_A_NUMBER, 1, 1, 1, 1, 1, 1, 1), 3));
    AQORB_BAD("F", "CV_8UC1", call(three, three, Mat::eye(3, 3, CV_8UC1), 3));
    AQORB_BAD("F", "27 ", call(three, three, Mat::ones(9, 3, CV_64FC1), 3));
    AQORB_BAD("F", "0 ", call(three, three, noArray(), 3));
    AQORB_BAD("F", "", call(three, three, std::vector<Mat>(1, Mat(F)), 3));
    AQORB_BAD("F", "", call(three, three, Mat(3, std::vector<int>{3, 3, 3}.data(), CV_64FC1, Scalar(1)), 3));
    AQORB_BAD("ratio", "-1", matchGuided(some, three, some, three, F, 3, a, b, -1));
    AQORB_BAD("maxDistance", "-2", matchGuided(some, three, some, three, F, 3, a, b, 0.9, -2));
    AQORB_BAD("normType", "4", matchGuided(some, three, some, three, F, 3, a, b, 0.9, -1, NORM_L2));
    std::vector<Vec2i> refused;
    AQORB_BAD("distances", "", matchGuided(some, three, some, three, F, 3, a, refused));
    AQORB_BAD("matches", "", matchGuided(some, three, some, three, F, 3, Mat(7, 7, CV_32SC1), b));
    EXPECT_TRUE(a.empty() && b.empty());
}

TEST(Aqorb_MatchArrays, refuses_bad_input)
{
    const Mat some = Mat::zeros(3, 32, CV_8UC1), narrow = Mat::zeros(3, 16, CV_8UC1),
              real = Mat::zeros(3, 32, CV_32FC1);
    const std::vector<Point2f> positions(3);
    const KeyPoints keypoints(3);
    Mat a, b;
    AQORB_BAD("queryDescriptors", "", matchArrays(real, some, a, b));
    AQORB_BAD("queryDescriptors", "", matchArrays(std::vector<Mat>(2, some), some, a, b));
    AQORB_BAD("trainDescriptors", "", matchArrays(some, narrow, a, b));
    AQORB_BAD("ratio", "-1", matchArrays(some, some, a, b, -1));
    AQORB_BAD("ratio", "nan", matchArrays(some, some, a, b, NOT_A_NUMBER));
    AQORB_BAD("maxDistance", "-2", matchArrays(some, some, a, b, 0, true, -2));
    AQORB_BAD("normType", "4", matchArrays(some, some, a, b, 0, true, -1, NORM_L2));
    AQORB_BAD("k", "0", knnMatchArrays(some, some, a, b, 0));
    AQORB_BAD("k", "2147483647", knnMatchArrays(some, some, a, b, INT_MAX));
    AQORB_BAD("trainDescriptors", "", knnMatchArrays(some, narrow, a, b, 2));
    AQORB_BAD("predicted", "2",
              matchByPosition(some, std::vector<Point2f>(2), some, keypoints, Size2f(1, 1), a, b));
    AQORB_BAD("trainKeypoints", "4",
              matchByPosition(some, positions, some, KeyPoints(4), Size2f(1, 1), a, b));
    AQORB_BAD("reach", "-1", matchByPosition(some, positions, some, keypoints, Size2f(-1, 1), a, b));
    AQORB_BAD("reach", "1 x nan",
              matchByPosition(some, positions, some, keypoints, Size2f(1, NOT_A_NUMBER), a, b));
}

TEST(Aqorb_MatchArrays, change_no_output_if_the_other_one_is_refused)
{
    const Mat some = Mat::eye(3, 32, CV_8UC1), before = Mat::ones(5, 5, CV_8UC1);
    const std::vector<Point2f> positions(3);
    const KeyPoints keypoints(3);
    std::vector<Vec2i> pairsOfNumbers(1);
    const Mat fixed(7, 7, CV_32SC1);
    for (const bool isFixed : {false, true})
    {
        OutputArray refused = isFixed ? OutputArray(fixed) : OutputArray(pairsOfNumbers);
        Mat kept = before.clone();
        AQORB_BAD("distances", "", matchArrays(some, some, kept, refused));
        AQORB_BAD("distances", "", knnMatchArrays(some, some, kept, refused, 2));
        AQORB_BAD("distances", "",
                  matchByPosition(some, positions, some, keypoints, Size2f(1, 1), kept, refused));
        AQORB_BAD("pairs", "", matchArrays(some, some, refused, kept));
        AQORB_BAD("indices", "", knnMatchArrays(some, some, refused, kept, 2));
        EXPECT_TRUE(sameMat(before, kept));
    }
}

}  // namespace
}  // namespace opencv_test
