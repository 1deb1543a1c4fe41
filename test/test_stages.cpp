// This file is part of the aqorb project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.

#include "plain_reference.hpp"

namespace opencv_test
{
namespace
{

using namespace aqorb::stages;

// Runs a check with the kernels of this CPU and with those of the baseline.
template <typename Check> void onEveryPath(Check check)
{
    check();
    setUseOptimized(false);
    {
        SCOPED_TRACE("baseline kernels");
        check();
    }
    setUseOptimized(true);
}

std::vector<Mat> images(Size size)
{
    std::vector<Mat> result;
    result.push_back(makeNoise(size, size.width));
    result.push_back(makeScene(size, size.width));
    Mat extreme = makeNoise(size, size.width + 1);
    threshold(extreme, extreme, 127, 255, THRESH_BINARY);
    result.push_back(extreme);
    result.push_back(Mat(size, CV_8UC1, Scalar(255)));
    return result;
}

// ---- fast

std::vector<KeyPoint> openCVCorners(const Mat& image, const Rect& region, int threshold)
{
    std::vector<KeyPoint> all, inside;
    FAST(image, all, threshold, true);
    for (const KeyPoint& k : all)
    {
        if (region.contains(Point(k.pt)))
            inside.push_back(k);
    }
    return inside;
}

void expectOpenCVCorners(const Mat& image, const Rect& region, int threshold)
{
    const std::vector<KeyPoint> expected = openCVCorners(image, region, threshold);
    std::vector<Corner> corners;
    detectCorners(image, region, threshold, corners);
    ASSERT_EQ(expected.size(), corners.size());
    for (size_t i = 0; i < corners.size(); i++)
    {
        ASSERT_EQ(Point(expected[i].pt), Point(corners[i].x, corners[i].y));
        ASSERT_EQ(expected[i].response, (float)corners[i].score);
    }
}

TEST(AQORB_Fast, equals_OpenCV_for_every_width)
{
    const int thresholds[] = {1, 7, 20, 100, 254};
    for (int width = 1; width <= 130; width++)
    {
        SCOPED_TRACE(width);
        for (const Mat& image : images(Size(width, 24)))
        {
            for (int threshold : thresholds)
                onEveryPath([&] { expectOpenCVCorners(image, Rect(Point(), image.size()), threshold); });
        }
    }
}

TEST(AQORB_Fast, equals_OpenCV_in_every_region)
{
    const Mat large = makeScene(Size(200, 90), 9);
    const Mat image = large(Rect(11, 5, 170, 80));  // not continuous, odd alignment
    RNG rng(3);
    for (int i = 0; i < 200; i++)
    {
        const Rect region(rng.uniform(-5, 170), rng.uniform(-5, 80), rng.uniform(1, 100), rng.uniform(1, 60));
        SCOPED_TRACE(format("%d %d %d %d", region.x, region.y, region.width, region.height));
        onEveryPath([&] { expectOpenCVCorners(image, region, rng.uniform(1, 60)); });
    }
}

TEST(AQORB_Fast, scores_by_definition)
{
    for (const Mat& image : images(Size(40, 30)))
    {
        onEveryPath(
            [&]
            {
                for (int y = 0; y < image.rows; y++)
                {
                    for (int x = 0; x < image.cols; x++)
                    {
                        int scores[3][3];
                        cornerScores3x3(image, x, y, scores);
                        for (int i = 0; i < 9; i++)
                            ASSERT_EQ(referenceScore(image, Point(x + i % 3 - 1, y + i / 3 - 1)),
                                      scores[i / 3][i % 3]);
                    }
                }
            });
    }
}

// ---- pyramid

TEST(AQORB_Pyramid, resize_equals_OpenCV_for_every_width)
{
    for (int width = 1; width <= 130; width++)
    {
        const Mat image = makeNoise(Size(width, 37), width);
        const double scales[] = {1.05, 1.2, 1.5, 1.8, 1.95, 2, 2.5, 3.7, 0.7, 0.3, 1};
        for (double scale : scales)
        {
            const Size size(cvRound(width / scale), cvRound(image.rows / scale));
            if (size.width < 1)
                continue;
            SCOPED_TRACE(format("%d to %d", width, size.width));
            Mat expected;
            resize(image, expected, size, 0, 0, INTER_LINEAR_EXACT);
            onEveryPath(
                [&]
                {
                    Mat resized;
                    resizeExact(image, resized, size);
                    ASSERT_TRUE(sameMat(expected, resized));
                });
        }
    }
}

TEST(AQORB_Pyramid, levels_as_in_ORB)
{
    // of the input up to the one after firstLevel, then of the previous one
    const Mat image = makeScene(Size(120, 100));
    std::vector<Level> levels;
    buildPyramid(image, Mat(), 5, 2, 1.3, 1, levels);
    ASSERT_EQ(5u, levels.size());
    EXPECT_EQ(image.data, levels[2].image.data);
    for (int i = 0; i < 5; i++)
    {
        if (i == 2)
            continue;
        Mat expected;
        resize(i <= 3 ? image : levels[i - 1].image, expected, levels[i].image.size(), 0, 0,
               INTER_LINEAR_EXACT);
        EXPECT_TRUE(sameMat(expected, levels[i].image));
        EXPECT_EQ((float)std::pow(1.3, i - 2), levels[i].scale);
        EXPECT_EQ(cvRound(120 * (1.f / levels[i].scale)), levels[i].image.cols);
    }
}

TEST(AQORB_Pyramid, quotas_of_the_papers_example)
{
    // 500 features: 108.6 for the first layer, 30.3 for the eighth
    const std::vector<int> quotas = levelQuotas(500, 1.2f, 8);
    EXPECT_EQ(109, quotas[0]);
    EXPECT_EQ(31, quotas[7]);  // what rounding left over
    EXPECT_EQ(4, quadtreeDepth(quotas[0]));
    EXPECT_EQ(3, quadtreeDepth(quotas[7]));
}

TEST(AQORB_Pyramid, quotas_add_up)
{
    for (int n = 0; n <= 300; n++)
    {
        for (int levels = 1; levels <= 12; levels++)
        {
            const std::vector<int> quotas = levelQuotas(n, 1.2f, levels);
            int sum = 0;
            for (int quota : quotas)
            {
                EXPECT_GE(quota, 0);
                sum += quota;
            }
            EXPECT_EQ(n, sum);
        }
    }
    EXPECT_EQ(std::vector<int>(1, 77), levelQuotas(77, 1.0, 1));
}

// ---- blur

TEST(AQORB_Blur, stays_within_its_bound_for_every_width)
{
    for (int width = 1; width <= 130; width++)
    {
        SCOPED_TRACE(width);
        for (const Mat& image : images(Size(width, 11)))
        {
            onEveryPath(
                [&]
                {
                    Mat blurred;
                    approximateBlur(image, blurred);
                    for (int y = 0; y < image.rows; y++)
                    {
                        for (int x = 0; x < image.cols; x++)
                        {
                            const float exact = referenceBlur(image, Point(x, y));
                            ASSERT_LE(std::abs(blurred.at<ushort>(y, x) - 256 * exact), BLUR_BOUND);
                            ASSERT_EQ(saturate_cast<uchar>(exact), exactBlur(image, x, y));
                        }
                    }
                });
        }
    }
}

TEST(AQORB_Blur, bound_holds_for_the_worst_pixels)
{
    // For each sign of every product's error, patches that bring it to the largest.
    RNG rng(7);
    float worst = 0;
    for (int i = 0; i < 3000; i++)
    {
        Mat image(9, 40, CV_8UC1);
        rng.fill(image, RNG::UNIFORM, i % 3 == 0 ? 250 : 0, i % 3 == 1 ? 6 : 256);
        Mat blurred;
        approximateBlur(image, blurred);
        for (int x = 0; x < image.cols; x++)
            worst =
                std::max(worst, std::abs(blurred.at<ushort>(4, x) - 256 * referenceBlur(image, Point(x, 4))));
    }
    EXPECT_LE(worst, (float)BLUR_BOUND);
    EXPECT_GT(worst, 0.5f);  // the comparison sees something
}

// ---- harris, orientation

TEST(AQORB_Harris, batch_equals_single_responses)
{
    for (const Mat& image : images(Size(50, 40)))
    {
        std::vector<Corner> corners;
        for (int y = 0; y < image.rows; y++)
        {
            for (int x = 0; x < image.cols; x++)
            {
                const Corner corner = {x, y, 1};
                corners.push_back(corner);
            }
        }
        onEveryPath(
            [&]
            {
                std::vector<RankedCorner> ranked;
                harrisResponses(image, corners, ranked);
                ASSERT_EQ(corners.size(), ranked.size());
                for (size_t i = 0; i < corners.size(); i++)
                {
                    ASSERT_EQ(corners[i].x, ranked[i].x);
                    ASSERT_EQ(referenceHarris(image, corners[i].x, corners[i].y), ranked[i].response);
                    ASSERT_EQ(ranked[i].response, harrisResponse(image, corners[i].x, corners[i].y));
                }
            });
    }
}

TEST(AQORB_Harris, prefers_a_corner_to_an_edge)
{
    Mat image = Mat::zeros(40, 40, CV_8UC1);
    image(Rect(20, 20, 20, 20)).setTo(200);
    EXPECT_GT(harrisResponse(image, 20, 20), 0);
    EXPECT_LT(harrisResponse(image, 20, 32), 0);
    EXPECT_EQ(0, harrisResponse(image, 8, 8));
}

TEST(AQORB_Orientation, batch_equals_single_directions)
{
    const Mat image = makeScene(Size(150, 140), 2);
    const int patches[] = {2, 3, 5, 15, 31, 32, 47, 63, 64, 101};
    for (int patchSize : patches)
    {
        SCOPED_TRACE(patchSize);
        const std::vector<int> patch = circularPatch(patchSize);
        std::vector<DescriptorPoint> points;
        for (int y = 0; y < image.rows; y += 5)
        {
            for (int x = 0; x < image.cols; x += 3)
            {
                const DescriptorPoint point = {x, y, -1};
                points.push_back(point);
            }
        }
        onEveryPath(
            [&]
            {
                orientations(image, patch, points.data(), points.size());
                for (const DescriptorPoint& point : points)
                {
                    ASSERT_EQ(referenceAngle(image, point.x, point.y, patchSize), point.angle);
                    ASSERT_EQ(point.angle, orientation(image, point.x, point.y, patch));
                }
            });
    }
}

TEST(AQORB_Orientation, points_to_the_bright_side)
{
    for (int degrees = 0; degrees < 360; degrees += 15)
    {
        Mat image(41, 41, CV_8UC1);
        const double dx = std::cos(degrees * CV_PI / 180), dy = std::sin(degrees * CV_PI / 180);
        for (int y = 0; y < image.rows; y++)
            for (int x = 0; x < image.cols; x++)
                image.at<uchar>(y, x) = saturate_cast<uchar>(128 + 4 * ((x - 20) * dx + (y - 20) * dy));
        const float angle = orientation(image, 20, 20, circularPatch(31));
        EXPECT_NEAR(0, std::remainder(angle - degrees, 360.), 1.) << degrees;
    }
}

}  // namespace
}  // namespace opencv_test
