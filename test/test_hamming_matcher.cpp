// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "backends.hpp"
#include "reference.hpp"

#include <tuple>

namespace opencv_test
{
namespace
{

using aqorb::HammingMatcher;

//! Query descriptors, a collection of train descriptors and masks.
struct Problem
{
    Mat query;
    std::vector<Mat> images, masks;
    int normType, k;
    bool crossCheck, compactResult;
    float radius;
};

Mat randomMask(RNG& rng, int rows, int columns)
{
    Mat all(rows + 1, columns + 3, CV_8UC1);
    rng.fill(all, RNG::UNIFORM, 0, 256);
    const int kept = rng.uniform(0, 3);
    Mat mask = all(Rect(rng.uniform(0, 4), rng.uniform(0, 2), columns, rows));
    if (kept < 2)
        mask.setTo(0, mask < (kept == 0 ? 250 : 100));
    mask.row(rng.uniform(0, rows)).setTo(0);
    return mask;
}

// Mostly small ones, which include the edges of blocks and tiles.
int randomCount(RNG& rng)
{
    return rng.uniform(0, 20) == 0 ? rng.uniform(1, 501) : rng.uniform(1, 80);
}

Problem randomProblem(RNG& rng)
{
    Problem p;
    const int lengths[] = {32, 32, 32, rng.uniform(1, 65), rng.uniform(65, 1500)};
    const int bytes = lengths[rng.uniform(0, 5)];
    p.normType = rng.uniform(0, 3) ? NORM_HAMMING : NORM_HAMMING2;
    p.query = randomDescriptors(rng, randomCount(rng), bytes);
    p.crossCheck = rng.uniform(0, 3) == 0;
    const int count = p.crossCheck || rng.uniform(0, 2) ? 1 : rng.uniform(2, 5);
    const bool isMasked = !p.crossCheck && rng.uniform(0, 2);
    p.k = p.crossCheck ? 1 : rng.uniform(1, rng.uniform(0, 8) ? 8 : 200);
    for (int i = 0; i < count; i++)
    {
        // cv::BFMatcher is undefined where an image of several has fewer than k.
        p.images.push_back(randomDescriptors(rng, randomCount(rng) + (count > 1 ? p.k : 0), bytes));
        if (isMasked)
            p.masks.push_back(rng.uniform(0, 3) ? randomMask(rng, p.query.rows, p.images[i].rows) : Mat());
    }
    // Descriptors that both sets have.
    for (int i = rng.uniform(0, 10); i > 0; i--)
        p.images[0].row(rng.uniform(0, p.images[0].rows)).copyTo(p.query.row(rng.uniform(0, p.query.rows)));
    Mat(255 - p.query.row(0)).copyTo(p.images[0].row(0));  // all bits differ
    p.compactResult = rng.uniform(0, 2) != 0;
    p.radius = float(rng.uniform(1, bytes * 5));
    return p;
}

//! What match, knnMatch and radiusMatch find.
std::vector<MatchLists> matchesOf(DescriptorMatcher& matcher, const Problem& p)
{
    MatchLists best(1), nearest(3), withinRadius;  // knnMatch appends to what is there
    matcher.match(p.query, best[0], p.masks);
    matcher.knnMatch(p.query, nearest, p.k, p.masks, p.compactResult);
    matcher.radiusMatch(p.query, withinRadius, p.radius, p.masks, p.compactResult);
    return {best, nearest, withinRadius};
}

//! Equal distances in the order of the images and of their descriptors, as documented.
MatchLists inDocumentedOrder(MatchLists lists)
{
    for (std::vector<DMatch>& list : lists)
        std::sort(list.begin(), list.end(),
                  [](const DMatch& a, const DMatch& b) {
                      return std::tie(a.distance, a.imgIdx, a.trainIdx) <
                             std::tie(b.distance, b.imgIdx, b.trainIdx);
                  });
    return lists;
}

class Aqorb_HammingMatcher_Random : public ::testing::TestWithParam<int>
{
};

// The cases of one test take their seeds from it, so that ctest runs some at once.
TEST_P(Aqorb_HammingMatcher_Random, has_the_matches_of_bfmatcher)
{
    for (int i = 0; i < 700; i++)
    {
        RNG rng(uint64(GetParam()) * 10000 + i + 1);
        const Problem p = randomProblem(rng);
        const Threads threads(1 + i % 4);
        BFMatcher matcher(p.normType, p.crossCheck);
        const Ptr<HammingMatcher> hammingMatcher = HammingMatcher::create(p.normType, p.crossCheck);
        matcher.add(p.images);
        hammingMatcher->add(p.images);
        SCOPED_TRACE(format("case %d: %d queries of %d bytes, %d images, %s, k %d%s%s", i, p.query.rows,
                            p.query.cols, int(p.images.size()),
                            p.normType == NORM_HAMMING ? "HAMMING" : "HAMMING2", p.k,
                            p.crossCheck ? ", cross check" : "", p.masks.empty() ? "" : ", masks"));
        const std::vector<MatchLists> expected = matchesOf(matcher, p), found = matchesOf(*hammingMatcher, p);
        ASSERT_TRUE(sameMatches(expected[0], found[0]));
        ASSERT_TRUE(sameMatches(expected[1], found[1]));
        ASSERT_TRUE(sameMatches(inDocumentedOrder(expected[2]), found[2]));
    }
}

INSTANTIATE_TEST_SUITE_P(Seeds, Aqorb_HammingMatcher_Random, ::testing::Range(0, 8));

// Several tiles of trains and of queries for every kernel.
TEST(Aqorb_HammingMatcher, has_the_matches_of_bfmatcher_for_many_descriptors_however_threads_run)
{
    for (const int bytes : {16, 32, 61, 64})
    {
        RNG rng(bytes);
        Mat query = randomDescriptors(rng, 700, bytes), train = randomDescriptors(rng, 9000, bytes);
        train.rowRange(8000, 8400).copyTo(query.rowRange(100, 500));
        train.rowRange(8000, 8400).copyTo(train.rowRange(2000, 2400));
        const auto expectMatches = [&](bool crossCheck, int k)
        {
            MatchLists expected;
            BFMatcher(NORM_HAMMING, crossCheck).knnMatch(query, train, expected, k);
            for (const std::shared_ptr<Backend>& backend : backends())
            {
                const BackendScope scope(backend);
                const Threads threads(2);
                MatchLists found;
                HammingMatcher(NORM_HAMMING, crossCheck).knnMatch(query, train, found, k);
                EXPECT_TRUE(sameMatches(expected, found)) << k;
            }
        };
        for (const int k : {1, 2, 3, 300})
            expectMatches(false, k);
        expectMatches(true, 1);
        std::swap(query, train);
        expectMatches(true, 1);
    }
}

// cv::BFMatcher is undefined there: it reads what it has not written.
TEST(Aqorb_HammingMatcher, finds_the_nearest_of_images_with_fewer_than_k)
{
    for (int seed = 1; seed <= 200; seed++)
    {
        RNG rng(seed);
        const Mat query = randomDescriptors(rng, rng.uniform(1, 20), 32);
        std::vector<Mat> images, masks;
        for (int i = rng.uniform(2, 6); i > 0; i--)
        {
            images.push_back(randomDescriptors(rng, rng.uniform(1, 5), 32));
            if (seed % 2)
                masks.push_back(randomMask(rng, query.rows, images.back().rows));
        }
        HammingMatcher matcher;
        matcher.add(images);
        for (int k = 1; k <= 8; k++)
        {
            MatchLists matches, expected;
            matcher.knnMatch(query, matches, k, masks);
            for (int i = 0; i < query.rows; i++)
            {
                expected.push_back(referenceMatches(query, i, images, masks, NORM_HAMMING));
                expected.back().resize(std::min(expected.back().size(), size_t(k)));
            }
            EXPECT_TRUE(sameMatches(expected, matches));
        }
    }
}

TEST(Aqorb_HammingMatcher, is_used_through_a_pointer_to_its_base_and_takes_a_umat)
{
    RNG rng(1);
    const Mat query = randomDescriptors(rng, 50, 32), train = randomDescriptors(rng, 60, 32);
    const Ptr<BFMatcher> matcher = HammingMatcher::create(NORM_HAMMING, true);
    EXPECT_TRUE(matcher->isMaskSupported() && matcher->empty());
    MatchLists expected(1);
    BFMatcher(NORM_HAMMING, true).match(query, train, expected[0]);
    ASSERT_FALSE(expected[0].empty());
    const UMat utrain = train.getUMat(ACCESS_READ);
    for (const _InputArray& trains : {_InputArray(train), _InputArray(utrain)})
    {
        matcher->add(trains);
        matcher->train();
        const Ptr<DescriptorMatcher> copy = matcher->clone(), empty = matcher->clone(true);
        EXPECT_FALSE(copy.dynamicCast<HammingMatcher>().empty());
        EXPECT_FALSE(empty.dynamicCast<HammingMatcher>().empty());
        EXPECT_TRUE(empty->empty());
        for (const Ptr<DescriptorMatcher>& each : {Ptr<DescriptorMatcher>(matcher), copy})
        {
            MatchLists ofMat(1), ofUMat(1);
            each->match(query, ofMat[0]);
            each->match(query.getUMat(ACCESS_READ), ofUMat[0]);
            EXPECT_TRUE(sameMatches(expected, ofMat) && sameMatches(expected, ofUMat));
        }
        matcher->clear();
        EXPECT_TRUE(matcher->empty());
        EXPECT_FALSE(copy->empty());
    }
    matcher->add(train);
    EXPECT_NE(train.data, matcher->clone()->getTrainDescriptors().at(0).data);
}

TEST(Aqorb_HammingMatcher, has_no_match_without_descriptors)
{
    const Mat some = Mat::zeros(3, 32, CV_8UC1);
    MatchLists lists;
    std::vector<DMatch> matches;
    for (const Mat& none : {Mat(), Mat(0, 32, CV_8UC1), Mat(3, 0, CV_8UC1)})
    {
        for (const bool crossCheck : {false, true})
        {
            HammingMatcher matcher(NORM_HAMMING, crossCheck);
            for (const Mat& train : {some, none})
            {
                matcher.match(none, train, matches);
                EXPECT_TRUE(matches.empty());
            }
            matcher.match(some, none, matches);
            EXPECT_TRUE(matches.empty());
            lists.clear();
            matcher.knnMatch(some, none, lists, 1);
            EXPECT_TRUE(sameMatches(MatchLists(3), lists));
            matcher.radiusMatch(some, none, lists, 2);
            EXPECT_TRUE(sameMatches(MatchLists(3), lists));
        }
        HammingMatcher matcher;
        matcher.add(std::vector<Mat>{none, some, none});
        lists.clear();
        matcher.knnMatch(some, lists, 9);
        ASSERT_EQ(3u, lists.size());
        EXPECT_EQ(3u, lists[2].size());
    }
}

TEST(Aqorb_HammingMatcher, refuses_bad_input)
{
    const Mat some = Mat::zeros(3, 32, CV_8UC1), narrow = Mat::zeros(3, 16, CV_8UC1),
              real = Mat::zeros(3, 32, CV_32FC1), mask = Mat::ones(3, 3, CV_8UC1);
    HammingMatcher matcher, mutual(NORM_HAMMING, true);
    std::vector<DMatch> matches;
    MatchLists lists;
    const std::string trains = "trainDescriptors of image 0";
    AQORB_BAD("normType", "4", (void)HammingMatcher(NORM_L2));
    AQORB_BAD("normType", "-1", HammingMatcher::create(-1));
    AQORB_BAD("queryDescriptors", "CV_32FC1", matcher.match(real, some, matches));
    AQORB_BAD(trains, "CV_32FC1", matcher.match(some, real, matches));
    AQORB_BAD(trains, "16", matcher.match(some, narrow, matches));
    AQORB_BAD(trains, "16", matcher.radiusMatch(some, narrow, lists, 10));
    AQORB_BAD("crossCheck", "k = 2", mutual.knnMatch(some, some, lists, 2));
    AQORB_BAD("crossCheck", "a mask", mutual.match(some, some, matches, mask));
    mutual.add(std::vector<Mat>(2, some));
    AQORB_BAD("crossCheck", "2 images", mutual.match(some, matches));
    EXPECT_THROW(matcher.match(some, some, matches, Mat::ones(2, 3, CV_8UC1)), cv::Exception);
    // Behind an empty matrix, a UMat is the second image, and one mask is not for both.
    HammingMatcher matchers[2];
    for (HammingMatcher& each : matchers)
    {
        each.add(Mat(0, 32, CV_8UC1));
        each.add(some.getUMat(ACCESS_READ));
    }
    const std::vector<Mat> masks(1, mask);
    AQORB_BAD("masks", "1", matchers[0].knnMatch(some, lists, 1, masks));
    AQORB_BAD("masks", "1", matchers[1].radiusMatch(some, lists, 9, masks));
}

TEST(Aqorb_HammingMatcher, is_safe_in_several_threads)
{
    RNG rng(1);
    const Mat query = randomDescriptors(rng, 300, 32), train = randomDescriptors(rng, 300, 32);
    const HammingMatcher matcher(NORM_HAMMING, true);
    HammingMatcher ofCollection;
    ofCollection.add(std::vector<Mat>{train, query});
    std::vector<MatchLists> found(8, MatchLists(2));
    const auto match = [&](const Range& range)
    {
        for (int i = range.start; i < range.end; i++)
        {
            matcher.match(query, train, found[i][0]);
            ofCollection.match(query, found[i][1]);
        }
    };
    parallel_for_(Range(0, 8), match);
    for (const MatchLists& lists : found)
        EXPECT_TRUE(sameMatches(found[0], lists));
}

TEST(Aqorb_HammingMatcher, stays_on_one_thread_under_a_single_thread_scope)
{
    const std::shared_ptr<Counting> backend = std::make_shared<Counting>();
    const BackendScope scope(backend);
    const Threads threads(4);
    const Mat descriptors = makeNoise(Size(32, 1200)), longDescriptors = makeNoise(Size(1100, 40)),
              mask(1200, 1200, CV_8UC1, Scalar(1));
    const std::vector<KeyPoint> keypoints(1200, KeyPoint(1, 1, 31));
    const auto match = [&]
    {
        std::vector<std::vector<DMatch>> lists;
        std::vector<DMatch> matches;
        Mat pairs, distances;
        aqorb::HammingMatcher(NORM_HAMMING, true).match(descriptors, descriptors, matches);
        aqorb::HammingMatcher().knnMatch(descriptors, descriptors, lists, 3, mask);
        aqorb::HammingMatcher().radiusMatch(longDescriptors, longDescriptors, lists, 9);
        aqorb::matchArrays(descriptors, descriptors, pairs, distances);
        aqorb::matchByPosition(descriptors, std::vector<Point2f>(1200), descriptors, keypoints, Size2f(9, 9),
                               pairs, distances);
    };
    {
        const aqorb::SingleThreadScope alone;
        match();
    }
    EXPECT_EQ(0, backend->calls);
    match();
    EXPECT_GE(backend->calls, 5);
}

}  // namespace
}  // namespace opencv_test
