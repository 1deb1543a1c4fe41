// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "reference.hpp"

#include "detector/threshold.hpp"

namespace opencv_test
{
namespace
{

using namespace aqorb;

// The contrast, which does not depend on the number of threads.
static double contrastOf(const Mat& image, const Mat& mask)
{
    const double contrast = varianceOverMean(image, mask, 1);
    EXPECT_EQ(varianceOverMean(image, mask, 3), contrast);
    return contrast;
}

TEST(Aqorb_Threshold, equation7_of_known_images)
{
    // Half 0, half 200: mean 100, variance 100^2.
    Mat image(10, 10, CV_8UC1, Scalar(0));
    image.colRange(0, 5).setTo(200);
    EXPECT_DOUBLE_EQ(contrastOf(image, Mat()), 100.);
    EXPECT_DOUBLE_EQ(aqorb::adaptiveFastThreshold(image), 100.);
    // 10, 20, 30: mean 20, variance 200/3.
    const Mat three = Mat_<uchar>({1, 3}, {10, 20, 30});
    EXPECT_NEAR(contrastOf(three, Mat()), 10. / 3, 1e-12);
    // The mask leaves 10 and 30: mean 20, variance 100.
    EXPECT_DOUBLE_EQ(contrastOf(three, Mat_<uchar>({1, 3}, {1, 0, 255})), 5.);
}

TEST(Aqorb_Threshold, equation7_is_zero_without_contrast)
{
    EXPECT_EQ(contrastOf(Mat(7, 9, CV_8UC1, Scalar(0)), Mat()), 0);
    EXPECT_NEAR(contrastOf(Mat(7, 9, CV_8UC1, Scalar(255)), Mat()), 0, 1e-12);
    const Mat noise = makeNoise(Size(9, 7));
    EXPECT_EQ(contrastOf(noise, Mat(noise.size(), CV_8UC1, Scalar(0))), 0);
    EXPECT_EQ(aqorb::adaptiveFastThreshold(Mat()), 0);
}

TEST(Aqorb_Threshold, equation7_equals_reference_for_every_width)
{
    for (int width = 1; width <= MAX_WIDTH; width++)
    {
        SCOPED_TRACE(width);
        const Mat noise = makeNoise(Size(width, 11), width);
        const Mat mask = makeNoise(noise.size(), width + 1) > 128;
        EXPECT_EQ(contrastOf(noise, Mat()), reference::varianceOverMean(noise, Mat()));
        EXPECT_EQ(contrastOf(noise, mask), reference::varianceOverMean(noise, mask));
        const Mat part = noise.colRange(width / 3, width);  // Its rows are not contiguous.
        EXPECT_EQ(contrastOf(part, Mat()), reference::varianceOverMean(part, Mat()));
        WithoutOptimization baseline;
        EXPECT_EQ(contrastOf(noise, Mat()), reference::varianceOverMean(noise, Mat()));
    }
}

TEST(Aqorb_Threshold, equation7_does_not_overflow)
{
    // More than 2^32 in the sum of squares, and rows longer than any block of the kernel.
    const Mat wide(2, 1 << 19, CV_8UC1, Scalar(255)), tall(1 << 12, 100, CV_8UC1, Scalar(255));
    EXPECT_EQ(contrastOf(wide, Mat()), reference::varianceOverMean(wide, Mat()));
    EXPECT_EQ(contrastOf(tall, Mat()), reference::varianceOverMean(tall, Mat()));
    Mat noise = makeNoise(Size(70001, 3));
    noise.row(1).setTo(255);
    EXPECT_EQ(contrastOf(noise, Mat()), reference::varianceOverMean(noise, Mat()));
    WithoutOptimization baseline;
    EXPECT_EQ(contrastOf(wide, Mat()), reference::varianceOverMean(wide, Mat()));
}

static void expectThresholds(const Thresholds& thresholds, int ini, int min)
{
    EXPECT_EQ(thresholds.ini, ini);
    EXPECT_EQ(thresholds.min, min);
}

TEST(Aqorb_Threshold, thresholds_equal_reference)
{
    // As in the paper, iniT is equation (7), and minT is a quarter of it.
    expectThresholds(fastThresholds(40, 20, 4), 40, 10);
    const int fasts[] = {-3, 0, 1, 2, 7, 20, 100, 254, 255, 300};
    const double values[] = {0, 0.3, 1, 1.5, 2.5, 7, 14.4, 29.9, 48, 100, 253.5, 254.5, 400, 1e6};
    const double ratios[] = {1, 1.01, 2, 4, 10, 1e9};
    for (int fast : fasts)
        for (double ratio : ratios)
        {
            for (double value : values)
            {
                SCOPED_TRACE(format("fast %d ratio %g value %g", fast, ratio, value));
                const Thresholds expected = reference::thresholds(value, true, fast, ratio);
                expectThresholds(fastThresholds(value, fast, ratio), expected.ini, expected.min);
            }
            const Thresholds expected = reference::thresholds(0, false, fast, ratio);
            expectThresholds(fastThresholds(NEUTRAL_CONTRAST, fast, ratio), expected.ini, expected.min);
        }
}

}  // namespace
}  // namespace opencv_test
