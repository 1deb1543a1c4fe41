// This file is part of the aqorb project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.

#include "test_precomp.hpp"

#include <limits>

namespace opencv_test
{
namespace
{

using namespace aqorb::stages;

KeyPoints at(const std::vector<Point2f>& points)
{
    KeyPoints keypoints;
    for (const Point2f& point : points)
        keypoints.push_back(KeyPoint(point, 1));
    return keypoints;
}

TEST(AQORB_Uniformity, counts_by_hand)
{
    // 100 x 100: (10, 50) is left, top (y <= H/2), below neither diagonal but the main one's upper side
    // not (50*100 - 10*100 > 0), above the other one, and outside the centre (|10-50| > 35.4).
    // Counts of the first halves for four such points: 4, 4, 0, 4, 0; all are 2 off the mean.
    const KeyPoints cluster = at(std::vector<Point2f>(4, Point2f(10, 50)));
    EXPECT_NEAR(101 * std::log10(2.), aqorb::distributionUniformity(cluster, Size(100, 100)), 1e-9);

    // First halves: left (10,50) (50,10) (50,90) (45,45), that is 4 of 6; top all but (50,90): 5; above
    // the main diagonal (90,50) (50,10) (55,50): 3; above the other (10,50) (50,10) (45,45): 3; centre
    // (45,45) (55,50): 2. Deviations from 3: 1, 2, 0, 0, -1, so sigma = sqrt(2 * 6 / 10).
    std::vector<Point2f> points;
    points.push_back(Point2f(10, 50));
    points.push_back(Point2f(90, 50));
    points.push_back(Point2f(50, 10));
    points.push_back(Point2f(50, 90));
    points.push_back(Point2f(45, 45));
    points.push_back(Point2f(55, 50));
    EXPECT_NEAR(101 * std::log10(std::sqrt(1.2)), aqorb::distributionUniformity(at(points), Size(100, 100)),
                1e-9);
    const KeyPoints one = at(std::vector<Point2f>(1, Point2f(10, 50)));
    EXPECT_EQ(0, aqorb::distributionUniformity(one, Size(100, 100)));  // sigma is 1/2: below 1
}

TEST(AQORB_Uniformity, limits_of_the_scale)
{
    // All of 500 points in a corner: every count is 250 off but that of the diagonal through the corner.
    EXPECT_NEAR(101 * std::log10(250.),
                aqorb::distributionUniformity(at(std::vector<Point2f>(500, Point2f(2, 1))), Size(1000, 700)),
                1e-9);
    EXPECT_EQ(0, aqorb::distributionUniformity(KeyPoints(), Size(10, 10)));
    const float nan = std::numeric_limits<float>::quiet_NaN(), inf = std::numeric_limits<float>::infinity();
    std::vector<Point2f> points(4, Point2f(10, 50));
    points.push_back(Point2f(nan, 1));
    points.push_back(Point2f(1, inf));
    EXPECT_NEAR(101 * std::log10(2.), aqorb::distributionUniformity(at(points), Size(100, 100)), 1e-9);
}

TEST(AQORB_Uniformity, occupancy)
{
    std::vector<Point2f> points;
    points.push_back(Point2f(0, 0));
    points.push_back(Point2f(24.9f, 1));
    points.push_back(Point2f(25, 1));
    points.push_back(Point2f(99.9f, 59.9f));
    points.push_back(Point2f(100, 59));
    points.push_back(Point2f(-0.01f, 5));
    EXPECT_DOUBLE_EQ(3 / 12., aqorb::distributionOccupancy(at(points), Size(100, 60), Size(4, 3)));
    EXPECT_DOUBLE_EQ(1, aqorb::distributionOccupancy(at(points), Size(100, 60), Size(1, 1)));
    EXPECT_DOUBLE_EQ(0, aqorb::distributionOccupancy(KeyPoints(), Size(100, 60)));
}

void expectPaper(const std::string& set, const std::vector<double>& paper)
{
    for (size_t i = 0; i < paper.size(); i++)
    {
        const Mat image = imread(oxfordImage(set, (int)i + 1));  // in colour; the detector converts
        ASSERT_FALSE(image.empty());
        KeyPoints keypoints;
        ORB::create(500)->detect(image, keypoints);
        EXPECT_NEAR(paper[i], aqorb::distributionUniformity(keypoints, image.size()), 0.3)
            << set << " img" << i + 1;
    }
}

TEST(AQORB_Uniformity, column_A_of_the_papers_table_1)
{
    AQORB_NEEDS_DATA();
    const double bikes[] = {210.06, 201.62, 209.01, 209.61};
    expectPaper("bikes", std::vector<double>(bikes, bikes + 4));
}

TEST(AQORB_Uniformity, column_A_of_the_papers_table_2)
{
    AQORB_NEEDS_DATA();
    const double leuven[] = {203.30, 214.93, 217.05, 216.57, 215.70, 216.82};
    expectPaper("leuven", std::vector<double>(leuven, leuven + 6));
}

TEST(AQORB_Threshold, equation_7_by_hand)
{
    Mat image(10, 20, CV_8UC1, Scalar(50));
    image.colRange(0, 10).setTo(150);  // mean 100, variance 2500
    EXPECT_DOUBLE_EQ(25, aqorb::adaptiveFastThreshold(image));
    Mat mask = Mat::zeros(image.size(), CV_8UC1);
    mask.colRange(8, 12).setTo(1);
    EXPECT_DOUBLE_EQ(25, aqorb::adaptiveFastThreshold(image, mask));
    mask.colRange(10, 20).setTo(0);
    EXPECT_DOUBLE_EQ(0, aqorb::adaptiveFastThreshold(image, mask));  // flat
    EXPECT_DOUBLE_EQ(0, aqorb::adaptiveFastThreshold(image, Mat::zeros(image.size(), CV_8UC1)));
    EXPECT_DOUBLE_EQ(0, aqorb::adaptiveFastThreshold(Mat::zeros(5, 5, CV_8UC1)));
    EXPECT_DOUBLE_EQ(0, aqorb::adaptiveFastThreshold(Mat()));
    Mat color;
    cvtColor(image, color, COLOR_GRAY2BGR);
    EXPECT_DOUBLE_EQ(25, aqorb::adaptiveFastThreshold(color));
}

TEST(AQORB_Threshold, equation_7_for_every_width)
{
    for (int width = 1; width <= 130; width++)
    {
        const Mat image = makeNoise(Size(width, 7), width);
        Scalar mean, deviation;
        meanStdDev(image, mean, deviation);
        const double expected = mean[0] == 0 ? 0 : deviation[0] * deviation[0] / mean[0];
        EXPECT_NEAR(expected, varianceOverMean(image, Mat()), 1e-9 * (1 + expected));
        EXPECT_EQ(varianceOverMean(image, Mat(image.size(), CV_8UC1, Scalar(3))),
                  varianceOverMean(image, Mat()));
    }
    EXPECT_EQ(0, varianceOverMean(Mat(3, 2000000 / 3, CV_8UC1, Scalar(255)), Mat()));  // no overflow
}

TEST(AQORB_Threshold, limits)
{
    EXPECT_EQ(23, adaptiveThresholds(23.4, 20, 4).ini);
    EXPECT_EQ(6, adaptiveThresholds(23.4, 20, 4).min);
    EXPECT_EQ(12, adaptiveThresholds(23.4, 10, 4).ini);  // scaled by fastThreshold
    EXPECT_EQ(1, adaptiveThresholds(0, 20, 4).ini);
    EXPECT_EQ(1, adaptiveThresholds(0, 20, 4).min);
    EXPECT_EQ(254, adaptiveThresholds(700, 20, 4).ini);
    EXPECT_EQ(20, adaptiveThresholds(700, 20, 4).min);  // never stricter than cv::ORB
    EXPECT_EQ(20, fixedThresholds(20, 1).min);
    EXPECT_EQ(5, fixedThresholds(20, 4).min);
    EXPECT_EQ(254, fixedThresholds(1000, 1).min);
    EXPECT_EQ(1, fixedThresholds(-5, 4).ini);
}

}  // namespace
}  // namespace opencv_test
