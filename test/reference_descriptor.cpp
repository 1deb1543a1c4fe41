// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "reference.hpp"

#include "orb_pattern.hpp"

namespace opencv_test
{
namespace reference
{

Mat blur(const Mat& image)
{
    const Mat kernel = getGaussianKernel(7, 2, CV_32F);
    const float* k = kernel.ptr<float>() + 3;
    Mat rows(image.size(), CV_32FC1), result(image.size(), CV_32FC1);
    for (int y = 0; y < image.rows; y++)
        for (int x = 0; x < image.cols; x++)
        {
            float sum = k[-3] * pixel(image, x - 3, y);
            for (int i = -2; i <= 3; i++)
                sum = std::fma(k[i], (float)pixel(image, x + i, y), sum);
            rows.at<float>(y, x) = sum;
        }
    for (int y = 0; y < image.rows; y++)
        for (int x = 0; x < image.cols; x++)
        {
            float sum = k[0] * rows.at<float>(y, x);
            for (int i = 1; i <= 3; i++)
            {
                const float above =
                    rows.at<float>(borderInterpolate(y - i, image.rows, BORDER_REFLECT_101), x);
                const float below =
                    rows.at<float>(borderInterpolate(y + i, image.rows, BORDER_REFLECT_101), x);
                sum = std::fma(k[i], below + above, sum);
            }
            result.at<float>(y, x) = sum;
        }
    return result;
}

Mat roundedBlur(const Mat& image)
{
    const Mat exact = blur(image);
    Mat result(image.size(), CV_8UC1);
    for (int y = 0; y < image.rows; y++)
        for (int x = 0; x < image.cols; x++)
            result.at<uchar>(y, x) = saturate_cast<uchar>(cvRound(exact.at<float>(y, x)));
    return result;
}

std::vector<Point> descriptorPattern(int patchSize, int WTA_K)
{
    std::vector<Point> pool;
    RNG poolRng(0x34985739);
    for (int i = 0; i < 512; i++)
    {
        // x is drawn before y
        const int x = poolRng.uniform(-patchSize / 2, patchSize / 2 + 1);
        const int y = poolRng.uniform(-patchSize / 2, patchSize / 2 + 1);
        const signed char* learned = aqorb::LEARNED_POINTS[i];
        pool.push_back(patchSize == 31 ? Point(learned[0], learned[1]) : Point(x, y));
    }
    if (WTA_K == 2)
        return pool;

    std::vector<Point> pattern;
    RNG rng(0x12345678);
    for (int i = 0; i < 128; i++)
        for (int k = 0; k < WTA_K;)
        {
            const Point point = pool[rng.uniform(0, 512)];
            bool isNew = true;
            for (int j = 0; j < k; j++)
                isNew &= pattern[WTA_K * i + j] != point;
            if (isNew)
            {
                pattern.push_back(point);
                k++;
            }
        }
    return pattern;
}

void descriptor(const Mat& image, const Mat& blurred, Point center, float angle,
                const std::vector<Point>& pattern, int WTA_K, uchar* bytes)
{
    angle *= (float)(CV_PI / 180.f);
    const float a = std::cos(angle), b = std::sin(angle);
    std::vector<int> values;
    for (size_t i = 0; i < pattern.size(); i++)
    {
        const Point p = center + Point(cvRound(pattern[i].x * a - pattern[i].y * b),
                                       cvRound(pattern[i].x * b + pattern[i].y * a));
        const bool inside = Rect(Point(), image.size()).contains(p);
        values.push_back(inside ? blurred.at<uchar>(p) : pixel(image, p.x, p.y));
    }
    const int bits = WTA_K == 2 ? 1 : 2;
    std::fill(bytes, bytes + 32, uchar(0));
    for (int test = 0; test < 256 / bits; test++)
    {
        const int* v = &values[test * WTA_K];
        int result;
        if (WTA_K == 2)
        {
            result = v[0] < v[1];
        }
        else if (WTA_K == 3)
        {
            result = v[2] > v[1] ? (v[2] > v[0] ? 2 : 0) : (v[1] > v[0]);
        }
        else
        {
            const int first = v[1] > v[0] ? 1 : 0, second = v[3] > v[2] ? 3 : 2;
            result = v[first] > v[second] ? first : second;
        }
        bytes[test * bits / 8] |= uchar(result << (test * bits % 8));
    }
}

}  // namespace reference

bool orbBlursWithFMA()
{
    const int BORDER = 8;  // cv::ORB blurs a part of a larger matrix
    // With or without, most images of this size come out the same; with this seed not.
    const Mat image = makeNoise(Size(200, 200), 18);
    Mat padded;
    cv::copyMakeBorder(image, padded, BORDER, BORDER, BORDER, BORDER, BORDER_REFLECT_101);
    Mat blurred = padded(Rect(Point(BORDER, BORDER), image.size()));
    GaussianBlur(blurred, blurred, Size(7, 7), 2, 2, BORDER_REFLECT_101);
    return countNonZero(blurred != reference::roundedBlur(image)) == 0;
}

}  // namespace opencv_test
