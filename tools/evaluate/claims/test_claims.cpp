// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// Measures of drawn images and made-up features whose results are known.

#include "../measures.hpp"
#include "claims.hpp"
#include "subjects.hpp"

#include <gtest/gtest.h>
#include <opencv2/imgproc.hpp>

using opencv_test::Matches;

namespace
{

//! An image in which no two pixels that are near each other are alike.
cv::Mat1b randomImage(cv::Size size)
{
    cv::Mat1b image(size);
    cv::RNG(1).fill(image, cv::RNG::UNIFORM, 0, 256);
    return image;
}

//! A feature at each point of a grid, 20 pixels apart about the middle of an image, whatever the image shows.
class Grid : public Method
{
public:
    explicit Grid(const std::string& name_, cv::Point2f shift_ = cv::Point2f()) : shift(shift_)
    {
        name = name_;
    }

    Features compute(const cv::Mat& image, int) override
    {
        Features features;
        for (int i = 0; i < 81; i++)
        {
            const cv::Point2f middle(float(image.cols - 1) / 2, float(image.rows - 1) / 2);
            const cv::Point2f offset(float(20 * (i % 9 - 4)), float(20 * (i / 9 - 4)));
            features.keypoints.push_back(cv::KeyPoint(middle + offset + shift, 31));
        }
        features.descriptors.create(81, 32, CV_8U);
        cv::RNG(2).fill(features.descriptors, cv::RNG::UNIFORM, 0, 256);
        return features;
    }

private:
    const cv::Point2f shift;
};

TEST(Aqorb_Claims, rolled_image_is_the_scene_turned)
{
    const cv::Mat1b image = randomImage(cv::Size(101, 101));
    const RolledImage rolled = rollImage(image, 90);
    cv::Mat turned;
    cv::rotate(image, turned, cv::ROTATE_90_COUNTERCLOCKWISE);
    EXPECT_EQ(0, cv::norm(turned, rolled.image, cv::NORM_INF));
    std::vector<cv::Point2f> mapped;
    cv::perspectiveTransform(std::vector<cv::Point2f>{{100, 0}, {50, 50}}, mapped, rolled.homography);
    EXPECT_NEAR(0, cv::norm(mapped[0] - cv::Point2f(0, 0)), 1e-4);
    EXPECT_NEAR(0, cv::norm(mapped[1] - cv::Point2f(50, 50)), 1e-4);
}

TEST(Aqorb_Claims, matches_in_filled_corners_do_not_count)
{
    const cv::Size size(101, 101);
    const cv::Mat homography = rollImage(cv::Mat1b(size, uchar(0)), 45).homography;
    // The middle; a corner of the original, which the roll moves out; a corner that the roll filled.
    Matches matches;
    matches.from = {{50, 50}, {1, 1}, {50, 50}};
    matches.to = {{50, 50}, {50, 50}, {1, 1}};
    const Matches common = matchesInCommonPart(matches, homography, size, size);
    ASSERT_EQ(1u, common.from.size());
    EXPECT_EQ(cv::Point2f(50, 50), common.to[0]);
}

TEST(Aqorb_Claims, scaled_image_is_the_scene_scaled)
{
    const cv::Mat1b image = randomImage(cv::Size(100, 80));
    const ScaledImage scaled = scaleImage(image, 0.5);
    ASSERT_EQ(cv::Size(50, 40), scaled.image.size());
    std::vector<cv::Point2f> mapped;
    cv::perspectiveTransform(std::vector<cv::Point2f>{{0.5f, 0.5f}, {98.5f, 78.5f}}, mapped,
                             scaled.homography);
    EXPECT_NEAR(0, cv::norm(mapped[0] - cv::Point2f(0, 0)), 1e-4);
    EXPECT_NEAR(0, cv::norm(mapped[1] - cv::Point2f(49, 39)), 1e-4);
    EXPECT_NEAR(cv::mean(image(cv::Rect(0, 0, 2, 2)))[0], scaled.image.at<uchar>(0, 0), 0.5);
}

TEST(Aqorb_Claims, set_of_equal_images_has_all_matches)
{
    ImageSet set;
    set.name = "drawn";
    set.images = {randomImage(cv::Size(201, 201)), randomImage(cv::Size(201, 201))};
    set.homographies.assign(2, cv::Mat::eye(3, 3, CV_64F));
    Grid grid("grid");
    Measurements results;
    measureSet("sets", set, grid, 81, 2, results);
    EXPECT_EQ((std::vector<double>{81}), results.values("sets", "grid", 81, "distinct"));
    EXPECT_EQ((std::vector<double>{1}), results.values("sets", "grid", 81, "precision"));
    EXPECT_NEAR(1, results.mean("sets", "grid", 81, "auc5"), 1e-3);
    EXPECT_EQ(2u, results.values("sets", "grid", 81, "uniformity").size());

    // A homography that is 4 pixels off.
    set.homographies[1].at<double>(0, 2) = 4;
    measureSet("off", set, grid, 81, 2, results);
    EXPECT_EQ((std::vector<double>{0}), results.values("off", "grid", 81, "distinct"));
    EXPECT_NEAR(0.2, results.mean("off", "grid", 81, "auc5"), 1e-3);
}

TEST(Aqorb_Claims, held_out_pairs_count_by_either_matrix)
{
    ImagePair plane;
    plane.name = "plane";
    plane.first = plane.second = randomImage(cv::Size(201, 201));
    plane.homography = cv::Mat::eye(3, 3, CV_64F);
    ImagePair depth = plane;
    depth.name = "depth";
    depth.homography = cv::Mat();
    depth.fundamental = cv::Mat1d({3, 3}, {0, 0, 0, 0, 0, -1, 0, 1, 0});  // rectified: equal rows
    Grid grid("grid");
    Measurements results;
    measureHeldOut({plane, depth}, grid, 81, 1, results);
    EXPECT_EQ((std::vector<double>{81, 81}), results.values("held-out", "grid", 81, "distinct"));
    EXPECT_EQ(1u, results.values("held-out", "grid", 81, "auc5").size());
}

TEST(Aqorb_Claims, epipolar_lines_tell_the_row_and_nothing_else)
{
    const cv::Mat rectified = cv::Mat1d({3, 3}, {0, 0, 0, 0, 0, -1, 0, 1, 0});
    Matches matches;
    matches.from = {{10, 10}, {10, 20}, {10, 30}};
    matches.to = {{90, 10}, {10, 23.5f}, {5, 32.5f}};
    EXPECT_EQ((std::vector<size_t>{0, 2}), opencv_test::matchesOnEpipolarLines(matches, rectified));
}

TEST(Aqorb_Claims, shrunk_images_have_their_own_homographies)
{
    ImageSet set;
    set.name = "drawn";
    set.images = {randomImage(cv::Size(200, 100)), randomImage(cv::Size(200, 100))};
    set.homographies.assign(2, cv::Mat());
    for (cv::Mat& homography : set.homographies)
        homography = cv::Mat::eye(3, 3, CV_64F);
    const ImageSet shrunk = degrade(set, "shrunk");
    EXPECT_EQ(cv::Size(200, 100), shrunk.images[0].size());
    EXPECT_EQ(cv::Size(140, 70), shrunk.images[1].size());
    std::vector<cv::Point2f> mapped;
    cv::perspectiveTransform(std::vector<cv::Point2f>{{-0.5f, -0.5f}, {199.5f, 99.5f}}, mapped,
                             shrunk.homographies[1]);
    EXPECT_NEAR(0, cv::norm(mapped[0] - cv::Point2f(-0.5f, -0.5f)), 1e-4);
    EXPECT_NEAR(0, cv::norm(mapped[1] - cv::Point2f(139.5f, 69.5f)), 1e-4);
    EXPECT_EQ(0, cv::norm(set.homographies[1], cv::Mat::eye(3, 3, CV_64F), cv::NORM_INF));
}

//! What the method new has of distinct matches where cv::ORB has 100, at n = 500.
std::vector<Claim> claimsOf(double distinct)
{
    Measurements measured;
    measured.add({"sets", "graf/1-2", "orb", 500, "distinct", 100});
    measured.add({"sets", "graf/1-2", "old", 500, "distinct", 120});
    measured.add({"sets", "graf/1-2", "new", 500, "distinct", distinct});
    return judge(measured, {"new", "orb", "old", "slam", "dial"}, {500});
}

TEST(Aqorb_Claims, verdict_follows_the_number)
{
    const std::vector<Claim> good = claimsOf(156), bad = claimsOf(154);
    ASSERT_EQ(2u, good.size());  // what was not measured is left out
    EXPECT_EQ("1.560", good[0].here);
    EXPECT_EQ("1.200", good[0].paper);
    EXPECT_EQ("at least 1.550", good[0].asked);
    EXPECT_EQ(Claim::HOLDS, good[0].verdict);
    EXPECT_EQ(Claim::HOLDS, good[1].verdict);  // graf
    EXPECT_EQ(Claim::FAILS, bad[0].verdict);
}

TEST(Aqorb_Claims, scales_are_judged_by_orb_and_by_the_papers_selection)
{
    const auto claims = [](double paper, double distinct)
    {
        Measurements measured;
        for (const double scale : SCALES)
        {
            measured.add({subjectOfScale(scale), "drawn", "orb", 500, "distinct", 100});
            measured.add({subjectOfScale(scale), "drawn", "old", 500, "distinct", paper});
            measured.add({subjectOfScale(scale), "drawn", "new", 500, "distinct", distinct * scale});
        }
        return judge(measured, {"new", "orb", "old", "slam", "dial"}, {500});
    };
    const std::vector<Claim> found = claims(120, 131);
    ASSERT_EQ(SCALES.size() + 1, found.size());
    EXPECT_EQ(Claim::FAILS, found[3].verdict);  // 0.75
    EXPECT_EQ(Claim::HOLDS, found[4].verdict);  // 1.5
    EXPECT_EQ("1.238", found[7].here);          // the geometric mean of the scales is 0.945
    EXPECT_EQ(Claim::FAILS, found[7].verdict);
    EXPECT_EQ(Claim::HOLDS, claims(120, 160)[7].verdict);
    EXPECT_EQ(Claim::FAILS, claims(200, 131)[4].verdict);
}

TEST(Aqorb_Claims, homographies_may_be_worse_by_chance_only)
{
    const auto verdict = [](double less)
    {
        Measurements measured;
        for (int i = 0; i < 4; i++)
        {
            measured.add({"sets", "graf/1-2", "old", 500, "auc5", 0.5});
            measured.add({"sets", "graf/1-2", "new", 500, "auc5", 0.5 - less + (i % 2 ? 0.05 : -0.05)});
        }
        return judge(measured, {"new", "orb", "old", "slam", "dial"}, {500})[0].verdict;
    };
    EXPECT_EQ(Claim::HOLDS, verdict(0.05));
    EXPECT_EQ(Claim::FAILS, verdict(0.06));
}

}  // namespace
