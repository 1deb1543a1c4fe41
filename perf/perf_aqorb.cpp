// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// Performance of AdaptiveQuadtreeORB, HammingMatcher and refineMatches, or of cv::ORB, cv::BFMatcher and
// cv::calcOpticalFlowPyrLK.

#include "perf_precomp.hpp"

#ifdef HAVE_OPENCV_VIDEO
#include "opencv2/video/tracking.hpp"
#endif

namespace opencv_test
{
namespace
{

typedef perf::TestBaseWithParam<tuple<std::string, int>> Features;

PERF_TEST_P(Features, detectAndCompute,
            testing::Combine(testing::Values("leuven", "bikes", "bark", "trees", "ubc", "640x512.png",
                                             "1920x1080.png", "scene_640x480", "scene_1920x1080"),
                             testing::Values(500, 1000, 2000)))
{
    const Mat image = loadImage(get<0>(GetParam()));
    const int nfeatures = get<1>(GetParam());
    const Ptr<ORB> detector =
        isOfOpenCV() ? ORB::create(nfeatures) : Ptr<ORB>(aqorb::AdaptiveQuadtreeORB::create(nfeatures));
    std::vector<KeyPoint> keypoints;
    Mat descriptors;
    detector->detectAndCompute(image, noArray(), keypoints, descriptors);  // fills caches and allocates

    TEST_CYCLE() detector->detectAndCompute(image, noArray(), keypoints, descriptors);

    EXPECT_GT(keypoints.size(), 20u);
    EXPECT_EQ((int)keypoints.size(), descriptors.rows);
    SANITY_CHECK_NOTHING();
}

typedef perf::TestBaseWithParam<tuple<int, int, bool>> Matching;
typedef perf::TestBaseWithParam<tuple<int, int, bool>> NearestNeighbours;

Ptr<BFMatcher> createMatcher(bool crossCheck)
{
    if (isOfOpenCV())
        return BFMatcher::create(NORM_HAMMING, crossCheck);
    return aqorb::HammingMatcher::create(NORM_HAMMING, crossCheck);
}

//! Random descriptors. Half of the queries have a copy among the trains, with some bits changed.
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

PERF_TEST_P(Matching, match,
            testing::Combine(testing::Values(500, 1000, 2000, 5000), testing::Values(32, 64),
                             testing::Bool()))
{
    Mat query, train;
    makeDescriptors(get<0>(GetParam()), get<1>(GetParam()), query, train);
    const Ptr<BFMatcher> matcher = createMatcher(get<2>(GetParam()));  // with a cross check, or without
    std::vector<DMatch> matches;

    TEST_CYCLE() matcher->match(query, train, matches);

    EXPECT_GE((int)matches.size(), query.rows / 2);
    SANITY_CHECK_NOTHING();
}

PERF_TEST_P(NearestNeighbours, knnMatch,
            testing::Combine(testing::Values(1000, 5000), testing::Values(2, 10, 100), testing::Bool()))
{
    Mat query, train, mask;
    makeDescriptors(get<0>(GetParam()), 32, query, train);
    if (get<2>(GetParam()))
        mask = Mat(query.rows, train.rows, CV_8UC1, Scalar(1));  // allows all
    const Ptr<BFMatcher> matcher = createMatcher(false);
    std::vector<std::vector<DMatch>> matches;

    TEST_CYCLE()
    {
        matches.clear();
        matcher->knnMatch(query, train, matches, get<1>(GetParam()), mask);
    }

    EXPECT_EQ(query.rows, (int)matches.size());
    SANITY_CHECK_NOTHING();
}

//! Two photographs of a scene with their keypoints and matches.
struct Views
{
    Views(const std::string& name, int nfeatures)
    {
        const Ptr<Feature2D> detector = aqorb::AdaptiveQuadtreeORB::create(nfeatures);
        Mat descriptors[2];
        for (int i = 0; i < 2; i++)
        {
            images[i] = loadImage(name, i + 1);
            detector->detectAndCompute(images[i], noArray(), keypoints[i], descriptors[i]);
        }
        aqorb::HammingMatcher::create(NORM_HAMMING, true)->match(descriptors[0], descriptors[1], matches);
    }

    Mat images[2];
    std::vector<KeyPoint> keypoints[2];
    std::vector<DMatch> matches;
};

typedef perf::TestBaseWithParam<tuple<std::string, int>> Refinement;

//! Refines the cross-checked matches of two images. Both functions take the same window, one level and four iterations.
PERF_TEST_P(Refinement, refineMatches,
            testing::Combine(testing::Values("bikes", "leuven", "bark", "trees", "ubc", "scene_640x480"),
                             testing::Values(500, 1000, 2000)))
{
#ifndef HAVE_OPENCV_VIDEO
    if (isOfOpenCV())
        throw SkipTestException("OpenCV is built without its module video");
#endif
    const Views views(get<0>(GetParam()), get<1>(GetParam()));
    std::vector<DMatch> matches;
    std::vector<Point2f> points1, points2, starts;
    for (const DMatch& match : views.matches)
    {
        points1.push_back(views.keypoints[0][match.queryIdx].pt);
        starts.push_back(views.keypoints[1][match.trainIdx].pt);
    }

    TEST_CYCLE()
    {
        if (!isOfOpenCV())
        {
            matches = views.matches;
            aqorb::refineMatches(views.images[0], views.keypoints[0], views.images[1], views.keypoints[1],
                                 matches, points1, points2);
            continue;
        }
#ifdef HAVE_OPENCV_VIDEO
        std::vector<uchar> status;
        std::vector<float> errors;
        points2 = starts;
        calcOpticalFlowPyrLK(views.images[0], views.images[1], points1, points2, status, errors, Size(13, 13),
                             0, TermCriteria(TermCriteria::COUNT, 4, 0), OPTFLOW_USE_INITIAL_FLOW);
#endif
    }

    EXPECT_GT(points2.size(), views.matches.size() / 4);
    SANITY_CHECK_NOTHING();
}

typedef perf::TestBaseWithParam<tuple<std::string, bool>> Growth;

//! Grows the cross-checked matches of two images one way or both ways.
PERF_TEST_P(Growth, growMatches, testing::Combine(testing::Values("bikes", "scene_640x480"), testing::Bool()))
{
    if (isOfOpenCV())
        throw SkipTestException("OpenCV has no such function");
    const Views views(get<0>(GetParam()), 1000);
    std::vector<KeyPoint> grown[2];
    std::vector<DMatch> matches;
    std::vector<Point2f> points1, points2;
    std::vector<float> deviations;

    TEST_CYCLE()
    {
        matches = views.matches;
        aqorb::growMatches(views.images[0], views.keypoints[0], views.images[1], views.keypoints[1], matches,
                           grown[0], grown[1], points1, points2, deviations, 0.8f, 1.f, get<1>(GetParam()));
    }

    EXPECT_GT(points2.size(), views.matches.size() / 4);
    SANITY_CHECK_NOTHING();
}

typedef perf::TestBaseWithParam<int> GuidedMatching;

//! Matches random descriptors of a rectified pair of images along rows.
PERF_TEST_P(GuidedMatching, matchGuided, testing::Values(500, 1000, 2000))
{
    if (isOfOpenCV())
        throw SkipTestException("OpenCV has no such function");
    Mat query, train, pairs, distances;
    makeDescriptors(GetParam(), 32, query, train);
    std::vector<KeyPoint> queries;
    RNG rng(1);
    for (int i = 0; i < GetParam(); i++)
        queries.push_back(KeyPoint(rng.uniform(0.f, 1024.f), rng.uniform(0.f, 683.f), 31));
    const std::vector<KeyPoint> trains(queries.rbegin(), queries.rend());

    TEST_CYCLE()
    aqorb::matchGuided(query, queries, train, trains, Matx33d(0, 0, 0, 0, 0, -1, 0, 1, 0), 3, pairs,
                       distances);

    EXPECT_GT(pairs.rows, GetParam() / 3);
    SANITY_CHECK_NOTHING();
}

}  // namespace
}  // namespace opencv_test
