// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "reference.hpp"
#include "whole_blur.hpp"

#include "descriptor.hpp"

namespace opencv_test
{
namespace
{

using namespace aqorb;

void computeDescriptors(const Mat& image, const Mat& blurred, const FeaturePoint* points, size_t count,
                        const std::vector<Point>& pattern, int WTA_K, uchar* descriptors, size_t step)
{
    computeDescriptors(image, rowsOf(blurred), points, count, DescriptorTests(pattern, WTA_K), descriptors,
                       step);
}

void expectAsReference(const Mat& image, const std::vector<FeaturePoint>& points, int patchSize, int WTA_K)
{
    const std::vector<Point> pattern = descriptorPattern(patchSize, WTA_K);
    const Mat exactlyBlurred = reference::roundedBlur(image);
    const int count = int(points.size());
    Mat expected(count, 32, CV_8UC1), blurred;
    for (int i = 0; i < count; i++)
        reference::descriptor(image, exactlyBlurred, Point(points[i].x, points[i].y), points[i].angle,
                              pattern, WTA_K, expected.ptr(i));
    approximateBlur(image, blurred);
    for (int optimized = 1; optimized >= 0; optimized--)
    {
        SCOPED_TRACE(optimized);
        const bool before = useOptimized();
        setUseOptimized(optimized && before);
        // rows of a wider matrix: what is beside them must stay
        Mat wide(count, 48, CV_8UC1, Scalar(0xa5));
        Mat descriptors = wide.colRange(8, 40);
        computeDescriptors(image, blurred, points.data(), points.size(), pattern, WTA_K, descriptors.ptr(),
                           wide.step);
        setUseOptimized(before);
        EXPECT_TRUE(sameMat(descriptors, expected));
        EXPECT_EQ(countNonZero(wide.colRange(0, 8) != 0xa5), 0);
        EXPECT_EQ(countNonZero(wide.colRange(40, 48) != 0xa5), 0);
    }
}

// Of dither nearly all pixels are needed exactly, so that they are all blurred exactly after the first few points.
TEST(Aqorb_Descriptor, of_dither_equals_reference)
{
    const Mat noise = makeNoise(Size(300, 420));
    for (const Mat& image : {Mat((noise & 1) + 100), Mat(noise > 127)})
        for (int WTA_K = 2; WTA_K <= 4; WTA_K++)
            for (int threads = 1; threads <= 2; threads++)
            {
                SCOPED_TRACE(format("WTA_K %d, %d threads", WTA_K, threads));
                const Threads scope(threads);
                RNG rng(WTA_K);
                KeyPoints keypoints;
                for (int i = 0; i < 300; i++)
                    keypoints.push_back(KeyPoint(float(rng.uniform(16, 284)), float(rng.uniform(16, 404)), 31,
                                                 rng.uniform(0.f, 360.f)));
                const Ptr<AdaptiveQuadtreeORB> detector = AdaptiveQuadtreeORB::create();
                detector->setWTA_K(WTA_K);
                Mat descriptors, expected(int(keypoints.size()), 32, CV_8UC1);
                detector->compute(image, keypoints, descriptors);
                const Mat blurred = reference::roundedBlur(image);
                for (int i = 0; i < expected.rows; i++)
                    reference::descriptor(image, blurred, keypoints[i].pt, keypoints[i].angle,
                                          descriptorPattern(31, WTA_K), WTA_K, expected.ptr(i));
                EXPECT_TRUE(sameMat(descriptors, expected));
            }
}

std::vector<FeaturePoint> randomPoints(Size size, int count, int seed)
{
    RNG rng(seed);
    std::vector<FeaturePoint> points;
    for (int i = 0; i < count; i++)
    {
        // many of the angles are round, and with them the ties of cvRound
        const float angle = i % 3 == 0 ? float(rng.uniform(0, 25) * 15) : rng.uniform(-1.f, 720.f);
        const FeaturePoint point = {rng.uniform(0, size.width), rng.uniform(0, size.height), angle};
        points.push_back(point);
    }
    return points;
}

TEST(Aqorb_Descriptor, equals_reference)
{
    const int patches[] = {2, 3, 8, 30, 31, 32, 47, 80, 100};
    const Size size(130, 95);
    Mat smooth;
    blur(makeNoise(size), smooth, Size(9, 9));
    const Mat images[] = {makeScene(size), makeNoise(size), makeNoise(size) > 128, smooth};
    for (int WTA_K = 2; WTA_K <= 4; WTA_K++)
        for (int patchSize : patches)
            for (int i = 0; i < 4; i++)
            {
                SCOPED_TRACE(format("WTA_K %d, patch %d, image %d", WTA_K, patchSize, i));
                expectAsReference(images[i], randomPoints(size, WTA_K == 2 ? 150 : 40, i), patchSize, WTA_K);
            }
}

TEST(Aqorb_Descriptor, equals_reference_at_borders)
{
    const Size sizes[] = {Size(70, 64), Size(33, 20), Size(9, 40), Size(3, 3), Size(1, 1)};
    for (const Size& size : sizes)
    {
        const Mat noise = makeNoise(size, 2);
        std::vector<FeaturePoint> points;
        for (int x = 0; x < size.width; x++)
        {
            const int rows[] = {0, size.height / 2, size.height - 1};
            for (int row : rows)
            {
                const FeaturePoint point = {x, row, float(x * 37 % 360)};
                points.push_back(point);
            }
        }
        for (int y = 0; y < size.height; y++)
        {
            const FeaturePoint left = {0, y, float(y * 53 % 360)};
            const FeaturePoint right = {size.width - 1, y, float(y * 91 % 360)};
            points.push_back(left);
            points.push_back(right);
        }
        for (int WTA_K = 2; WTA_K <= 4; WTA_K++)
        {
            SCOPED_TRACE(format("%d x %d, WTA_K %d", size.width, size.height, WTA_K));
            expectAsReference(noise, points, 31, WTA_K);
            expectAsReference(noise, points, 47, WTA_K);
        }
    }
}

TEST(Aqorb_Descriptor, equals_reference_where_the_approximation_cannot_tell)
{
    // Slopes so flat that neighbours differ by less than the bound of the approximate blur.
    Mat slope(100, 160, CV_8UC1);
    for (int y = 0; y < slope.rows; y++)
        for (int x = 0; x < slope.cols; x++)
            slope.at<uchar>(y, x) = uchar(100 + (x + y) / 16 + (x * 7 + y * 3) % 2);
    Mat checkers(100, 160, CV_8UC1);
    for (int y = 0; y < slope.rows; y++)
        for (int x = 0; x < slope.cols; x++)
            checkers.at<uchar>(y, x) = uchar((x + y) % 2 ? 101 : 100);
    for (int WTA_K = 2; WTA_K <= 4; WTA_K++)
    {
        expectAsReference(slope, randomPoints(slope.size(), 200, 5), 31, WTA_K);
        expectAsReference(checkers, randomPoints(slope.size(), 200, 6), 31, WTA_K);
        expectAsReference(Mat(slope.size(), CV_8UC1, Scalar(77)), randomPoints(slope.size(), 10, 7), 31,
                          WTA_K);
    }
}

TEST(Aqorb_Descriptor, equals_reference_where_points_are_rounded_to_even)
{
    // In these directions some coordinates of the learned pattern end in exactly a half.
    const Mat noise = makeNoise(Size(200, 200), 9);
    std::vector<FeaturePoint> points;
    for (float angle : {24.57f, 26.14f, 63.86f, 114.57f, 153.86f, 210.f})
        for (int i = 0; i < 20; i++)
        {
            const FeaturePoint point = {25 + 7 * i, 30 + 7 * i, angle};
            points.push_back(point);
        }
    expectAsReference(noise, points, 31, 2);
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

}  // namespace
}  // namespace opencv_test
