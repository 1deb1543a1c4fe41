// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "reference.hpp"

#include "common/angles.hpp"
#include "detector/blur.hpp"
#include "detector/descriptor.hpp"

#include <cfloat>

namespace opencv_test
{
namespace
{

using namespace aqorb;

const int BLUR_MARGIN = 61;  // wide enough for the patches of the tests, and a blurMargin

//! The rows of a matrix of type CV_16UC1, which is a part of a larger one that has the margin, too.
aqorb::BlurredRows rowsOf(const Mat& blurred)
{
    return {const_cast<ushort*>(blurred.ptr<ushort>()), ptrdiff_t(blurred.step1()), 0};
}

//! The matrix with the margin around it.
Mat withMargin(Mat blurred)
{
    const int margin = BLUR_MARGIN;
    return blurred.adjustROI(margin, margin, margin, margin);
}

//! A matrix with a margin around it.
Mat blurredOf(Size size, int value = 0)
{
    const int margin = BLUR_MARGIN;
    const Mat all(size + Size(2 * margin, 2 * margin), CV_16UC1, Scalar(value));
    return all(Rect(Point(margin, margin), size));
}

//! The approximate blur of a whole image, of which the module blurs parts only, and of the margin around it.
Mat approximateBlur(const Mat& image, bool isExact = false)
{
    const int margin = BLUR_MARGIN;
    aqorb::BlurRegion everywhere;
    everywhere.reset(image.size(), BLUR_MARGIN);
    everywhere.addDisc(Point(), std::vector<int>(image.cols + BLUR_MARGIN + 1, image.rows + BLUR_MARGIN));
    const Mat blurred = blurredOf(image.size());
    std::vector<uchar> scratch;
    aqorb::approximateBlur(image, everywhere, Range(-margin, image.rows + margin), rowsOf(blurred), scratch,
                           isExact);
    return blurred;
}

// Images that push the roundings to their limits.
std::vector<Mat> hardImages(Size size, int seed)
{
    const Mat noise = makeNoise(size, seed);
    return {noise, noise > 127, noise > 230, (noise & 1) + 254, noise & 1};
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

TEST(Aqorb_Descriptor, blur_stays_within_its_bounds_for_every_width)
{
    const int margin = BLUR_MARGIN;
    for (int width = 1; width <= MAX_WIDTH; width++)
    {
        const std::vector<Mat> images = hardImages(Size(width, 1 + width * 7 % 23), width);
        for (size_t i = 0; i < images.size(); i++)
        {
            SCOPED_TRACE(format("width %d, image %d", width, int(i)));
            const Mat blurred = approximateBlur(images[i]);
            expectWithinBounds(images[i], blurred, reference::blur(images[i]));
            // The pixels around the image are reflected, but not blurred.
            Mat around;
            cv::copyMakeBorder(images[i], around, margin, margin, margin, margin, BORDER_REFLECT_101);
            around.convertTo(around, CV_16U, 256);
            blurred.copyTo(around(Rect(Point(margin, margin), blurred.size())));
            EXPECT_TRUE(sameMat(withMargin(blurred), around));
            Mat exactTimes256;
            reference::roundedBlur(images[i]).convertTo(exactTimes256, CV_16U, 256);
            EXPECT_TRUE(sameMat(approximateBlur(images[i], true), exactTimes256));
            WithoutOptimization baseline;
            EXPECT_TRUE(sameMat(withMargin(blurred), withMargin(approximateBlur(images[i]))));
            EXPECT_TRUE(sameMat(approximateBlur(images[i], true), exactTimes256));
        }
    }
}

TEST(Aqorb_Descriptor, blur_of_a_region_equals_that_of_the_image)
{
    RNG rng(3);
    const int widths[] = {1, 2, 5, 6, 7, 31, 32, 33, 37, 38, 39, 64, 100, 700, 2047, 2048, 2049, 2500};
    const int height = 61, reach = 19;
    BlurRegion region;  // It is used again and again, so begin must reset it.
    std::vector<uchar> scratch;
    for (int width : widths)
    {
        const Mat image = makeNoise(Size(width, height), width), whole = approximateBlur(image);
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

TEST(Aqorb_Descriptor, blur_stays_within_its_bounds_on_the_worst_patches)
{
    // Around a single bright pixel every product of a tap is rounded alone.
    for (int i = 0; i < 49; i++)
        for (int grey = 1; grey <= 255; grey += 2)
        {
            Mat image = Mat::zeros(13, 40, CV_8UC1);
            image.at<uchar>(3 + i / 7, 17 + i % 7) = uchar(grey);
            expectWithinBounds(image, approximateBlur(image), reference::blur(image));
        }
}

TEST(Aqorb_Descriptor, blur_on_request_equals_fused_multiply_add)
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

Mat referenceDescriptors(const Mat& image, const std::vector<FeaturePoint>& points, int patchSize, int WTA_K)
{
    const std::vector<Point> pattern = descriptorPattern(patchSize, WTA_K);
    const Mat blurred = reference::roundedBlur(image);
    Mat descriptors(int(points.size()), 32, CV_8UC1);
    for (int i = 0; i < descriptors.rows; i++)
        reference::descriptor(image, blurred, Point(points[i].x, points[i].y), points[i].angle, pattern,
                              WTA_K, descriptors.ptr(i));
    return descriptors;
}

void expectAsReference(const Mat& image, const std::vector<FeaturePoint>& points, int patchSize, int WTA_K)
{
    const DescriptorTests tests(descriptorPattern(patchSize, WTA_K), WTA_K);
    const Mat expected = referenceDescriptors(image, points, patchSize, WTA_K);
    const Mat blurred = approximateBlur(image);
    for (int optimized = 1; optimized >= 0; optimized--)
    {
        SCOPED_TRACE(optimized);
        const bool before = useOptimized();
        setUseOptimized(optimized && before);
        // rows of a wider matrix: what is beside them must stay
        Mat wide(expected.rows, 48, CV_8UC1, Scalar(0xa5));
        Mat descriptors = wide.colRange(8, 40);
        computeDescriptors(image, rowsOf(blurred), points.data(), points.size(), tests, descriptors.ptr(),
                           wide.step);
        setUseOptimized(before);
        EXPECT_TRUE(sameMat(descriptors, expected));
        EXPECT_TRUE(isAround(descriptors, 0xa5));
    }
}

std::vector<FeaturePoint> randomPoints(Size size, int count, int seed)
{
    RNG rng(seed);
    std::vector<FeaturePoint> points;
    for (int i = 0; i < count; i++)
    {
        // Some angles are round. In others some coordinates of the learned pattern end in exactly a half.
        const float ties[] = {24.57f, 26.14f, 63.86f, 114.57f, 153.86f, 210.f};
        const float angles[] = {float(rng.uniform(0, 25) * 15), ties[rng.uniform(0, 6)],
                                rng.uniform(-1.f, 720.f), rng.uniform(-1.f, 720.f)};
        points.push_back(
            FeaturePoint{rng.uniform(0, size.width), rng.uniform(0, size.height), angles[i % 4]});
    }
    return points;
}

// Of dither nearly all pixels are needed exactly, so that they are all blurred exactly after the first few points.
TEST(Aqorb_Descriptor, of_dither_equals_reference)
{
    const Mat noise = makeNoise(Size(300, 420));
    for (const Mat& image : {Mat((noise & 1) + 100), Mat(noise > 127)})
        for (int WTA_K = 2; WTA_K <= 4; WTA_K++)
        {
            const std::vector<FeaturePoint> points = randomPoints(image.size(), 300, WTA_K);
            const Mat expected = referenceDescriptors(image, points, 31, WTA_K);
            KeyPoints keypoints;
            for (const FeaturePoint& p : points)
                keypoints.push_back(KeyPoint(float(p.x), float(p.y), 31, p.angle));
            for (int threads = 1; threads <= 2; threads++)
            {
                SCOPED_TRACE(format("WTA_K %d, %d threads", WTA_K, threads));
                const Threads scope(threads);
                Mat descriptors;
                AdaptiveQuadtreeORB::create(500, 1.2f, 8, 0, 0, WTA_K)
                    ->compute(image, keypoints, descriptors);
                EXPECT_TRUE(sameMat(descriptors, expected));
            }
        }
}

void expectAsReferenceOfImages(Size size, const std::vector<int>& patches)
{
    Mat smooth, slope(size, CV_8UC1), checkers(size, CV_8UC1);
    blur(makeNoise(size), smooth, Size(9, 9));
    // Slopes so flat that neighbours differ by less than the bound of the approximate blur.
    for (int y = 0; y < size.height; y++)
        for (int x = 0; x < size.width; x++)
        {
            slope.at<uchar>(y, x) = uchar(100 + (x + y) / 16 + (x * 7 + y * 3) % 2);
            checkers.at<uchar>(y, x) = uchar((x + y) % 2 ? 101 : 100);
        }
    const Mat images[] = {makeScene(size), makeNoise(size), makeNoise(size) > 128,         smooth,
                          slope,           checkers,        Mat(size, CV_8UC1, Scalar(77))};
    for (int WTA_K = 2; WTA_K <= 4; WTA_K++)
        for (int patchSize : patches)
            for (int i = 0; i < 7; i++)
            {
                SCOPED_TRACE(format("%d x %d, WTA_K %d, patch %d, image %d", size.width, size.height, WTA_K,
                                    patchSize, i));
                expectAsReference(images[i], randomPoints(size, WTA_K == 2 ? 150 : 40, i), patchSize, WTA_K);
            }
}

TEST(Aqorb_Descriptor, equals_reference)
{
    expectAsReferenceOfImages(Size(130, 95), {2, 3, 8, 30, 31, 32, 47, 80, 100});
    // Nearly all patches reach beyond the border.
    for (const Size& size : {Size(70, 64), Size(33, 20), Size(9, 40), Size(3, 3), Size(1, 1)})
        expectAsReferenceOfImages(size, {31, 47});
}

TEST(Aqorb_Descriptor, pattern_equals_reference)
{
    for (int WTA_K = 2; WTA_K <= 4; WTA_K++)
        for (int patchSize = 2; patchSize <= 100; patchSize++)
        {
            SCOPED_TRACE(format("WTA_K %d, patch %d", WTA_K, patchSize));
            const std::vector<Point> pattern = descriptorPattern(patchSize, WTA_K);
            EXPECT_EQ(pattern, reference::descriptorPattern(patchSize, WTA_K));
            EXPECT_EQ(int(pattern.size()), WTA_K == 2 ? 512 : 128 * WTA_K);
            for (const Point& p : pattern)
                ASSERT_LE(std::max(std::abs(p.x), std::abs(p.y)), (patchSize + 1) / 2);
        }
}

unsigned bitsOf(float v)
{
    Cv32suf bits;
    bits.f = v;
    return bits.u;
}

//! Angles of either sign: every exponent, with many mantissas.
std::vector<float> manyAngles(float largest = 120)
{
    std::vector<float> angles;
    for (unsigned bits = 0; bits <= bitsOf(largest); bits += 1009)
    {
        Cv32suf angle;
        angle.u = bits;
        angles.push_back(angle.f);
        angles.push_back(-angle.f);
    }
    return angles;
}

#if defined(__GLIBC__)
#if !__GLIBC_PREREQ(2, 42)  // later versions were not compared
TEST(Aqorb_Descriptor, sine_and_cosine_are_those_of_the_gnu_c_library)
{
    int different = 0;
    for (const float angle : manyAngles(FLT_MAX))
    {
        float sine, cosine;
        aqorb::sineAndCosine(angle, sine, cosine);
        different += sine != std::sin(angle) || cosine != std::cos(angle);
    }
    EXPECT_EQ(0, different);
}
#endif
#endif

TEST(Aqorb_Descriptor, sine_and_cosine_are_the_same_on_every_system)
{
    uint64 hash = 0;
    for (const float angle : manyAngles())
    {
        float sine, cosine;
        aqorb::sineAndCosine(angle, sine, cosine);
        // The sign of a zero is of no effect.
        hash = (hash ^ bitsOf(sine + 0.f)) * 0x9e3779b97f4a7c15ULL;
        hash = (hash ^ bitsOf(cosine + 0.f)) * 0x9e3779b97f4a7c15ULL;
    }
    EXPECT_EQ(uint64(0xb64e51f6095d960), hash);
}

}  // namespace
}  // namespace opencv_test
