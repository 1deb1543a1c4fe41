// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "generate.hpp"

#include "../../test/reference_matching.hpp"

#include <opencv2/core/ocl.hpp>
#include <opencv2/core/utility.hpp>

#include <cstring>

// Compares the matcher and the functions that match with the plain reference of the tests, on the best kernels of the
// CPU and on the baseline ones, with one thread and with two; and calls them with bad arguments, which must be named.
// Refined positions are compared between kernels.

using namespace opencv_test;
using fuzz::require;

extern "C" int LLVMFuzzerInitialize(int*, char***);
extern "C" int LLVMFuzzerTestOneInput(const uint8_t* bytes, size_t size);

static void compareNeighbours(const Mat& query, const std::vector<Mat>& images, const std::vector<Mat>& masks,
                              int normType, int k)
{
    aqorb::HammingMatcher matcher(normType);
    matcher.add(images);
    MatchLists matches;
    matcher.knnMatch(query, matches, k, masks);
    require(int(matches.size()) == query.rows, "a list for each query");
    for (int i = 0; i < query.rows; i++)
    {
        std::vector<DMatch> expected = referenceMatches(query, i, images, masks, normType);
        expected.resize(std::min(expected.size(), size_t(k)));
        require(bool(sameMatches(MatchLists(1, expected), MatchLists(1, matches[i]))), "knnMatch");
    }
}

static void compareArrays(const Mat& query, const Mat& train, const ReferenceTests& tests,
                          const std::vector<Point2f>& predicted, const std::vector<KeyPoint>& keypoints,
                          Size2f reach)
{
    const auto inWindow = [&](int i, int j)
    {
        const double x = double(predicted[i].x) - keypoints[j].pt.x,
                     y = double(predicted[i].y) - keypoints[j].pt.y;
        return std::isfinite(x) && std::isfinite(y) && std::abs(x) <= reach.width &&
               std::abs(y) <= reach.height;
    };
    for (int byPosition = 0; byPosition < 2; byPosition++)
    {
        Mat pairs, distances;
        if (byPosition)
            aqorb::matchByPosition(query, predicted, train, keypoints, reach, pairs, distances, tests.ratio,
                                   tests.crossCheck, tests.maxDistance, tests.normType);
        else
            aqorb::matchArrays(query, train, pairs, distances, tests.ratio, tests.crossCheck,
                               tests.maxDistance, tests.normType);
        const std::vector<DMatch> expected =
            referenceTested(query, train, tests, [&](int i, int j) { return !byPosition || inWindow(i, j); });
        require(pairs.rows == int(expected.size()) && distances.rows == pairs.rows, "the number of pairs");
        for (int i = 0; i < pairs.rows; i++)
            require(pairs.at<int>(i, 0) == expected[i].queryIdx &&
                        pairs.at<int>(i, 1) == expected[i].trainIdx &&
                        distances.at<int>(i) == int(expected[i].distance),
                    "a pair");
    }
}

// Whatever is passed, there is a result or an exception that says what is accepted.
static void callWithAnything(FuzzedDataProvider& data, const Mat& query, const Mat& train)
{
    const Mat other = fuzz::image(data, 24, true);
    const Mat& second = data.ConsumeBool() ? other : train;
    const int k = fuzz::number(data, 0, 9), norm = fuzz::number(data, NORM_HAMMING, NORM_HAMMING2);
    const double ratio = fuzz::real(data, 0, 2);
    const int limit = fuzz::number(data, -1, 300);
    Mat a, b;
    try
    {
        aqorb::matchArrays(query, second, a, b, ratio, data.ConsumeBool(), limit, norm);
        aqorb::knnMatchArrays(query, second, a, b, k < 100 ? k : -k, norm);
    }
    catch (const cv::Exception& e)
    {
        require(e.err.find("must") != std::string::npos, e.what());
    }
}

// Refines matches of any keypoints in any images: some fields are any number, and some indices are beyond the end.
static void refineAnything(FuzzedDataProvider& data)
{
    Mat images[2];
    std::vector<KeyPoint> keypoints[2];
    for (int i = 0; i < 2; i++)
    {
        images[i] = fuzz::image(data, 80, true);
        const auto any = [&](double high) { return float(fuzz::real(data, -1, high)); };
        for (int count = data.ConsumeIntegralInRange(0, 40); count > 0; count--)
            keypoints[i].push_back(KeyPoint(Point2f(any(80), any(80)), any(60), any(360)));
    }
    std::vector<DMatch> matches;
    for (int count = data.ConsumeIntegralInRange(0, 60); count > 0; count--)
        matches.push_back(DMatch(fuzz::number(data, 0, 5), fuzz::number(data, 0, 5), 0));
    const float correlation = float(fuzz::real(data, -1, 1)), factor = float(fuzz::real(data, 0, 7));
    std::vector<Point2f> expected;
    for (int run = 0; run < 2; run++)
    {
        setUseOptimized(run == 0);
        setNumThreads(1 + run);
        std::vector<DMatch> left = matches;
        std::vector<Point2f> points[2];
        try
        {
            aqorb::refineMatches(images[0], keypoints[0], images[1], keypoints[1], left, points[0], points[1],
                                 correlation, factor);
            require(points[0].size() == left.size() && points[1].size() == left.size(),
                    "a position for each match");
            const size_t bytes = points[1].size() * sizeof(Point2f);
            require(run == 0 || (expected.size() == points[1].size() &&
                                 std::memcmp(expected.data(), points[1].data(), bytes) == 0),
                    "the same positions on all kernels");
        }
        catch (const cv::Exception& e)
        {
            require(e.err.find("must") != std::string::npos, e.what());
            require(left.size() == matches.size() && points[0].empty() && points[1].empty(), "outputs stay");
        }
        expected = points[1];
    }
}

extern "C" int LLVMFuzzerInitialize(int*, char***)
{
    cv::ocl::setUseOpenCL(false);
    return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* bytes, size_t size)
{
    FuzzedDataProvider data(bytes, size);
    const int width = data.ConsumeBool() ? 32 : data.ConsumeIntegralInRange(1, 140);
    const auto descriptors = [&]
    { return fuzz::matrix(data, Size(width, data.ConsumeIntegralInRange(1, 50)), CV_8UC1); };
    const Mat query = descriptors();
    std::vector<Mat> images(1, descriptors()), masks;
    while (images.size() < 4 && data.ConsumeBool())
        images.push_back(descriptors());
    const bool isMasked = data.ConsumeBool();
    for (size_t i = 0; isMasked && i < images.size(); i++)
        masks.push_back(fuzz::matrix(data, Size(images[i].rows, query.rows), CV_8UC1));
    const int k = data.ConsumeIntegralInRange(1, 9);
    ReferenceTests tests;
    tests.ratio = data.ConsumeBool() ? data.ConsumeFloatingPointInRange(0., 2.) : 0;
    tests.crossCheck = data.ConsumeBool();
    tests.maxDistance = data.ConsumeIntegralInRange(-1, 8 * width);
    tests.normType = data.ConsumeBool() ? NORM_HAMMING : NORM_HAMMING2;
    const auto coordinate = [&] { return float(fuzz::real(data, -10, 100)); };
    std::vector<Point2f> predicted;
    std::vector<KeyPoint> keypoints;
    for (int i = 0; i < query.rows; i++)
        predicted.push_back(Point2f(coordinate(), coordinate()));
    for (int i = 0; i < images[0].rows; i++)
        keypoints.push_back(KeyPoint(Point2f(coordinate(), coordinate()), 31));
    const Size2f reach(data.ConsumeFloatingPointInRange(0.f, 120.f),
                       data.ConsumeFloatingPointInRange(0.f, 120.f));

    for (int run = 0; run < 2; run++)
    {
        setUseOptimized(run == 0);
        setNumThreads(1 + run);
        compareNeighbours(query, images, masks, tests.normType, k);
        compareArrays(query, images[0], tests, predicted, keypoints, reach);
    }
    setUseOptimized(true);
    callWithAnything(data, query, images[0]);
    refineAnything(data);
    return 0;
}
