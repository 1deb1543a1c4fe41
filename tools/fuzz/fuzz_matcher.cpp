// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "generate.hpp"

#include "../../test/reference.hpp"

#include <opencv2/core/utility.hpp>

#include <cstring>

// Compares the matchers with the tests' plain reference, on the best kernels of the CPU and on the baseline, with one
// thread and with two. Calls with bad arguments must name the argument. Refined and grown matches must be equal on both
// kernels.

using namespace opencv_test;
using fuzz::require;

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
        const Point2f a = predicted[i], b = keypoints[j].pt;
        return std::isfinite(a.x) && std::isfinite(a.y) && std::isfinite(b.x) && std::isfinite(b.y) &&
               differAtMost(a.x, b.x, reach.width) && differAtMost(a.y, b.y, reach.height);
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

// Any arguments must give a result, or an exception that states the accepted values.
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

// Results of growMatches; refined matches come first.
struct Growth
{
    std::vector<DMatch> matches;
    std::vector<KeyPoint> keypoints1, keypoints2;
    std::vector<Point2f> points1, points2;
    std::vector<float> deviations;
};

template <typename T> static bool sameBytes(const std::vector<T>& a, const std::vector<T>& b)
{
    return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0);
}

// Grows matches of random keypoints in random images. Some fields have any number, and some indices are out of range.
static void growAnything(FuzzedDataProvider& data)
{
    Mat images[2];
    std::vector<KeyPoint> keypoints[2];
    for (int i = 0; i < 2; i++)
    {
        images[i] = fuzz::image(data, 80, true);
        const auto any = [&](double high) { return float(fuzz::real(data, -1, high)); };
        for (int count = data.ConsumeIntegralInRange(0, 40); count > 0; count--)
            keypoints[i].push_back(
                KeyPoint(Point2f(any(80), any(80)), any(60), any(360), 0, fuzz::number(data, 0, 8)));
    }
    std::vector<DMatch> matches;
    for (int count = data.ConsumeIntegralInRange(0, 60); count > 0; count--)
        matches.push_back(DMatch(fuzz::number(data, 0, 5), fuzz::number(data, 0, 5), 0));
    const bool bothWays = data.ConsumeBool();
    const float correlation = float(fuzz::real(data, -1, 1)), factor = float(fuzz::real(data, 0, 7));
    Growth expected;
    for (int run = 0; run < 2; run++)
    {
        setUseOptimized(run == 0);
        setNumThreads(1 + run);
        Growth grown, refined;
        grown.matches = refined.matches = matches;
        try
        {
            aqorb::growMatches(images[0], keypoints[0], images[1], keypoints[1], grown.matches,
                               grown.keypoints1, grown.keypoints2, grown.points1, grown.points2,
                               grown.deviations, correlation, factor, bothWays);
            aqorb::refineMatches(images[0], keypoints[0], images[1], keypoints[1], refined.matches,
                                 refined.points1, refined.points2, refined.deviations, correlation, factor);
        }
        catch (const cv::Exception& e)
        {
            require(e.err.find("must") != std::string::npos, e.what());
            require(grown.matches.size() == matches.size() && grown.points1.empty(), "outputs stay");
        }
        require(grown.points2.size() == grown.deviations.size() &&
                    grown.points1.size() == grown.deviations.size(),
                "a position and a deviation for each match");
        for (size_t i = 0; i < grown.deviations.size(); i++)
            require(grown.deviations[i] >= 0 && size_t(grown.matches[i].queryIdx) < grown.keypoints1.size() &&
                        size_t(grown.matches[i].trainIdx) < grown.keypoints2.size() &&
                        (i < refined.matches.size() || grown.matches[i].distance == FLT_MAX),
                    "the fields of a match");
        const size_t count = refined.points2.size();
        require(
            count <= grown.points2.size() &&
                sameBytes(refined.points2, std::vector<Point2f>(grown.points2.begin(),
                                                                grown.points2.begin() + ptrdiff_t(count))),
            "the refined matches first");
        require(run == 0 || (sameBytes(expected.points1, grown.points1) &&
                             sameBytes(expected.points2, grown.points2) &&
                             sameBytes(expected.deviations, grown.deviations)),
                "the same on all kernels");
        expected = grown;
    }
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
    growAnything(data);
    return 0;
}
