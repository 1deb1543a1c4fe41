// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "reference.hpp"
#include "whole_blur.hpp"

namespace opencv_test
{
namespace
{

using namespace aqorb;

// Images that push the roundings to their limits.
std::vector<Mat> hardImages(Size size, int seed)
{
    const Mat noise = makeNoise(size, seed);
    std::vector<Mat> images;
    images.push_back(noise);
    images.push_back(noise > 127);
    images.push_back(noise > 230);
    images.push_back((noise & 1) + 254);
    images.push_back(noise & 1);
    return images;
}

void expectWithinBounds(const Mat& image, const Mat& blurred, const Mat& exact)
{
    ASSERT_EQ(blurred.type(), CV_16UC1);
    ASSERT_EQ(blurred.size(), image.size());
    for (int y = 0; y < image.rows; y++)
        for (int x = 0; x < image.cols; x++)
        {
            const double error = blurred.at<ushort>(y, x) - 256. * exact.at<float>(y, x);
            ASSERT_LE(error, BLUR_EXCESS) << x << " " << y;
            ASSERT_GE(error, -BLUR_SHORTFALL) << x << " " << y;
        }
}

TEST(Aqorb_Blur, approximation_stays_within_its_bounds_for_every_width)
{
    for (int width = 1; width <= MAX_WIDTH; width++)
    {
        const std::vector<Mat> images = hardImages(Size(width, 1 + width * 7 % 23), width);
        for (size_t i = 0; i < images.size(); i++)
        {
            SCOPED_TRACE(format("width %d, image %d", width, int(i)));
            Mat blurred, baselineBlurred;
            approximateBlur(images[i], blurred);
            expectWithinBounds(images[i], blurred, reference::blur(images[i]));
            Mat exact, exactTimes256;
            reference::roundedBlur(images[i]).convertTo(exactTimes256, CV_16U, 256);
            approximateBlur(images[i], exact, true);
            EXPECT_TRUE(sameMat(exact, exactTimes256));
            WithoutOptimization baseline;
            approximateBlur(images[i], baselineBlurred);
            EXPECT_TRUE(sameMat(withMargin(blurred), withMargin(baselineBlurred)));
            approximateBlur(images[i], exact, true);
            EXPECT_TRUE(sameMat(exact, exactTimes256));
        }
    }
}

TEST(Aqorb_Blur, of_a_region_equals_that_of_the_image)
{
    RNG rng(3);
    const int widths[] = {1, 2, 5, 6, 7, 31, 32, 33, 37, 38, 39, 64, 100, 700, 2047, 2048, 2049, 2500};
    const int height = 61, reach = 19;
    BlurRegion region;  // It is used again and again, so begin must reset it.
    std::vector<uchar> scratch;
    for (int width : widths)
    {
        const Mat image = makeNoise(Size(width, height), width);
        Mat whole;
        approximateBlur(image, whole);
        for (int count = 0; count < 7; count++)
        {
            // The last ones do not reach the border where the image is wide enough.
            const int off = count > 4 ? std::min(reach + 3, (width - 1) / 2) : 0;
            std::vector<Point> centers;
            const int margin = count % 2 ? BLUR_MARGIN : blurMargin(reach);
            region.reset(image.size(), margin);
            for (int i = 0; i < count; i++)
            {
                centers.push_back(Point(rng.uniform(off, width - off), rng.uniform(off, height - off)));
                region.addDisc(centers.back(), std::vector<int>(reach + 1, reach));
            }
            const Mat blurred = blurredOf(image.size(), 65535);
            // in two parts
            const int middle = rng.uniform(-margin, height + margin);
            approximateBlur(image, region, Range(-margin, middle), rowsOf(blurred), scratch);
            approximateBlur(image, region, Range(middle, height + margin), rowsOf(blurred), scratch);
            for (const Point& center : centers)
            {
                const Rect read(center.x - reach + BLUR_MARGIN, center.y - reach + BLUR_MARGIN, 2 * reach + 1,
                                2 * reach + 1);
                EXPECT_TRUE(sameMat(withMargin(blurred)(read), withMargin(whole)(read))) << width;
            }
            const int outside = BLUR_MARGIN - margin;
            Mat around = withMargin(blurred).clone();
            around(Rect(outside, outside, width + 2 * margin, height + 2 * margin)).setTo(65535);
            EXPECT_EQ(0, countNonZero(around != 65535)) << "width " << width << ": beyond the margin";
            if (count == 0)
            {
                EXPECT_EQ(0, countNonZero(withMargin(blurred) != 65535)) << "nothing was asked for";
            }
        }
    }
}

TEST(Aqorb_Blur, does_not_blur_reflected_pixels)
{
    for (int width : {1, 2, 3, 20, 200})
    {
        const Mat image = makeNoise(Size(width, 30), width);
        Mat blurred, expected;
        approximateBlur(image, blurred);
        cv::copyMakeBorder(image, expected, BLUR_MARGIN, BLUR_MARGIN, BLUR_MARGIN, BLUR_MARGIN,
                           BORDER_REFLECT_101);
        expected.convertTo(expected, CV_16U, 256);
        blurred.copyTo(expected(Rect(Point(BLUR_MARGIN, BLUR_MARGIN), image.size())));
        EXPECT_TRUE(sameMat(withMargin(blurred), expected));
    }
}

TEST(Aqorb_Blur, approximation_stays_within_its_bounds_on_the_worst_patches)
{
    // Around a single bright pixel every product of a tap is rounded alone.
    for (int i = 0; i < 49; i++)
        for (int grey = 1; grey <= 255; grey += 2)
        {
            Mat image = Mat::zeros(13, 40, CV_8UC1);
            image.at<uchar>(3 + i / 7, 17 + i % 7) = uchar(grey);
            Mat blurred;
            approximateBlur(image, blurred);
            expectWithinBounds(image, blurred, reference::blur(image));
        }
}

TEST(Aqorb_Blur, exact_blur_equals_fused_multiply_add)
{
    const Size sizes[] = {Size(131, 60), Size(30, 17), Size(7, 7), Size(5, 3), Size(2, 1), Size(1, 1)};
    for (const Size& size : sizes)
    {
        const std::vector<Mat> images = hardImages(size, 3);
        for (size_t i = 0; i < images.size(); i++)
        {
            SCOPED_TRACE(format("%d x %d, image %d", size.width, size.height, int(i)));
            const Mat expected = reference::roundedBlur(images[i]);
            for (int y = 0; y < size.height; y++)
                for (int x = 0; x < size.width; x++)
                {
                    ASSERT_EQ(exactBlur(images[i], x, y), expected.at<uchar>(y, x)) << x << " " << y;
                    WithoutOptimization baseline;
                    ASSERT_EQ(exactBlur(images[i], x, y), expected.at<uchar>(y, x)) << x << " " << y;
                }
        }
    }
}

TEST(Aqorb_Blur, is_opencv_gaussian_within_a_rounding)
{
    const Mat scene = makeScene(Size(150, 110));
    Mat expected;
    GaussianBlur(scene, expected, Size(7, 7), 2, 2, BORDER_REFLECT_101);
    EXPECT_LE(cv::norm(reference::roundedBlur(scene), expected, NORM_INF), 1);
}

}  // namespace
}  // namespace opencv_test
