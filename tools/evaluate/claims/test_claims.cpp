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

TEST(Aqorb_Claims, rolled_image_has_no_empty_corner)
{
    const RolledImage rolled = rollImage(cv::Mat1b(101, 101, uchar(200)), 45);
    EXPECT_EQ(0, cv::norm(rolled.image, cv::Mat1b(101, 101, uchar(200)), cv::NORM_INF));
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

TEST(Aqorb_Claims, features_that_do_not_turn_with_the_scene_match_in_the_middle_only)
{
    Grid grid("grid");
    Measurements results;
    measureRolled("drawn", randomImage(cv::Size(201, 201)), grid, 81, results);
    const std::vector<double> distinct = results.values("rolled", "grid", 81, "distinct");
    ASSERT_EQ(12u, distinct.size());
    for (const double count : distinct)
        EXPECT_EQ(1, count);
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

TEST(Aqorb_Claims, object_that_is_there_has_inliers)
{
    Grid grid("grid");
    Measurements results;
    measureFindObject(randomImage(cv::Size(201, 201)), randomImage(cv::Size(401, 301)), grid, 81, results);
    EXPECT_EQ(81, results.mean("object", "grid", 81, "matches"));
    EXPECT_EQ(81, results.mean("object", "grid", 81, "inliers"));
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

TEST(Aqorb_Claims, motion_between_frames_is_found_with_each_seed)
{
    StereoSequence sequence;
    sequence.camera = cv::Matx33d(700, 0, 320, 0, 700, 240, 0, 0, 1);
    sequence.baseline = 0.5;
    cv::Matx44d moved = cv::Matx44d::eye();
    moved(2, 3) = 1.25;  // forward
    sequence.poses = {cv::Matx44d::eye(), moved};
    StereoFrame earlier, later;
    cv::RNG random(3);
    std::vector<cv::DMatch> matches;
    for (int i = 0; i < 40; i++)
    {
        const cv::Point3d point(random.uniform(-5., 5.), random.uniform(-2., 2.), random.uniform(5., 30.));
        const double depth = point.z - 1.25;
        earlier.points.push_back(point);
        later.points.push_back(cv::Point3d(point.x, point.y, depth));
        const cv::Point2d pixel(320 + 700 * point.x / depth, 240 + 700 * point.y / depth);
        later.features.keypoints.push_back(cv::KeyPoint(cv::Point2f(pixel), 31));
        matches.push_back(cv::DMatch(i, i, 0));
    }
    for (int seed = 0; seed < 3; seed++)
    {
        const OdometryStep step = estimateMotion(sequence, earlier, 0, later, 1, matches, seed);
        ASSERT_TRUE(step.found);
        EXPECT_EQ(40, step.inliers);
        EXPECT_NEAR(0, step.metres, 1e-3);
        EXPECT_NEAR(0, step.degrees, 1e-3);
    }
    sequence.poses[1](2, 3) = 1;  // a wrong truth
    EXPECT_NEAR(0.25, estimateMotion(sequence, earlier, 0, later, 1, matches).metres, 1e-3);
}

TEST(Aqorb_Claims, statistics)
{
    EXPECT_EQ(2, mean({1, 2, 3}));
    EXPECT_EQ(1, standardDeviation({1, 2, 3}));
    EXPECT_NEAR(0.57735, standardError({1, 2, 3}), 1e-5);
    EXPECT_TRUE(std::isnan(mean({})));
    EXPECT_TRUE(std::isnan(standardError({1})));
    EXPECT_EQ(0.5, areaUnderCurve({0, 5}, 5));
    EXPECT_EQ(0.25, areaUnderCurve({2.5, 1e6}, 5));
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
    const std::vector<Claim> good = claimsOf(139), bad = claimsOf(137);
    ASSERT_EQ(2u, good.size());  // what was not measured is left out
    EXPECT_EQ("1.390", good[0].here);
    EXPECT_EQ("1.200", good[0].paper);
    EXPECT_EQ("at least 1.380", good[0].asked);
    EXPECT_EQ(Claim::HOLDS, good[0].verdict);
    EXPECT_EQ(Claim::NONE, good[1].verdict);  // graf at n = 500
    EXPECT_EQ(Claim::FAILS, bad[0].verdict);
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

TEST(Aqorb_Claims, slam_has_the_settings)
{
    EXPECT_EQ("slam", slamOf("aqorb"));
    EXPECT_EQ("slam:selection=balanced", slamOf("aqorb:selection=balanced"));
    EXPECT_EQ("", slamOf("orb"));
    EXPECT_EQ("", slamOf("aqorbit"));
}

}  // namespace
