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

static void expectAsReference(const Mat& image, const Mat& mask = Mat())
{
    const double expected = reference::varianceOverMean(image, mask);
    EXPECT_EQ(expected, contrastOf(image, mask));
    WithoutOptimization baseline;
    EXPECT_EQ(expected, contrastOf(image, mask));
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
        expectAsReference(noise);
        expectAsReference(noise, mask);
        expectAsReference(noise.colRange(width / 3, width));  // Its rows are not contiguous.
    }
}

TEST(Aqorb_Threshold, equation7_does_not_overflow)
{
    // More than 2^32 in the sum of squares, and rows longer than any block of the kernel.
    expectAsReference(Mat(2, 1 << 19, CV_8UC1, Scalar(255)));
    expectAsReference(Mat(1 << 12, 100, CV_8UC1, Scalar(255)));
    Mat noise = makeNoise(Size(70001, 3));
    noise.row(1).setTo(255);
    expectAsReference(noise);
}

TEST(Aqorb_Threshold, thresholds_equal_reference)
{
    const auto both = [](const Thresholds& t) { return Vec2i(t.ini, t.min); };
    // As in the paper, iniT is equation (7), and minT is a quarter of it.
    EXPECT_EQ(Vec2i(40, 10), both(fastThresholds(40, 20, 4)));
    for (int fast : {-3, 0, 1, 2, 7, 20, 100, 254, 255, 300})
        for (double ratio : {1., 1.01, 2., 4., 10., 1e9})
            for (double value : {NEUTRAL_CONTRAST, 0., 0.3, 1., 1.5, 2.5, 7., 14.4, 29.9, 48., 100., 253.5,
                                 254.5, 400., 1e6})
            {
                const Thresholds expected =
                    reference::thresholds(value, value != NEUTRAL_CONTRAST, fast, ratio);
                EXPECT_EQ(both(expected), both(fastThresholds(value, fast, ratio)))
                    << format("fast %d ratio %g value %g", fast, ratio, value);
            }
}

}  // namespace
}  // namespace opencv_test
