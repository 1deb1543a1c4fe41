// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// The refinement of matches: against a plain definition in double precision, and on images whose truth is known.

#include "reference_refinement.hpp"

namespace opencv_test
{
namespace
{

using aqorb::refineMatches;

TEST(Aqorb_Refinement, finds_the_positions_of_an_analytic_texture)
{
    struct
    {
        Matx23d map;
        double gain, bias, noise, error;  // error: the limit of the median, in pixels; noise in grey values
    } const views[] = {
        {similarity(1, 0, 0.37, -0.61), 1, 0, 0, 0.02},
        {similarity(1, 25, 60.3, -40.7), 1, 0, 0, 0.02},
        {similarity(1.3, 0, -30.2, -20.9), 1, 0, 0, 0.02},
        {similarity(0.8, -10, 20.5, 60.1), 1, 0, 0, 0.02},
        {Matx23d(1.05, 0.15, -10.3, -0.08, 0.95, 20.2), 1, 0, 0, 0.02},
        {similarity(1, 5, 3.3, -4.8), 0.5, 70, 0, 0.02},
        {similarity(1, 5, 3.3, -4.8), 1, 0, 4, 0.1},
        {similarity(1, 5, 3.3, -4.8), 1, 0, 8, 0.2},
    };
    for (const auto& view : views)
    {
        const MatchedViews pair = viewsOf(Texture(3), view.map, view.gain, view.bias, view.noise);
        const Refined refined = refine(pair);
        ASSERT_EQ(refined.matches.size(), pair.matches.size()) << Mat(view.map);
        std::vector<double> errors;
        for (size_t i = 0; i < refined.matches.size(); i++)
            errors.push_back(errorOf(view.map, refined, i));
        std::sort(errors.begin(), errors.end());
        EXPECT_LT(errors[errors.size() / 2], view.error) << Mat(view.map) << view.noise;
        EXPECT_LT(errors[errors.size() * 95 / 100], 3 * view.error) << Mat(view.map) << view.noise;
    }
}

//! A scene and its view by a homography, with matches of which some are wrong. Braces let every compiler draw numbers
//! in the same order.
MatchedViews randomPair(int seed)
{
    RNG rng(seed);
    MatchedViews pair;
    const Size size{rng.uniform(2, 300), rng.uniform(2, 300)};
    pair.image1 = makeScene(size, seed);
    Matx33d view = Matx33d::eye();
    for (int i = 0; i < 6; i++)
        view.val[i] = i % 3 == 2   ? rng.uniform(-9., 9.)
                      : i % 4 == 0 ? rng.uniform(0.7, 1.4)
                                   : rng.uniform(-.2, .2);
    warpPerspective(pair.image1, pair.image2, view, Size{rng.uniform(2, 300), rng.uniform(2, 300)},
                    INTER_LINEAR, BORDER_REFLECT_101);
    const int count = rng.uniform(0, 300);
    for (int i = 0; i < count; i++)
    {
        const double x = rng.uniform(-3., size.width + 3.), y = rng.uniform(-3., size.height + 3.);
        const double size1 = rng.uniform(0, 8) ? rng.uniform(20., 120.) : rng.uniform(1., 900.);
        const Point2d seen{view(0, 0) * x + view(0, 1) * y + view(0, 2) + rng.uniform(-2., 2.),
                           view(1, 0) * x + view(1, 1) * y + view(1, 2) + rng.uniform(-2., 2.)};
        const float angle = rng.uniform(0, 5) ? float(rng.uniform(0., 360.)) : -1;
        pair.keypoints1.push_back(KeyPoint(Point2f(float(x), float(y)), float(size1), angle));
        pair.keypoints2.push_back(KeyPoint{seen, float(size1 * rng.uniform(0.7, 1.4)),
                                           rng.uniform(0, 5) ? angle : float(rng.uniform(0., 360.))});
        pair.matches.push_back(DMatch(i, rng.uniform(0, 6) ? i : rng.uniform(0, i + 1), 0, float(i)));
    }
    return pair;
}

TEST(Aqorb_Refinement, equals_the_plain_definition)
{
    int compared = 0, aligned = 0, again = 0, otherwise = 0, otherDeviations = 0;
    for (int seed = 1; seed <= 80; seed++)
    {
        const MatchedViews pair = randomPair(seed);
        const float scaleFactor = seed % 3 ? 1 : 2.5f;
        const Refined all = refine(pair, -1, scaleFactor), good = refine(pair, 0.8f, scaleFactor);
        ASSERT_EQ(pair.matches.size(), all.matches.size());
        size_t next = 0;
        for (size_t i = 0; i < pair.matches.size(); i++)
        {
            const DMatch& match = pair.matches[i];
            const KeyPoint &first = pair.keypoints1[match.queryIdx],
                           &second = pair.keypoints2[match.trainIdx];
            const ReferenceAlignment once = referenceAlignment(pair.image1, first, pair.image2,
                                                               referenceStart(first, second), scaleFactor),
                                     expected = referenceRefinement(pair.image1, first, pair.image2, second,
                                                                    0.8, scaleFactor);
            const bool isKept = next < good.matches.size() && good.matches[next].distance == match.distance;
            compared++;
            ASSERT_EQ(first.pt, all.points1[i]);
            const Point2d moved = Point2d(all.points2[i]) - once.position;
            // Rounding decides on limits, and where a patch hardly has texture.
            otherwise += isKept != expected.isAligned || cv::norm(moved) > 0.01;
            aligned += isKept;
            if (!isKept)
                continue;
            again += all.points2[i] != good.points2[next];
            otherwise += cv::norm(Point2d(good.points2[next]) - expected.position) > 0.01;
            otherDeviations += std::abs(good.deviations[next] / expected.deviation - 1) > 0.01;
            next++;
        }
        ASSERT_EQ(good.matches.size(), next) << "another order";
    }
    EXPECT_GT(aligned, 400);
    EXPECT_GT(again, 50);
    EXPECT_LT(otherwise, compared / 200);
    EXPECT_LT(otherDeviations, aligned / 100);
}

TEST(Aqorb_Refinement, threads_and_images_of_any_kind_give_the_same_bytes)
{
    const MatchedViews pair = viewsOf(Texture(3), similarity(1, 5, 3.3, -4.8));
    ASSERT_GT(pair.matches.size(), 64u) << "several threads have something to do";
    const Refined expected = refine(pair);
    for (int count : {1, 2, 3, 16})
    {
        Threads threads(count);
        EXPECT_TRUE(isSame(expected, refine(pair))) << count;
    }
    MatchedViews other = pair;
    cvtColor(pair.image1, other.image1, COLOR_GRAY2BGR);
    cvtColor(pair.image2, other.image2, COLOR_GRAY2BGRA);
    EXPECT_TRUE(isSame(expected, refine(other)));
    other.image1 = atOffset(pair.image1, 3);
    other.image2 = atOffset(pair.image2, 17);
    EXPECT_TRUE(isSame(expected, refine(other)));
    Refined inPlace;
    inPlace.matches = pair.matches;
    refineMatches(pair.image1.getUMat(ACCESS_READ), pair.keypoints1, pair.image2.getUMat(ACCESS_READ),
                  pair.keypoints2, inPlace.matches, inPlace.points1, inPlace.points2, inPlace.deviations,
                  0.8f);
    EXPECT_TRUE(isSame(expected, inPlace));
}

TEST(Aqorb_Refinement, leaves_out_keypoints_that_cannot_be_aligned)
{
    const MatchedViews good = viewsOf(Texture(3), similarity(1, 5, 3.3, -4.8));
    for (const bool isFirst : {true, false})
    {
        MatchedViews pair = good;
        pair.matches.resize(40);
        KeyPoint& changed = isFirst ? pair.keypoints1[7] : pair.keypoints2[7];
        for (const KeyPoint& bad : unusable(changed))
        {
            SCOPED_TRACE(testing::Message() << isFirst << bad.pt << ", " << bad.size << ", " << bad.angle);
            changed = bad;
            EXPECT_EQ(39u, refine(pair).matches.size());
            const Refined all = refine(pair, -1);
            ASSERT_EQ(40u, all.matches.size());
            const Point2f kept = all.points2[7], given = pair.keypoints2[7].pt;
            EXPECT_TRUE(kept == given || cvIsNaN(given.x) || cvIsNaN(given.y));
        }
    }
    MatchedViews flat = good;
    flat.image1 = flat.image1 / 128;
    EXPECT_EQ(0u, refine(flat).matches.size());
    flat = good;
    flat.image2 = Scalar(77);
    EXPECT_EQ(0u, refine(flat).matches.size());
    for (const Size& size : {Size(1, 1), Size(2, 2), Size(1, 50), Size(50, 2)})
    {
        MatchedViews tiny = good;
        tiny.image1 = good.image1(Rect(Point(), size)).clone();
        EXPECT_EQ(0u, refine(tiny).matches.size());
        EXPECT_EQ(good.matches.size(), refine(tiny, -1).matches.size());
    }
}

TEST(Aqorb_Refinement, angles_say_how_far_the_patch_turns)
{
    // How many of the matches stay whose keypoints have these angles, 1000 for the true one.
    const auto kept = [](double turn, float angle1, float angle2)
    {
        MatchedViews pair = viewsOf(Texture(3), similarity(1, turn, turn > 45 ? 280 : 3.3, -4.8));
        for (KeyPoint& keypoint : pair.keypoints1)
            keypoint.angle = angle1 == 1000 ? keypoint.angle : angle1;
        for (KeyPoint& keypoint : pair.keypoints2)
            keypoint.angle = angle2 == 1000 ? keypoint.angle : angle2;
        return double(refine(pair).matches.size()) / double(pair.matches.size());
    };
    EXPECT_EQ(1, kept(90, 1000, 1000));
    for (float none : {NOT_A_NUMBER, ENDLESS, -ENDLESS})
    {
        for (float other : {1000.f, -1.f, NOT_A_NUMBER})
        {
            EXPECT_EQ(0, kept(2, none, other)) << none << " " << other;
            EXPECT_EQ(0, kept(2, other, none)) << none << " " << other;
        }
    }
    const float unknown[][2] = {{-1, 1000}, {1000, -1}, {-1, -1}};
    for (const auto& angles : unknown)
    {
        EXPECT_GT(kept(2, angles[0], angles[1]), 0.9) << "no turn is assumed";
        EXPECT_GT(kept(15, angles[0], angles[1]), 0.5);
        EXPECT_LT(kept(90, angles[0], angles[1]), 0.2);
    }
    EXPECT_EQ(1, kept(2, 352 + 720, 354 - 720)) << "whole turns do not count";
}

TEST(Aqorb_Refinement, identical_patches_correlate_by_one)
{
    MatchedViews pair = viewsOf(Texture(3), similarity(1, 0, 0, 0), 1, 0, 8);
    pair.image2 = pair.image1;
    RNG rng(7);
    for (KeyPoint& keypoint : pair.keypoints1)
        keypoint.pt += Point2f(rng.uniform(-.5f, .5f), rng.uniform(-.5f, .5f));
    pair.keypoints2 = pair.keypoints1;
    const Refined same = refine(pair, 1);
    EXPECT_EQ(pair.matches.size(), same.matches.size());
    // Rounding of grey values leaves some deviation.
    for (size_t i = 0; i < pair.matches.size(); i++)
    {
        const KeyPoint& keypoint = pair.keypoints1[i];
        const ReferenceAlignment expected =
            referenceAlignment(pair.image1, keypoint, pair.image1, referenceStart(keypoint, keypoint), 1);
        EXPECT_NEAR(expected.deviation, same.deviations[i], 0.01 * expected.deviation);
    }
}

//! Keypoints are as far from a side of an image as the header says, or a little closer.
TEST(Aqorb_Refinement, one_rule_for_four_sides)
{
    RNG rng(4);  // a texture of all sizes
    Mat scene = Mat::zeros(995, 997, CV_8UC1);
    for (int i = 1; i < 100; i *= 3)
    {
        Mat noise(995 / i + 1, 997 / i + 1, CV_8UC1), enlarged;
        rng.fill(noise, RNG::UNIFORM, 0, 60);
        resize(noise, enlarged, scene.size(), 0, 0, INTER_LINEAR);
        scene += enlarged;
    }
    for (int level = 0; level < 5; level++)
    {
        const double spacing = 1.4 * (1 << level), half = 0.5 * (1 << level);
        const float size = float(spacing * 62);
        for (int image = 0; image < 2; image++)
        {
            const double closest = (image == 0 ? 7 : 6) * spacing + half - 0.5;
            for (int side = 0; side < 4; side++)
            {
                for (int isInside = 0; isInside < 2; isInside++)
                {
                    // The other image shows more on all sides; its pyramid has the same pixels.
                    MatchedViews pair;
                    const Rect part(256, 256, 431, 447);  // 15 more than a multiple of 16
                    Mat* const images[] = {&pair.image1, &pair.image2};
                    *images[image] = scene(part);
                    *images[1 - image] = scene;
                    // The patch of image 2 moves a little where the last pixel of a level counts twice.
                    const double distance = closest + (isInside == 0 ? -0.3 : image == 0 ? 0.3 : 1.2 * half);
                    Point2d inPart(part.width * 0.47, part.height * 0.46);
                    const int length = side < 2 ? part.width : part.height;
                    (side < 2 ? inPart.x : inPart.y) = side % 2 ? length - 1 - distance : distance;
                    const KeyPoint inner(inPart, size, 10), outer(inPart + Point2d(part.tl()), size, 10);
                    pair.keypoints1.assign(1, image == 0 ? inner : outer);
                    pair.keypoints2.assign(1, image == 0 ? outer : inner);
                    pair.matches.assign(1, DMatch(0, 0, 0));
                    const bool isAligned = std::isfinite(refine(pair, -1).deviations[0]);
                    EXPECT_EQ(isInside == 1, isAligned)
                        << "level " << level << " image " << image + 1 << " side " << side;
                }
            }
        }
    }
}

TEST(Aqorb_Refinement, few_patches_of_a_large_image_give_the_same)
{
    const Matx23d map = similarity(1.1, 3, 2.5, -1.5);
    MatchedViews pair;
    pair.image1 = makeIntegerScene(Size(1001, 803), 5, 3);
    warpAffine(pair.image1, pair.image2, map, Size(1003, 801), INTER_LINEAR, BORDER_REFLECT_101);
    RNG rng(3);
    for (int i = 0; i < 600; i++)
    {
        const Point2d p{rng.uniform(0., 1000.), rng.uniform(0., 800.)};
        const float size = rng.uniform(0, 3) ? 45.f : float(rng.uniform(60., 1200.));
        pair.keypoints1.push_back(KeyPoint(p, size, 5));
        pair.keypoints2.push_back(KeyPoint(mapped(map, p), size * 1.1f, 8));
        pair.matches.push_back(DMatch(i, i, float(i)));
    }
    MatchedViews gray = pair;
    cvtColor(pair.image1, gray.image1, COLOR_BGR2GRAY);
    cvtColor(pair.image2, gray.image2, COLOR_BGR2GRAY);
    const Refined expected = refine(gray, -1);
    EXPECT_TRUE(isSame(expected, refine(pair, -1)));
    int aligned = 0;
    for (size_t i = 0; i < pair.matches.size(); i++)
    {
        for (MatchedViews views : {pair, gray})
        {
            views.matches.assign(1, pair.matches[i]);
            const Refined single = refine(views, -1);
            ASSERT_EQ(expected.points2[i], single.points2[0]) << i;
            ASSERT_EQ(expected.deviations[i], single.deviations[0]) << i;
        }
        aligned += std::isfinite(expected.deviations[i]);
    }
    EXPECT_GT(aligned, 200);
}

TEST(Aqorb_Refinement, sides_and_rows_in_memory_have_any_length)
{
    MatchedViews pair = viewsOf(Texture(3), similarity(1, 5, 3.3, -4.8));
    const Refined expected = refine(pair);
    // Rows that are far apart: most of this memory is never touched.
    const size_t step = (size_t(1) << 23) + 64;
    uchar* const memory =
        sizeof(size_t) > 4 ? static_cast<uchar*>(std::calloc(size_t(pair.image1.rows), step)) : 0;
    if (memory)
    {
        Mat apart(pair.image1.size(), CV_8UC1, memory, step);
        pair.image1.copyTo(apart);
        MatchedViews other = pair;
        other.image1 = apart;
        EXPECT_TRUE(isSame(expected, refine(other)));
        other.matches.resize(1);
        EXPECT_EQ(expected.points2[0], refine(other).points2[0]);
        std::free(memory);
    }
    pair.image2 = Mat::zeros(3, 1 << 20, CV_8UC1);
    EXPECT_NE(std::string::npos,
              messageOf([&] { refine(pair); }).find("image2 must have at most 1048575 pixels a side"));
    pair.image2 = pair.image2.colRange(1, 1 << 20);
    EXPECT_EQ(pair.matches.size(), refine(pair, -1).matches.size());
}

TEST(Aqorb_Refinement, rejects_other_arguments_and_leaves_outputs)
{
    const MatchedViews good = viewsOf(Texture(3), similarity(1, 5, 3.3, -4.8));
    const auto messageWith =
        [&](const std::function<void(MatchedViews&)>& change, float correlation = 0.8f, float factor = 1)
    {
        MatchedViews pair = good;
        change(pair);
        Refined refined;
        refined.matches = pair.matches;
        refined.points1.resize(3);
        const std::string message = messageOf(
            [&]
            {
                refineMatches(pair.image1, pair.keypoints1, pair.image2, pair.keypoints2, refined.matches,
                              refined.points1, refined.points2, refined.deviations, correlation, factor);
            });
        EXPECT_EQ(pair.matches.size(), refined.matches.size());
        EXPECT_EQ(3u, refined.points1.size());
        return message;
    };
    const auto nothing = [](MatchedViews&) {};
    EXPECT_TRUE(names(messageWith(nothing, 1.1f), "minCorrelation", "1.1"));
    EXPECT_TRUE(names(messageWith(nothing, NOT_A_NUMBER), "minCorrelation", "nan"));
    EXPECT_TRUE(names(messageWith(nothing, 0.8f, 0), "scaleFactor", "0"));
    EXPECT_TRUE(names(messageWith(nothing, 0.8f, ENDLESS), "scaleFactor", "inf"));
    EXPECT_TRUE(
        names(messageWith([](MatchedViews& p) { p.matches[4].queryIdx = 9999; }), "matches[4]", "9999"));
    EXPECT_TRUE(names(messageWith([](MatchedViews& p) { p.matches[4].trainIdx = -1; }), "matches[4]", "-1"));
    EXPECT_TRUE(names(messageWith([](MatchedViews& p) { p.image2 = Mat1f(9, 9); }), "image2", "CV_32FC1"));
    const std::string noPixels = " must have pixels, as there are matches";
    EXPECT_EQ("image1" + noPixels, messageWith([](MatchedViews& p) { p.image1.release(); }));
    EXPECT_EQ("image2" + noPixels, messageWith([](MatchedViews& p) { p.image2.release(); }));

    MatchedViews none = good;
    none.matches.clear();
    none.image1.release();
    const Refined refined = refine(none);
    EXPECT_TRUE(refined.matches.empty() && refined.points1.empty() && refined.points2.empty());
}

}  // namespace
}  // namespace opencv_test
