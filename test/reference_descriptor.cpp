// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// cv::ORB's blur and descriptor, and matching by comparing everything with everything.

#include "reference.hpp"

#include "detector/orb_pattern.hpp"

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

static int referenceDistance(const Mat& a, int row, const Mat& b, int otherRow, int normType)
{
    const int bits = normType == NORM_HAMMING2 ? 2 : 1;
    int distance = 0;
    for (int i = 0; i < a.cols; i++)
    {
        const int difference = a.at<uchar>(row, i) ^ b.at<uchar>(otherRow, i);
        for (int bit = 0; bit < 8; bit += bits)
            distance += (difference >> bit & ((1 << bits) - 1)) != 0;
    }
    return distance;
}

static bool isNearer(const DMatch& a, const DMatch& b)
{
    if (a.distance != b.distance)
        return a.distance < b.distance;
    return a.imgIdx != b.imgIdx ? a.imgIdx < b.imgIdx : a.trainIdx < b.trainIdx;
}

std::vector<DMatch> referenceMatches(const Mat& query, int row, const std::vector<Mat>& images,
                                     const std::vector<Mat>& masks, int normType)
{
    std::vector<DMatch> all;
    for (int image = 0; image < int(images.size()); image++)
    {
        const Mat mask = masks.empty() ? Mat() : masks[image];
        for (int i = 0; i < images[image].rows; i++)
            if (mask.empty() || mask.at<uchar>(row, i) != 0)
                all.push_back(
                    DMatch(row, i, image, float(referenceDistance(query, row, images[image], i, normType))));
    }
    std::sort(all.begin(), all.end(), isNearer);
    return all;
}

// The allowed partners of a descriptor, the nearest first. isTrain: of a train descriptor.
static std::vector<DMatch> partners(const Mat& query, const Mat& train, int own, bool isTrain, int normType,
                                    const Allowed& isAllowed)
{
    std::vector<DMatch> all;
    for (int i = 0; i < (isTrain ? query : train).rows; i++)
    {
        const int a = isTrain ? i : own, b = isTrain ? own : i;
        if (isAllowed(a, b))
            all.push_back(DMatch(own, i, float(referenceDistance(query, a, train, b, normType))));
    }
    std::sort(all.begin(), all.end(), isNearer);
    return all;
}

std::vector<DMatch> referenceTested(const Mat& query, const Mat& train, const ReferenceTests& tests,
                                    const Allowed& isAllowed)
{
    std::vector<DMatch> passed;
    for (int i = 0; i < query.rows; i++)
    {
        const std::vector<DMatch> trains = partners(query, train, i, false, tests.normType, isAllowed);
        if (trains.empty())
            continue;
        const DMatch& match = trains[0];
        bool passes = tests.maxDistance < 0 || match.distance <= tests.maxDistance;
        if (tests.ratio > 0 && trains.size() > 1)
            passes = passes && match.distance < tests.ratio * trains[1].distance;
        if (tests.crossCheck)
        {
            const std::vector<DMatch> queries =
                partners(query, train, match.trainIdx, true, tests.normType, isAllowed);
            passes = passes && queries[0].trainIdx == i;
            if (tests.ratio > 0 && queries.size() > 1)
                passes = passes && match.distance < tests.ratio * queries[1].distance;
        }
        if (passes)
            passed.push_back(match);
    }
    return passed;
}

//! Whether two finite coordinates differ by at most `reach`, without rounding.
static bool differAtMost(float a, float b, float reach)
{
    const double larger = std::max(a, b), smaller = std::min(a, b), difference = larger - smaller;
    const double lost = std::abs(larger) >= std::abs(smaller) ? -smaller - (difference - larger)
                                                              : larger - (difference + smaller);
    return difference < reach || (difference == reach && lost <= 0);
}

static bool isFinite(const Point2f& p)
{
    return std::isfinite(p.x) && std::isfinite(p.y);
}

bool isInWindow(const Point2f& a, const Point2f& b, Size2f reach)
{
    return isFinite(a) && isFinite(b) && differAtMost(a.x, b.x, reach.width) &&
           differAtMost(a.y, b.y, reach.height);
}

std::vector<DMatch> referenceGuided(const Mat& query, const KeyPoints& queryKeypoints, const Mat& train,
                                    const KeyPoints& trainKeypoints, const Matx33d& F, double reach,
                                    const ReferenceTests& tests)
{
    const auto isNearLine = [&](int i, int j)
    {
        const Point2f p = queryKeypoints[i].pt, q = trainKeypoints[j].pt;
        const double size = trainKeypoints[j].size;
        const Vec3d line = F * Vec3d(p.x, p.y, 1);
        const double length = std::hypot(line[0], line[1]);
        return isFinite(p) && isFinite(q) && std::isfinite(size) && length > 0 &&
               std::abs(line.dot(Vec3d(q.x, q.y, 1))) <= reach * std::max(1., size / 31) * length;
    };
    std::vector<DMatch> passed;
    for (int i = 0; i < query.rows; i++)
    {
        const std::vector<DMatch> trains = partners(query, train, i, false, tests.normType, isNearLine);
        const auto isElsewhere = [&](const DMatch& other)
        {
            const Point2d p = trainKeypoints[trains[0].trainIdx].pt, q = trainKeypoints[other.trainIdx].pt;
            return (p - q).dot(p - q) >= 8 * 8;
        };
        const auto second = std::find_if(trains.begin(), trains.end(), isElsewhere);
        if (!trains.empty() && trains[0].distance <= tests.maxDistance &&
            (tests.ratio == 0 || second == trains.end() ||
             trains[0].distance < tests.ratio * second->distance))
            passed.push_back(trains[0]);
    }
    return passed;
}

Mat randomDescriptors(RNG& rng, int rows, int bytes)
{
    Mat all(rows + rng.uniform(0, 3), bytes + rng.uniform(0, 20), CV_8UC1);
    rng.fill(all, RNG::UNIFORM, 0, 256);
    const int x = rng.uniform(0, all.cols - bytes + 1), y = rng.uniform(0, all.rows - rows + 1);
    Mat part = all(Rect(x, y, bytes, rows));
    const int kind = rng.uniform(0, 4), bits = 1 << rng.uniform(0, 5);
    for (int i = 1; i < rows && kind > 0; i++)
    {
        if (kind == 1 && rng.uniform(0, 2))
            continue;
        part.row(rng.uniform(0, i)).copyTo(part.row(i));
        for (int j = kind == 3 ? bits : rng.uniform(0, 3); j > 0; j--)
            part.at<uchar>(i, rng.uniform(0, bytes)) ^= uchar(1 << rng.uniform(0, 8));
    }
    return part;
}

::testing::AssertionResult sameMatches(const MatchLists& a, const MatchLists& b)
{
    if (a.size() != b.size())
        return ::testing::AssertionFailure() << a.size() << " and " << b.size() << " lists";
    for (size_t i = 0; i < a.size(); i++)
    {
        if (a[i].size() != b[i].size())
            return ::testing::AssertionFailure()
                   << a[i].size() << " and " << b[i].size() << " matches in list " << i;
        for (size_t j = 0; j < a[i].size(); j++)
        {
            const DMatch &one = a[i][j], &other = b[i][j];
            if (one.queryIdx != other.queryIdx || one.trainIdx != other.trainIdx ||
                one.imgIdx != other.imgIdx || one.distance != other.distance)
                return ::testing::AssertionFailure()
                       << "match " << j << " of list " << i << ": (" << one.queryIdx << ", " << one.trainIdx
                       << ", " << one.imgIdx << ") at " << one.distance << " and (" << other.queryIdx << ", "
                       << other.trainIdx << ", " << other.imgIdx << ") at " << other.distance;
        }
    }
    return ::testing::AssertionSuccess();
}

::testing::AssertionResult isMatchedAs(const std::vector<DMatch>& expected, const Mat& pairs,
                                       const Mat& distances)
{
    if (expected.empty())
        return pairs.empty() && distances.empty() ? ::testing::AssertionSuccess()
                                                  : ::testing::AssertionFailure() << "not empty";
    if (pairs.type() != CV_32SC1 || pairs.cols != 2 || distances.type() != CV_32SC1 || distances.cols != 1 ||
        pairs.rows != int(expected.size()) || distances.rows != pairs.rows)
        return ::testing::AssertionFailure() << pairs.rows << " rows in place of " << expected.size();
    for (int i = 0; i < pairs.rows; i++)
        if (pairs.at<int>(i, 0) != expected[i].queryIdx || pairs.at<int>(i, 1) != expected[i].trainIdx ||
            distances.at<int>(i) != int(expected[i].distance))
            return ::testing::AssertionFailure() << "row " << i << " differs";
    return ::testing::AssertionSuccess();
}

}  // namespace opencv_test
