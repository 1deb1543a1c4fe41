// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "backends.hpp"
#include "reference.hpp"

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

std::vector<DMatch> matchesOf(DescriptorMatcher& matcher, const Problem& p)
{
    std::vector<DMatch> matches;
    matcher.match(p.query, matches, p.masks);
    return matches;
}

MatchLists neighboursOf(DescriptorMatcher& matcher, const Problem& p)
{
    MatchLists matches(3);  // knnMatch appends to what is there
    matcher.knnMatch(p.query, matches, p.k, p.masks, p.compactResult);
    return matches;
}

MatchLists withinRadiusOf(DescriptorMatcher& matcher, const Problem& p)
{
    MatchLists matches;
    matcher.radiusMatch(p.query, matches, p.radius, p.masks, p.compactResult);
    return matches;
}

//! Equal distances in the order of the images and of their descriptors, as documented.
MatchLists inDocumentedOrder(MatchLists lists)
{
    for (std::vector<DMatch>& list : lists)
        std::sort(list.begin(), list.end(),
                  [](const DMatch& a, const DMatch& b)
                  {
                      if (a.distance != b.distance)
                          return a.distance < b.distance;
                      return a.imgIdx != b.imgIdx ? a.imgIdx < b.imgIdx : a.trainIdx < b.trainIdx;
                  });
    return lists;
}

// The cases of one test take their seeds from it, so that ctest runs some at once.
void compareWithBFMatcher(int seed, int cases)
{
    for (int i = 0; i < cases; i++)
    {
        RNG rng(uint64(seed) * 10000 + i + 1);
        const Problem p = randomProblem(rng);
        const Threads threads(1 + i % 4);
        BFMatcher expected(p.normType, p.crossCheck);
        const Ptr<HammingMatcher> matcher = HammingMatcher::create(p.normType, p.crossCheck);
        expected.add(p.images);
        matcher->add(p.images);
        SCOPED_TRACE(format("case %d: %d queries of %d bytes, %d images, %s, k %d%s%s", i, p.query.rows,
                            p.query.cols, int(p.images.size()),
                            p.normType == NORM_HAMMING ? "HAMMING" : "HAMMING2", p.k,
                            p.crossCheck ? ", cross check" : "", p.masks.empty() ? "" : ", masks"));
        const MatchLists best(1, matchesOf(expected, p));
        ASSERT_TRUE(sameMatches(best, MatchLists(1, matchesOf(*matcher, p))));
        ASSERT_TRUE(sameMatches(neighboursOf(expected, p), neighboursOf(*matcher, p)));
        ASSERT_TRUE(sameMatches(inDocumentedOrder(withinRadiusOf(expected, p)), withinRadiusOf(*matcher, p)));
    }
}

class Aqorb_HammingMatcher_Random : public ::testing::TestWithParam<int>
{
};

TEST_P(Aqorb_HammingMatcher_Random, has_the_matches_of_bfmatcher)
{
    compareWithBFMatcher(GetParam(), 700);
}

INSTANTIATE_TEST_SUITE_P(Seeds, Aqorb_HammingMatcher_Random, ::testing::Range(0, 8));

// Several tiles of trains and of queries for every kernel.
TEST(Aqorb_HammingMatcher, has_the_matches_of_bfmatcher_for_many_descriptors)
{
    for (const int bytes : {16, 32, 61, 64})
    {
        RNG rng(bytes);
        Problem p;
        p.query = randomDescriptors(rng, 700, bytes);
        p.images.push_back(randomDescriptors(rng, 9000, bytes));
        p.images[0].rowRange(8000, 8400).copyTo(p.query.rowRange(100, 500));
        p.images[0].rowRange(8000, 8400).copyTo(p.images[0].rowRange(2000, 2400));
        p.normType = NORM_HAMMING;
        HammingMatcher nearest(p.normType), mutual(p.normType, true);
        for (const int k : {1, 2, 3, 300})
        {
            p.k = k;
            MatchLists expected, matches;
            BFMatcher(p.normType).knnMatch(p.query, p.images[0], expected, p.k);
            nearest.knnMatch(p.query, p.images[0], matches, p.k);
            EXPECT_TRUE(sameMatches(expected, matches));
        }
        for (int turn = 0; turn < 2; turn++, std::swap(p.query, p.images[0]))
        {
            MatchLists expected(1), matches(1);
            BFMatcher(p.normType, true).match(p.query, p.images[0], expected[0]);
            mutual.match(p.query, p.images[0], matches[0]);
            EXPECT_TRUE(sameMatches(expected, matches));
        }
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
    EXPECT_TRUE(matcher->isMaskSupported());
    EXPECT_TRUE(matcher->empty());
    matcher->add(train);
    matcher->train();
    EXPECT_EQ(1u, matcher->getTrainDescriptors().size());

    const Ptr<DescriptorMatcher> copy = matcher->clone(), empty = matcher->clone(true);
    EXPECT_FALSE(copy.dynamicCast<HammingMatcher>().empty());
    EXPECT_FALSE(empty.dynamicCast<HammingMatcher>().empty());
    EXPECT_TRUE(empty->empty());
    EXPECT_NE(train.data, copy->getTrainDescriptors()[0].data);

    BFMatcher expected(NORM_HAMMING, true);
    MatchLists matches(3);
    expected.match(query, train, matches[0]);
    matcher->match(query.getUMat(ACCESS_READ), matches[1]);
    copy->match(query, matches[2]);
    EXPECT_FALSE(matches[0].empty());
    EXPECT_TRUE(sameMatches(MatchLists(1, matches[0]), MatchLists(1, matches[1])));
    EXPECT_TRUE(sameMatches(MatchLists(1, matches[0]), MatchLists(1, matches[2])));
    matcher->clear();
    EXPECT_TRUE(matcher->empty());
    matcher->add(train.getUMat(ACCESS_READ));
    for (const Ptr<DescriptorMatcher>& each : {Ptr<DescriptorMatcher>(matcher), matcher->clone()})
    {
        each->match(query, matches[2]);
        EXPECT_TRUE(sameMatches(MatchLists(1, matches[0]), MatchLists(1, matches[2])));
    }
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

// Behind an empty matrix, a UMat is the second image, and one mask is not for both.
TEST(Aqorb_HammingMatcher, refuses_a_mask_of_another_image)
{
    const Mat some = Mat::zeros(3, 32, CV_8UC1);
    const std::vector<Mat> mask(1, Mat::zeros(3, 3, CV_8UC1));
    for (const bool isRadius : {false, true})
    {
        HammingMatcher matcher;
        matcher.add(Mat(0, 32, CV_8UC1));
        matcher.add(some.getUMat(ACCESS_READ));
        MatchLists lists;
        const std::string message = messageOf(
            [&] {
                isRadius ? matcher.radiusMatch(some, lists, 9, mask) : matcher.knnMatch(some, lists, 1, mask);
            });
        EXPECT_EQ("masks must have 2 elements, one for each image, got 1", message);
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
}

TEST(Aqorb_HammingMatcher, has_the_same_matches_however_threads_run)
{
    RNG rng(1);
    const Mat query = randomDescriptors(rng, 1000, 32), train = randomDescriptors(rng, 4500, 32);
    std::vector<std::shared_ptr<Backend>> all = backends();
    all.insert(all.begin(), std::shared_ptr<Backend>());
    std::vector<MatchLists> results;
    for (const std::shared_ptr<Backend>& backend : all)
    {
        const BackendScope scope(backend);
        const Threads threads(backend ? 2 : 1);
        MatchLists lists(1);
        HammingMatcher(NORM_HAMMING, true).match(query, train, lists[0]);
        HammingMatcher().knnMatch(query, train, lists, 2);
        HammingMatcher().knnMatch(query, train, lists, 3);
        results.push_back(lists);
        EXPECT_TRUE(sameMatches(results[0], lists));
    }
}

TEST(Aqorb_HammingMatcher, is_safe_in_several_threads)
{
    RNG rng(1);
    const Mat query = randomDescriptors(rng, 300, 32), train = randomDescriptors(rng, 300, 32);
    const HammingMatcher matcher(NORM_HAMMING, true);
    HammingMatcher ofCollection;
    ofCollection.add(std::vector<Mat>{train, query});
    MatchLists results(8), ofAll(8);
    parallel_for_(Range(0, 8),
                  [&](const Range& range)
                  {
                      for (int i = range.start; i < range.end; i++)
                      {
                          matcher.match(query, train, results[i]);
                          ofCollection.match(query, ofAll[i]);
                      }
                  });
    for (int i = 1; i < 8; i++)
    {
        EXPECT_TRUE(sameMatches(MatchLists(1, results[0]), MatchLists(1, results[i])));
        EXPECT_TRUE(sameMatches(MatchLists(1, ofAll[0]), MatchLists(1, ofAll[i])));
    }
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
