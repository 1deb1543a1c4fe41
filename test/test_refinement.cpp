// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// The refinement of matches: against a plain definition in double precision, and on images whose truth is known.

#include "test_precomp.hpp"

#include "reference_refinement.hpp"

#include <limits>

namespace opencv_test
{
namespace
{

using aqorb::refineMatches;

const float ENDLESS = std::numeric_limits<float>::infinity(),
            NOT_A_NUMBER = std::numeric_limits<float>::quiet_NaN();

//! The arguments of refineMatches.
struct Pair
{
    Mat image1, image2;
    KeyPoints keypoints1, keypoints2;
    std::vector<DMatch> matches;
};

struct Refined
{
    std::vector<DMatch> matches;
    std::vector<Point2f> points1, points2;
};

Refined refine(const Pair& pair, float minCorrelation = 0.8f, float scaleFactor = 1)
{
    Refined refined;
    refined.matches = pair.matches;
    refineMatches(pair.image1, pair.keypoints1, pair.image2, pair.keypoints2, refined.matches,
                  refined.points1, refined.points2, minCorrelation, scaleFactor);
    return refined;
}

bool isSame(const Refined& a, const Refined& b)
{
    const auto isSameMatch = [](const DMatch& x, const DMatch& y)
    { return x.queryIdx == y.queryIdx && x.trainIdx == y.trainIdx && x.distance == y.distance; };
    return a.matches.size() == b.matches.size() && a.points1 == b.points1 && a.points2 == b.points2 &&
           std::equal(a.matches.begin(), a.matches.end(), b.matches.begin(), isSameMatch);
}

//! Waves of all directions: a texture that is known at every position.
struct Texture
{
    explicit Texture(int seed) : rng(seed)
    {
        for (int i = 0; i < WAVES; i++)
        {
            const double direction = rng.uniform(0., CV_2PI), frequency = CV_2PI / rng.uniform(6., 24.);
            waves[i] = Vec3d(frequency * std::cos(direction), frequency * std::sin(direction),
                             rng.uniform(0., CV_2PI));
        }
    }
    double at(const Point2d& p) const
    {
        double sum = 0;
        for (const Vec3d& wave : waves)
            sum += std::sin(wave[0] * p.x + wave[1] * p.y + wave[2]);
        return 128 + 40 * sum / std::sqrt(WAVES / 2.);
    }

    static const int WAVES = 20;
    RNG rng;
    Vec3d waves[WAVES];
};

//! Two views of a texture: a position p of the first one is at map * p in the second one.
Pair viewsOf(const Texture& texture, const Matx23d& map, double gain = 1, double bias = 0, double noise = 0)
{
    const Size size(320, 240);
    const Matx22d inverse = Matx22d(map(0, 0), map(0, 1), map(1, 0), map(1, 1)).inv();
    Pair pair;
    pair.image1.create(size, CV_8UC1);
    pair.image2.create(size, CV_8UC1);
    RNG rng(5);
    for (int y = 0; y < size.height; y++)
    {
        for (int x = 0; x < size.width; x++)
        {
            const Vec2d seen = inverse * Vec2d(x - map(0, 2), y - map(1, 2));
            pair.image1.at<uchar>(y, x) =
                saturate_cast<uchar>(texture.at(Point2d(x, y)) + rng.gaussian(noise));
            pair.image2.at<uchar>(y, x) =
                saturate_cast<uchar>(gain * texture.at(seen) + bias + rng.gaussian(noise));
        }
    }
    const double turn = std::atan2(map(1, 0), map(0, 0)) * 180 / CV_PI,
                 scale = std::hypot(map(0, 0), map(1, 0));
    for (int y = 40; y < size.height; y += 20)
    {
        for (int x = 40; x < size.width; x += 20)
        {
            const Point2d seen(map(0, 0) * x + map(0, 1) * y + map(0, 2),
                               map(1, 0) * x + map(1, 1) * y + map(1, 2));
            if (!Rect2d(40, 40, size.width - 80, size.height - 80).contains(seen))
                continue;
            // A detector is wrong by a pixel, some degrees and a fifth of the size.
            const Point2d found = seen + Point2d(rng.uniform(-1., 1.), rng.uniform(-1., 1.));
            const int index = int(pair.keypoints1.size());
            pair.keypoints1.push_back(KeyPoint(Point2f(float(x), float(y)), 50, 350));
            pair.keypoints2.push_back(KeyPoint(found, float(50 * scale * rng.uniform(0.85, 1.15)),
                                               float(std::fmod(710 + turn + rng.uniform(-8., 8.), 360))));
            pair.matches.push_back(DMatch(index, index, float(index)));
        }
    }
    return pair;
}

//! The errors of refined positions.
std::vector<double> errorsOf(const Refined& refined, const Matx23d& map)
{
    std::vector<double> errors;
    for (size_t i = 0; i < refined.points1.size(); i++)
    {
        const Point2f p = refined.points1[i], q = refined.points2[i];
        errors.push_back(std::hypot(map(0, 0) * p.x + map(0, 1) * p.y + map(0, 2) - q.x,
                                    map(1, 0) * p.x + map(1, 1) * p.y + map(1, 2) - q.y));
    }
    std::sort(errors.begin(), errors.end());
    return errors;
}

Matx23d similarity(double scale, double degrees, double x, double y)
{
    const double a = scale * std::cos(degrees * CV_PI / 180), b = scale * std::sin(degrees * CV_PI / 180);
    return Matx23d(a, -b, x, b, a, y);
}

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
        const Pair pair = viewsOf(Texture(3), view.map, view.gain, view.bias, view.noise);
        const std::vector<double> errors = errorsOf(refine(pair), view.map);
        ASSERT_EQ(errors.size(), pair.matches.size()) << Mat(view.map);
        EXPECT_LT(errors[errors.size() / 2], view.error) << Mat(view.map) << view.noise;
        EXPECT_LT(errors[errors.size() * 95 / 100], 3 * view.error) << Mat(view.map) << view.noise;
    }
}

//! A scene and its view by a homography, with matches of which some are wrong. Braces let every compiler draw numbers in
//! the same order.
Pair randomPair(int seed)
{
    RNG rng(seed);
    Pair pair;
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
    int compared = 0, aligned = 0, otherwise = 0;
    for (int seed = 1; seed <= 80; seed++)
    {
        const Pair pair = randomPair(seed);
        const float scaleFactor = seed % 3 ? 1 : 2.5f;
        const Refined all = refine(pair, -1, scaleFactor), good = refine(pair, 0.8f, scaleFactor);
        ASSERT_EQ(pair.matches.size(), all.matches.size());
        size_t next = 0;
        for (size_t i = 0; i < pair.matches.size(); i++)
        {
            const DMatch& match = pair.matches[i];
            const KeyPoint &first = pair.keypoints1[match.queryIdx],
                           &second = pair.keypoints2[match.trainIdx];
            const ReferenceAlignment expected =
                referenceAlignment(pair.image1, first, pair.image2, second, scaleFactor);
            const bool isKept = next < good.matches.size() && good.matches[next].distance == match.distance;
            compared++;
            ASSERT_EQ(first.pt, all.points1[i]);
            const Point2d moved = Point2d(all.points2[i]) - expected.position;
            // Rounding decides on limits, and where a patch hardly has texture.
            otherwise +=
                isKept != (expected.isAligned && expected.correlation >= 0.8) || cv::norm(moved) > 0.01;
            aligned += isKept;
            if (isKept)
            {
                ASSERT_EQ(all.points2[i], good.points2[next]);
                next++;
            }
        }
        ASSERT_EQ(good.matches.size(), next) << "another order";
    }
    EXPECT_GT(aligned, 500);
    EXPECT_LT(otherwise, compared / 100);
}

TEST(Aqorb_Refinement, improves_matches_of_a_photograph)
{
    AQORB_NEEDS_DATA();
    const Mat image = imread(oxfordImage("leuven", 1), IMREAD_GRAYSCALE);
    const Matx33d view(0.95, -0.12, 60, 0.1, 0.98, 5, 4e-5, -2e-5, 1);
    Pair pair;
    pair.image1 = image;
    warpPerspective(image, pair.image2, view, image.size(), INTER_CUBIC);
    const Ptr<AdaptiveQuadtreeORB> detector = AdaptiveQuadtreeORB::create(1000);
    const Features first = detectAndCompute(*detector, pair.image1),
                   second = detectAndCompute(*detector, pair.image2);
    pair.keypoints1 = first.keypoints;
    pair.keypoints2 = second.keypoints;
    aqorb::HammingMatcher(NORM_HAMMING, true).match(first.descriptors, second.descriptors, pair.matches);

    const auto medianOf = [&](const Refined& refined, double& wrong)
    {
        std::vector<Point2f> seen;
        perspectiveTransform(refined.points1, seen, view);
        std::vector<double> right;
        for (size_t i = 0; i < seen.size(); i++)
            if (cv::norm(seen[i] - refined.points2[i]) < 3)
                right.push_back(cv::norm(seen[i] - refined.points2[i]));
        wrong = double(seen.size() - right.size()) / seen.size();
        std::sort(right.begin(), right.end());
        return right[right.size() / 2];
    };
    Refined before;
    for (const DMatch& match : pair.matches)
    {
        before.points1.push_back(pair.keypoints1[match.queryIdx].pt);
        before.points2.push_back(pair.keypoints2[match.trainIdx].pt);
    }
    double wrongBefore, wrongAfter;
    const double errorBefore = medianOf(before, wrongBefore), errorAfter = medianOf(refine(pair), wrongAfter);
    EXPECT_LT(errorAfter, errorBefore / 5);
    EXPECT_LT(errorAfter, 0.06);
    EXPECT_LT(wrongAfter, wrongBefore / 3);
}

TEST(Aqorb_Refinement, threads_give_the_same_bytes)
{
    const Pair pair = viewsOf(Texture(3), similarity(1, 5, 3.3, -4.8));
    ASSERT_GT(pair.matches.size(), 64u) << "several threads have something to do";
    const Refined expected = refine(pair, -1);
    for (int count : {1, 2, 3, 16})
    {
        Threads threads(count);
        EXPECT_TRUE(isSame(expected, refine(pair, -1))) << count;
    }
}

TEST(Aqorb_Refinement, takes_images_as_the_detector_does)
{
    const Pair pair = viewsOf(Texture(3), similarity(1, 5, 3.3, -4.8));
    const Refined expected = refine(pair);
    Pair other = pair;
    cvtColor(pair.image1, other.image1, COLOR_GRAY2BGR);
    cvtColor(pair.image2, other.image2, COLOR_GRAY2BGRA);
    EXPECT_TRUE(isSame(expected, refine(other)));
    other.image1 = atOffset(pair.image1, 3);
    other.image2 = atOffset(pair.image2, 17);
    EXPECT_TRUE(isSame(expected, refine(other)));
    Refined inPlace;
    inPlace.matches = pair.matches;
    refineMatches(pair.image1.getUMat(ACCESS_READ), pair.keypoints1, pair.image2.getUMat(ACCESS_READ),
                  pair.keypoints2, inPlace.matches, inPlace.points1, inPlace.points2);
    EXPECT_TRUE(isSame(expected, inPlace));
}

TEST(Aqorb_Refinement, leaves_out_keypoints_that_cannot_be_aligned)
{
    const Pair good = viewsOf(Texture(3), similarity(1, 5, 3.3, -4.8));
    const auto with = [&](const std::function<void(KeyPoint&)>& change, bool inFirst)
    {
        Pair pair = good;
        pair.matches.resize(40);
        change(inFirst ? pair.keypoints1[7] : pair.keypoints2[7]);
        return pair;
    };
    for (int i = 0; i < 2; i++)
    {
        for (float value : {NOT_A_NUMBER, ENDLESS, -ENDLESS, 0.f, -1e30f, 1e30f, 1e-30f, 1e-42f})
        {
            for (int field = 0; field < 4; field++)
            {
                if (field == 3 && std::isfinite(value))
                    continue;  // any other angle is one
                const Pair pair = with(
                    [&](KeyPoint& k) {
                        (field == 0 ? k.pt.x : field == 1 ? k.pt.y : field == 2 ? k.size : k.angle) = value;
                    },
                    i == 0);
                EXPECT_EQ(39u, refine(pair).matches.size()) << i << " " << field << " " << value;
                const Refined all = refine(pair, -1);
                ASSERT_EQ(40u, all.matches.size());
                const bool isComparable = field > 1 || value == value;  // NaN is not
                EXPECT_TRUE(!isComparable || pair.keypoints2[7].pt == all.points2[7])
                    << i << " " << field << " " << value;
            }
        }
    }
    Pair flat = good;
    flat.image1 = flat.image1 / 128;
    EXPECT_EQ(0u, refine(flat).matches.size());
    flat = good;
    flat.image2 = Scalar(77);
    EXPECT_EQ(0u, refine(flat).matches.size());
    for (const Size& size : {Size(1, 1), Size(2, 2), Size(1, 50), Size(50, 2)})
    {
        Pair tiny = good;
        tiny.image1 = good.image1(Rect(Point(), size)).clone();
        EXPECT_EQ(0u, refine(tiny).matches.size());
        EXPECT_EQ(good.matches.size(), refine(tiny, -1).matches.size());
    }
}

TEST(Aqorb_Refinement, upright_keypoints_are_not_turned)
{
    Pair pair = viewsOf(Texture(3), similarity(1, 2, 3.3, -4.8));
    const size_t expected = refine(pair).matches.size();
    for (KeyPoint& keypoint : pair.keypoints1)
        keypoint.angle = -1;
    EXPECT_GE(refine(pair).matches.size(), expected * 9 / 10);
}

TEST(Aqorb_Refinement, rejects_other_arguments_and_leaves_outputs)
{
    const Pair good = viewsOf(Texture(3), similarity(1, 5, 3.3, -4.8));
    const auto messageWith =
        [&](const std::function<void(Pair&)>& change, float correlation = 0.8f, float factor = 1)
    {
        Pair pair = good;
        change(pair);
        Refined refined;
        refined.matches = pair.matches;
        refined.points1.resize(3);
        const std::string message = messageOf(
            [&]
            {
                refineMatches(pair.image1, pair.keypoints1, pair.image2, pair.keypoints2, refined.matches,
                              refined.points1, refined.points2, correlation, factor);
            });
        EXPECT_EQ(pair.matches.size(), refined.matches.size());
        EXPECT_EQ(3u, refined.points1.size());
        return message;
    };
    const auto nothing = [](Pair&) {};
    const auto names = [](const std::string& message, const char* name)
    { return message.find(name) != std::string::npos; };
    EXPECT_TRUE(names(messageWith(nothing, 1.1f), "minCorrelation must"));
    EXPECT_TRUE(names(messageWith(nothing, NOT_A_NUMBER), "minCorrelation must"));
    EXPECT_TRUE(names(messageWith(nothing, 0.8f, 0), "scaleFactor must"));
    EXPECT_TRUE(names(messageWith(nothing, 0.8f, ENDLESS), "scaleFactor must"));
    EXPECT_TRUE(names(messageWith([](Pair& p) { p.matches[4].queryIdx = 9999; }), "matches[4] must"));
    EXPECT_TRUE(names(messageWith([](Pair& p) { p.matches[4].trainIdx = -1; }), "matches[4] must"));
    EXPECT_TRUE(names(messageWith([](Pair& p) { p.image1.release(); }), "image1 must"));
    EXPECT_TRUE(names(messageWith([](Pair& p) { p.image2.release(); }), "image2 must"));
    EXPECT_TRUE(names(messageWith([](Pair& p) { p.image2.convertTo(p.image2, CV_32F); }), "image2 must"));

    Pair none = good;
    none.matches.clear();
    none.image1.release();
    const Refined refined = refine(none);
    EXPECT_TRUE(refined.matches.empty() && refined.points1.empty() && refined.points2.empty());
}

}  // namespace
}  // namespace opencv_test
