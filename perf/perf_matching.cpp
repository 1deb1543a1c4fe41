// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// cv::BFMatcher and HammingMatcher side by side. The matcher is the last parameter, so that the two of a case run one
// right after the other and see the same load of the machine.

#include "perf_precomp.hpp"
#include "perf_scene.hpp"

namespace opencv_test
{
namespace
{

enum MatcherId
{
    CV_BFMATCHER,
    HAMMING_MATCHER
};
CV_ENUM(Matcher, CV_BFMATCHER, HAMMING_MATCHER)

typedef tuple<int, int, Matcher> Count_Bytes_Matcher_t;
typedef perf::TestBaseWithParam<Count_Bytes_Matcher_t> Matching;

#define MATCHING_PARAMS \
    testing::Combine(testing::Values(500, 1000, 2000, 5000), testing::Values(32, 64), Matcher::all())

Ptr<BFMatcher> createMatcher(Matcher matcher, bool crossCheck)
{
    if (matcher == HAMMING_MATCHER)
        return aqorb::HammingMatcher::create(NORM_HAMMING, crossCheck);
    return BFMatcher::create(NORM_HAMMING, crossCheck);
}

//! Random descriptors of which half have a copy with some other bits.
void makeDescriptors(int count, int bytes, Mat& query, Mat& train)
{
    RNG rng(1);
    query.create(count, bytes, CV_8UC1);
    train.create(count, bytes, CV_8UC1);
    rng.fill(query, RNG::UNIFORM, 0, 256);
    rng.fill(train, RNG::UNIFORM, 0, 256);
    for (int i = 0; i < count; i += 2)
    {
        query.row(i).copyTo(train.row(count - 1 - i));
        for (int j = 0; j < 20; j++)
            train.at<uchar>(count - 1 - i, rng.uniform(0, bytes)) ^= uchar(1 << rng.uniform(0, 8));
    }
}

PERF_TEST_P(Matching, crossCheck, MATCHING_PARAMS)
{
    Mat query, train;
    makeDescriptors(get<0>(GetParam()), get<1>(GetParam()), query, train);
    const Ptr<BFMatcher> matcher = createMatcher(get<2>(GetParam()), true);
    std::vector<DMatch> matches;

    TEST_CYCLE() matcher->match(query, train, matches);

    EXPECT_GE((int)matches.size(), query.rows / 2);
    SANITY_CHECK_NOTHING();
}

PERF_TEST_P(Matching, knnMatch, MATCHING_PARAMS)
{
    Mat query, train;
    makeDescriptors(get<0>(GetParam()), get<1>(GetParam()), query, train);
    const Ptr<BFMatcher> matcher = createMatcher(get<2>(GetParam()), false);
    std::vector<std::vector<DMatch>> matches;

    TEST_CYCLE()
    {
        matches.clear();
        matcher->knnMatch(query, train, matches, 2);
    }

    EXPECT_EQ(query.rows, (int)matches.size());
    SANITY_CHECK_NOTHING();
}

PERF_TEST_P(Matching, radiusMatch, MATCHING_PARAMS)
{
    Mat query, train;
    makeDescriptors(get<0>(GetParam()), get<1>(GetParam()), query, train);
    const Ptr<BFMatcher> matcher = createMatcher(get<2>(GetParam()), false);
    std::vector<std::vector<DMatch>> matches;

    TEST_CYCLE() matcher->radiusMatch(query, train, matches, 64);

    EXPECT_EQ(query.rows, (int)matches.size());
    SANITY_CHECK_NOTHING();
}

typedef perf::TestBaseWithParam<int> Refinement;

PERF_TEST_P(Refinement, refineMatches, testing::Values(500, 1000, 2000))
{
    const Mat image = makeStreetScene(Size(640, 480));
    const Mat part = image(Rect(1, 1, 639, 479));
    std::vector<KeyPoint> keypoints;
    aqorb::AdaptiveQuadtreeORB::create(GetParam())->detect(image, keypoints);
    std::vector<DMatch> all, matches;
    for (int i = 0; i < (int)keypoints.size(); i++)
        all.push_back(DMatch(i, i, 0));
    std::vector<Point2f> points1, points2;

    TEST_CYCLE()
    {
        matches = all;
        aqorb::refineMatches(image, keypoints, part, keypoints, matches, points1, points2);
    }

    EXPECT_GT(matches.size(), all.size() / 2);
    SANITY_CHECK_NOTHING();
}

}  // namespace
}  // namespace opencv_test
