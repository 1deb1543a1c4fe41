// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// Grown matches: against a plain definition in double precision, and on images whose truth is known.

#include "reference_refinement.hpp"

#include <numeric>
#include <map>

namespace opencv_test
{
namespace
{

const double SAME = 1;  //!< pixels between two pairs that are one

struct Grown : Refined
{
    //! The number of grown matches that have a property.
    size_t count(const std::function<bool(size_t index)>& has) const
    {
        size_t sum = 0;
        for (size_t i = refined; i < matches.size(); i++)
            sum += has(i);
        return sum;
    }

    KeyPoints keypoints1, keypoints2;
    size_t refined = 0,
           into2 = 0;  //!< the numbers of matches that were not grown, and of those grown into image 2
};

Grown grow(const MatchedViews& views, bool bothWays = true, float minCorrelation = 0.8f)
{
    Grown grown;
    grown.matches = views.matches;
    aqorb::growMatches(views.image1, views.keypoints1, views.image2, views.keypoints2, grown.matches,
                       grown.keypoints1, grown.keypoints2, grown.points1, grown.points2, grown.deviations,
                       minCorrelation, 1, bothWays);
    for (const DMatch& match : grown.matches)
    {
        grown.refined += match.distance < FLT_MAX;
        grown.into2 += size_t(match.trainIdx) >= views.keypoints2.size();
    }
    return grown;
}

MatchedViews exchanged(const MatchedViews& views)
{
    MatchedViews other = {views.image2, views.image1, views.keypoints2, views.keypoints1, views.matches};
    for (DMatch& match : other.matches)
        std::swap(match.queryIdx, match.trainIdx);
    return other;
}

bool isSame(const Grown& a, const Grown& b)
{
    return isSame(static_cast<const Refined&>(a), static_cast<const Refined&>(b)) &&
           sameKeypoints(a.keypoints1, b.keypoints1) && sameKeypoints(a.keypoints2, b.keypoints2);
}

//! The first ones of refined matches.
Refined firstOf(Refined all, size_t count)
{
    all.matches.resize(count);
    all.points1.resize(count);
    all.points2.resize(count);
    all.deviations.resize(count);
    return all;
}

//! Views of which every fifth keypoint of image 1 has a match, or none if it is wrong.
MatchedViews sparseViews(const Matx23d& map, double noise = 2)
{
    MatchedViews views = viewsOf(Texture(3), map, 1, 0, noise);
    const std::vector<DMatch> all = views.matches;
    views.matches.clear();
    for (size_t i = 0; i < all.size(); i += 5)
        views.matches.push_back(all[i]);
    return views;
}

TEST(Aqorb_Growth, finds_the_matches_of_keypoints_without_one)
{
    const Matx23d maps[] = {similarity(1, 0, 0.37, -0.61), similarity(1, 25, 60.3, -40.7),
                            similarity(1.3, 0, -30.2, -20.9), Matx23d(1.05, 0.15, -10.3, -0.08, 0.95, 20.2)};
    for (const Matx23d& map : maps)
    {
        const MatchedViews views = sparseViews(map);
        const Grown grown = grow(views);
        ASSERT_EQ(views.matches.size(), grown.refined);
        EXPECT_GE(grown.refined + grown.into2, views.keypoints1.size() * 9 / 10) << Mat(map);
        size_t shown = 0;
        for (const KeyPoint& keypoint : views.keypoints2)
            shown += std::any_of(grown.points2.begin(), grown.points2.end(),
                                 [&](const Point2f& p) { return cv::norm(p - keypoint.pt) <= SAME; });
        EXPECT_GE(shown, views.keypoints2.size() * 9 / 10) << Mat(map);
        int wrong = 0, large = 0;
        Mat homography;
        KeyPoints expected;
        vconcat(map, Matx13d(0, 0, 1), homography);
        aqorb::transformKeypoints(grown.keypoints1, homography, expected);
        for (size_t i = 0; i < grown.matches.size(); i++)
        {
            const DMatch& match = grown.matches[i];
            const KeyPoint &first = grown.keypoints1[size_t(match.queryIdx)],
                           &second = grown.keypoints2[size_t(match.trainIdx)];
            const double error = errorOf(map, grown, i);
            wrong += error > 0.3;
            large += error > grown.deviations[i];
            EXPECT_EQ(first.pt, grown.points1[i]);
            if (i < grown.refined)
                continue;
            EXPECT_EQ(second.pt, grown.points2[i]);
            const KeyPoint& mappedFirst = expected[size_t(match.queryIdx)];
            EXPECT_NEAR(mappedFirst.size, second.size, 0.1 * second.size);
            EXPECT_NEAR(0, std::remainder(second.angle - mappedFirst.angle, 360), 6);
            EXPECT_EQ(FLT_MAX, match.distance);
            const bool isInto2 = i < grown.refined + grown.into2;
            const KeyPoint& moved = isInto2 ? second : first;
            EXPECT_TRUE(match.imgIdx == 0 && moved.response == 0 && moved.class_id == -1);
            EXPECT_EQ(isInto2 ? int(views.keypoints2.size() + i - grown.refined)
                              : int(views.keypoints1.size() + i - grown.refined - grown.into2),
                      isInto2 ? match.trainIdx : match.queryIdx);
            EXPECT_TRUE(i == grown.refined || i == grown.refined + grown.into2 ||
                        (isInto2 ? match.queryIdx > grown.matches[i - 1].queryIdx
                                 : match.trainIdx > grown.matches[i - 1].trainIdx));
        }
        EXPECT_LE(wrong, int(grown.matches.size()) / 50);
        EXPECT_LE(large, int(grown.matches.size()) / 3) << "deviations are too small";
    }
}

//! A refined match: its keypoints, its position in image 1, and the position and the map to image 2.
struct Seed
{
    int query, train;
    Point2d position1, position2;
    Matx22d map;
};

//! Matches that grew from keypoints of image 1 into image 2.
struct OneWay
{
    MatchedViews views;
    std::vector<Seed> seeds;
    std::vector<Point2f> found;  //!< positions in image 1 at which no keypoint is tried
    //! By the keypoint of image 1: that of image 2, and the deviation.
    std::map<int, std::pair<KeyPoint, float>> grown;
};

//! The way from image 1 to image 2, or back.
OneWay wayOf(const MatchedViews& views, const Grown& grown, bool isBack)
{
    OneWay way;
    way.views = isBack ? exchanged(views) : views;
    for (size_t i = 0; i < grown.matches.size(); i++)
    {
        const DMatch& match = grown.matches[i];
        if (i < grown.refined)
        {
            const KeyPoint &first = views.keypoints1[size_t(match.queryIdx)],
                           &second = views.keypoints2[size_t(match.trainIdx)];
            const ReferenceAlignment a =
                referenceRefinement(views.image1, first, views.image2, second, 0.8, 1);
            way.seeds.push_back(isBack
                                    ? Seed{match.trainIdx, match.queryIdx, a.position, first.pt, a.map.inv()}
                                    : Seed{match.queryIdx, match.trainIdx, first.pt, a.position, a.map});
            continue;
        }
        const bool isInto2 = i < grown.refined + grown.into2;
        if (isBack && isInto2)
            way.found.push_back(grown.points2[i]);
        if (isBack == isInto2)
            continue;
        const KeyPoint& second =
            isBack ? grown.keypoints1[size_t(match.queryIdx)] : grown.keypoints2[size_t(match.trainIdx)];
        way.grown[isBack ? match.trainIdx : match.queryIdx] = {second, grown.deviations[i]};
    }
    return way;
}

//! The plain definition: each keypoint without a match by itself.
TEST(Aqorb_Growth, equals_the_plain_definition)
{
    int compared = 0, kept = 0, otherwise = 0, notTried = 0;
    const auto compare = [&](const OneWay& way)
    {
        for (int i = 0; i < int(way.views.keypoints1.size()); i++)
        {
            const KeyPoint& keypoint = way.views.keypoints1[size_t(i)];
            const Seed* nearest = 0;
            double smallest = 60;
            bool isTried = true;
            for (const Seed& seed : way.seeds)
            {
                const double distance = cv::norm(Point2d(keypoint.pt) - seed.position1);
                isTried = isTried && seed.query != i;
                if (distance < smallest || (!nearest && distance == smallest))
                {
                    smallest = distance;
                    nearest = &seed;
                }
            }
            const bool isGrown = way.grown.count(i) > 0;
            for (const Point2f& other : way.found)
            {
                notTried += isTried && cv::norm(other - keypoint.pt) <= SAME;
                isTried = isTried && cv::norm(other - keypoint.pt) > SAME;
            }
            if (!isTried || !nearest)
            {
                EXPECT_FALSE(isGrown);
                continue;
            }
            const Point2d offset = Point2d(keypoint.pt) - nearest->position1;
            const Vec2d moved = nearest->map * Vec2d(offset.x, offset.y);
            const ReferenceStart start = {nearest->position2 + Point2d(moved[0], moved[1]), nearest->map};
            const ReferenceAlignment expected =
                referenceAlignment(way.views.image1, keypoint, way.views.image2, start, 1);
            const bool isExpected = expected.isAligned && expected.correlation >= 0.85 &&
                                    cv::norm(expected.position - start.position) <= 4;
            compared++;
            kept += isGrown;
            otherwise += isGrown != isExpected;
            if (!isGrown || !isExpected)
                continue;
            const KeyPoint& second = way.grown.at(i).first;
            otherwise += cv::norm(Point2d(second.pt) - expected.position) > 0.01;
            EXPECT_NEAR(1, way.grown.at(i).second / expected.deviation, 0.05);
            EXPECT_NEAR(keypoint.size * std::sqrt(std::abs(determinant(expected.map))), second.size,
                        0.01 * second.size);
            EXPECT_EQ(std::max(way.views.keypoints2[size_t(nearest->train)].octave + keypoint.octave -
                                   way.views.keypoints1[size_t(nearest->query)].octave,
                               0),
                      second.octave);
        }
    };
    for (int round = 1; round <= 12; round++)
    {
        RNG rng(round);
        MatchedViews views = sparseViews(similarity(rng.uniform(0.7, 1.4), rng.uniform(-30., 30.),
                                                    rng.uniform(-30., 40.), rng.uniform(-30., 30.)),
                                         rng.uniform(0., 30.));
        for (KeyPoints* keypoints : {&views.keypoints1, &views.keypoints2})
        {
            for (size_t i = 0; i < keypoints->size(); i++)
            {
                KeyPoint& keypoint = (*keypoints)[i];
                keypoint.octave = rng.uniform(0, 8);
                if (i % 5 == 0)
                    continue;   // it has a match
                if (round % 2)  // else several seeds are equally near
                    keypoint.pt += Point2f(rng.uniform(-15.f, 15.f), rng.uniform(-15.f, 15.f));
                keypoint.size *= rng.uniform(0, 4) ? 1 : rng.uniform(0.3f, 6.f);
            }
        }
        const Grown grown = grow(views);
        compare(wayOf(views, grown, false));
        compare(wayOf(views, grown, true));
        // One way is the beginning of both.
        const Grown one = grow(views, false);
        EXPECT_TRUE(isSame(static_cast<const Refined&>(one), firstOf(grown, grown.refined + grown.into2)));
        EXPECT_EQ(views.keypoints1.size(), one.keypoints1.size());
    }
    EXPECT_GT(kept, compared / 8);
    EXPECT_LT(kept, compared);
    EXPECT_LE(otherwise, compared / 100);
    EXPECT_GT(notTried, 20);
}

//! Two planes that move in different ways meet in the middle of the image.
TEST(Aqorb_Growth, does_not_carry_a_map_to_another_plane)
{
    const Matx23d maps[] = {similarity(1, 0, 2.3, -1.6), similarity(1, 8, 30.3, -9.4)};
    MatchedViews views = viewsOf(Texture(3), maps[0], 1, 0, 2);
    const MatchedViews other = viewsOf(Texture(8), maps[1], 1, 0, 2);
    const int middle = 160;
    const Range right(middle, views.image1.cols);
    other.image1.colRange(right).copyTo(views.image1.colRange(right));
    other.image2.colRange(right).copyTo(views.image2.colRange(right));
    views.keypoints1.clear();
    views.keypoints2.clear();
    views.matches.clear();
    size_t candidates = 0;
    for (int y = 24; y < 220; y += 6)
        for (int x = 24; x < 300; x += 6)
        {
            const int index = int(views.keypoints1.size());
            views.keypoints1.push_back(KeyPoint(float(x), float(y), 80, 350));
            candidates += x > middle + 16 && x < 195;
            if (x <= 110 || x >= 140 || index % 3)
                continue;  // Only the left plane has matches.
            views.matches.push_back(DMatch(index, int(views.keypoints2.size()), 0));
            views.keypoints2.push_back(KeyPoint(mapped(maps[0], Point2d(x, y)), 80, 350));
        }
    const Grown grown = grow(views);
    EXPECT_GT(grown.count([&](size_t i) { return grown.points1[i].x < middle - 20; }), 200u);
    EXPECT_LE(grown.count([&](size_t i) { return grown.points1[i].x > middle + 16; }), candidates / 20);
}

//! Where a texture repeats, a match that is wrong by a period grows wrong ones near it, and others grow right ones.
TEST(Aqorb_Growth, is_as_right_as_its_seeds_where_texture_repeats)
{
    const Matx23d map = similarity(1, 4, 12.3, -4.6);
    const Point2f period(40, 0);
    MatchedViews views = sparseViews(map);
    views.image1 = repeat(views.image1(Rect(0, 0, 40, 40)), 6, 8);
    warpAffine(views.image1, views.image2, map, views.image1.size());
    for (size_t i = 0; i < views.matches.size(); i += 4)
        views.keypoints2[size_t(views.matches[i].trainIdx)].pt += period;
    const Grown grown = grow(views);
    EXPECT_GE(grown.matches.size(), views.keypoints1.size() * 9 / 10);
    EXPECT_LE(grown.count([&](size_t i) { return errorOf(map, grown, i) > 0.5; }),
              (grown.matches.size() - grown.refined) / 3)
        << "of four seeds one is wrong";
}

TEST(Aqorb_Growth, leaves_out_what_something_hides_in_image_2)
{
    const Matx23d map = similarity(1, 4, 12.3, -4.6);
    MatchedViews views = sparseViews(map);
    const Rect hidden(120, 60, 90, 110), deep(125, 65, 80, 100);  // patches are 10 pixels wide
    viewsOf(Texture(8), map, 1, 0, 2).image2(hidden).copyTo(views.image2(hidden));
    const auto isHidden = [&](const Point2f& point) { return deep.contains(Point(mapped(map, point))); };
    const Grown grown = grow(views);
    size_t candidates = 0;
    for (const KeyPoint& keypoint : views.keypoints1)
        candidates += isHidden(keypoint.pt);
    size_t tried = candidates;
    for (const KeyPoint& keypoint : views.keypoints2)
        tried += deep.contains(Point(keypoint.pt));
    EXPECT_GE(grown.matches.size(), (views.keypoints1.size() - candidates) * 9 / 10);
    EXPECT_LE(grown.count([&](size_t i) { return isHidden(grown.points1[i]); }), tried / 10);
}

TEST(Aqorb_Growth, tries_keypoints_whose_match_was_removed)
{
    const Matx23d map = similarity(1, 5, 3.3, -4.8);
    MatchedViews views = viewsOf(Texture(3), map, 1, 0, 2);
    const size_t count = views.matches.size();
    for (size_t i = 0; i < count; i += 3)
        views.keypoints2[i].pt += Point2f(60, -35);
    const Grown grown = grow(views);
    EXPECT_LE(grown.refined, count * 3 / 4);
    EXPECT_GE(grown.matches.size(), count * 9 / 10);
    EXPECT_EQ(0u, grown.count([&](size_t i) { return errorOf(map, grown, i) >= 0.5; }));
}

TEST(Aqorb_Growth, begins_with_what_refineMatches_gives)
{
    MatchedViews views = sparseViews(similarity(1, 5, 3.3, -4.8), 10);
    views.keypoints2[0].pt.x += 70;
    for (float minCorrelation : {-1.f, 0.8f, 0.95f})
    {
        const Grown grown = grow(views, true, minCorrelation);
        EXPECT_TRUE(isSame(refine(views, minCorrelation), firstOf(grown, grown.refined)));
        EXPECT_EQ(views.keypoints2.size() + grown.into2, grown.keypoints2.size());
        EXPECT_EQ(views.keypoints1.size() + grown.matches.size() - grown.refined - grown.into2,
                  grown.keypoints1.size());
    }
    const Grown low = grow(views, true, 0.8f), high = grow(views, true, 0.95f);
    const size_t some = low.matches.size() - low.refined, fewer = high.matches.size() - high.refined;
    EXPECT_LT(fewer, some);
}

TEST(Aqorb_Growth, threads_colour_and_aliases_give_the_same_bytes)
{
    const MatchedViews views = sparseViews(similarity(1, 5, 3.3, -4.8));
    const Grown expected = grow(views);
    for (int count : {1, 2, 3, 16})
    {
        Threads threads(count);
        EXPECT_TRUE(isSame(expected, grow(views))) << count;
    }
    MatchedViews colour = views;
    cvtColor(views.image1, colour.image1, COLOR_GRAY2BGR);
    cvtColor(views.image2, colour.image2, COLOR_GRAY2BGRA);
    EXPECT_TRUE(isSame(expected, grow(colour)));

    Grown inPlace;
    inPlace.matches = views.matches;
    inPlace.keypoints1 = views.keypoints1;
    inPlace.keypoints2 = views.keypoints2;
    aqorb::growMatches(views.image1, inPlace.keypoints1, views.image2, inPlace.keypoints2, inPlace.matches,
                       inPlace.keypoints1, inPlace.keypoints2, inPlace.points1, inPlace.points2,
                       inPlace.deviations);
    EXPECT_TRUE(isSame(expected, inPlace));
}

TEST(Aqorb_Growth, bad_keypoints_grow_nothing_and_bad_arguments_raise)
{
    const MatchedViews good = sparseViews(similarity(1, 5, 3.3, -4.8));
    const size_t expected = grow(good, false).matches.size();
    MatchedViews views = good;
    for (const KeyPoint& bad : unusable(good.keypoints1[7]))
    {
        if (bad.size > 0 && bad.size < 1e-9f)
            continue;  // A size so small is bad for a match only, whose map it scales.
        SCOPED_TRACE(testing::Message() << bad.pt << ", " << bad.size << ", " << bad.angle);
        views.keypoints1[7] = bad;
        EXPECT_EQ(expected - 1, grow(views, false).matches.size());
        const Grown back = grow(exchanged(views));
        EXPECT_EQ(0u, back.count([&](size_t i) { return back.matches[i].trainIdx == 7; }));
    }
    views = good;
    views.keypoints1[7].octave = INT_MAX;
    views.keypoints1[size_t(views.matches[1].queryIdx)].octave = INT_MIN;
    EXPECT_EQ(expected, grow(views, false).matches.size());
    views = good;
    views.keypoints1[7].angle = -1;
    const Grown upright = grow(views, false);
    const auto isUpright = [&](size_t i)
    { return upright.keypoints2[size_t(upright.matches[i].trainIdx)].angle == -1; };
    EXPECT_EQ(1u, upright.count(isUpright));
    EXPECT_EQ(1u, upright.count([&](size_t i) { return upright.matches[i].queryIdx == 7 && isUpright(i); }));

    Grown outputs;
    outputs.matches = good.matches;
    outputs.deviations.resize(3);
    const std::string message = messageOf(
        [&]
        {
            aqorb::growMatches(good.image1, good.keypoints1, Mat(), good.keypoints2, outputs.matches,
                               outputs.keypoints1, outputs.keypoints2, outputs.points1, outputs.points2,
                               outputs.deviations);
        });
    EXPECT_NE(std::string::npos, message.find("image2 must"));
    EXPECT_TRUE(outputs.matches.size() == good.matches.size() && outputs.deviations.size() == 3);

    views.matches.clear();
    views.image1.release();
    const Grown none = grow(views);
    EXPECT_TRUE(none.matches.empty() && none.points1.empty() && none.deviations.empty());
    EXPECT_EQ(views.keypoints1.size(), none.keypoints1.size());
    EXPECT_EQ(views.keypoints2.size(), none.keypoints2.size());
}

TEST(Aqorb_MatchImages, makes_the_calls_that_the_header_lists)
{
    MatchedViews views = viewsOf(Texture(3), similarity(1.1, 20, 5, -8), 1, 0, 2);
    const Ptr<AdaptiveQuadtreeORB> detector = AdaptiveQuadtreeORB::create(300);
    const Features features[] = {detectAndCompute(*detector, views.image1),
                                 detectAndCompute(*detector, views.image2)};
    aqorb::HammingMatcher(NORM_HAMMING, true)
        .match(features[0].descriptors, features[1].descriptors, views.matches);
    views.keypoints1 = features[0].keypoints;
    views.keypoints2 = features[1].keypoints;
    const Grown expected = grow(views);
    std::vector<size_t> order(expected.matches.size());
    std::iota(order.begin(), order.end(), size_t(0));
    std::stable_sort(order.begin(), order.end(),
                     [&](size_t a, size_t b) { return expected.deviations[a] < expected.deviations[b]; });
    for (const int count : {1, 4})
    {
        const Threads threads(count);
        std::vector<Point2f> points1(1), points2;
        std::vector<float> deviations(2);
        aqorb::matchImages(views.image1, views.image2.getUMat(ACCESS_READ), points1, points2, deviations,
                           300);
        ASSERT_GT(order.size(), 100u);
        ASSERT_EQ(order.size(), deviations.size());
        for (size_t i = 0; i < order.size(); i++)
            ASSERT_TRUE(points1[i] == expected.points1[order[i]] &&
                        points2[i] == expected.points2[order[i]] &&
                        deviations[i] == expected.deviations[order[i]]);
    }
}

TEST(Aqorb_MatchImages, gives_no_points_of_empty_images_and_refuses_bad_ones)
{
    const Mat image = viewsOf(Texture(3), similarity(1, 0, 3, 0)).image1, black = Mat::zeros(90, 80, CV_8UC3);
    std::vector<Point2f> points1(3), points2(3);
    std::vector<float> deviations(3);
    const auto match = [&](InputArray a, InputArray b, int n = 500)
    { aqorb::matchImages(a, b, points1, points2, deviations, n); };
    AQORB_BAD("image1", "CV_32F", match(Mat1f(9, 9), image));
    AQORB_BAD("image2", "CV_8UC2", match(image, Mat(9, 9, CV_8UC2)));
    AQORB_BAD("image2", "2", match(image, std::vector<Mat>(2, image)));
    AQORB_BAD("nfeatures", "-1", match(image, image, -1));
    EXPECT_EQ(3u, points1.size() + points2.size() - deviations.size());
    for (const Mat& nothing : {Mat(), black})
    {
        for (const bool isFirst : {true, false})
        {
            points1.resize(3);
            isFirst ? match(nothing, image) : match(image, nothing);
            EXPECT_TRUE(points1.empty() && points2.empty() && deviations.empty());
        }
    }
    match(image, noArray());
    match(image, image, 0);
    EXPECT_TRUE(points1.empty());
}

TEST(Aqorb_Growth, transformed_keypoints_follow_the_homography)
{
    const Matx33d homography(0.8, -0.3, 40, 0.35, 0.9, -12, 4e-4, -3e-4, 1),
        mirrored(-1, 0, 90, 0, 1, 0, 0, 0, 1);
    const auto at = [](const Matx33d& h, const Vec2d& p)
    {
        const Vec3d moved = h * Vec3d(p[0], p[1], 1);
        return Vec2d(moved[0] / moved[2], moved[1] / moved[2]);
    };
    RNG rng(5);
    for (const Matx33d& h : {homography, mirrored, homography * -3})
    {
        KeyPoints keypoints, transformed;
        for (int i = 0; i < 100; i++)
            keypoints.push_back(KeyPoint(rng.uniform(0.f, 640.f), rng.uniform(0.f, 480.f),
                                         rng.uniform(5.f, 99.f), i ? rng.uniform(0.f, 360.f) : -1, 7, i % 8,
                                         i));
        aqorb::transformKeypoints(keypoints, h, transformed);
        ASSERT_EQ(keypoints.size(), transformed.size());
        for (size_t i = 0; i < keypoints.size(); i++)
        {
            // Differences of positions a hundredth of a pixel apart, in the keypoint's direction and across.
            const KeyPoint &k = keypoints[i], &t = transformed[i];
            const double step = 0.01, angle = k.angle * CV_PI / 180;
            const Vec2d p(k.pt.x, k.pt.y), along(step * std::cos(angle), step * std::sin(angle));
            const Vec2d across(-along[1], along[0]), position = at(h, p);
            const Vec2d u = (at(h, p + along) - at(h, p - along)) / (2 * step);
            const Vec2d v = (at(h, p + across) - at(h, p - across)) / (2 * step);
            EXPECT_LT(cv::norm(Vec2d(t.pt.x, t.pt.y) - position), 1e-3);
            EXPECT_NEAR(k.size * std::sqrt(std::abs(u[0] * v[1] - u[1] * v[0])), t.size, 1e-4 * k.size);
            const double turned = i ? std::atan2(u[1], u[0]) * 180 / CV_PI - t.angle : -1 - t.angle;
            EXPECT_LT(std::abs(std::remainder(turned, 360)), 0.02);  // that of cv::fastAtan2
            EXPECT_TRUE(t.octave == k.octave && t.response == k.response && t.class_id == k.class_id);
        }
        aqorb::transformKeypoints(keypoints, Mat(h), keypoints);
        EXPECT_EQ(transformed[9].pt, keypoints[9].pt);
    }
    KeyPoints infinite(1, KeyPoint(10, 20, 31));
    aqorb::transformKeypoints(infinite, Matx33d(1, 0, 0, 0, 1, 0, 1, 0, -10), infinite);
    EXPECT_FALSE(std::isfinite(infinite[0].pt.x));
    Matx33d bad = homography;
    bad(1, 1) = std::numeric_limits<double>::quiet_NaN();
    for (const Mat& wrong : {Mat(), Mat(Mat::eye(2, 3, CV_64F)), Mat(Mat::zeros(3, 3, CV_64FC2)), Mat(bad)})
        EXPECT_NE(std::string::npos, messageOf([&] { aqorb::transformKeypoints(infinite, wrong, infinite); })
                                         .find("homography must be 3x3"));
}

}  // namespace
}  // namespace opencv_test
