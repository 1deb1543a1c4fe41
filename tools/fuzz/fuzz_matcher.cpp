// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "generate.hpp"

#include "../../test/test_precomp.hpp"

#include <opencv2/core/utility.hpp>

// Calls the matchers and the refinement with any arguments. A call must give a result, or an exception that states the
// accepted values. The best kernels of the CPU and the baseline kernels, one thread and two must give the same bytes.
// The tests compare these functions with plain references.

using namespace opencv_test;

namespace
{

struct Arguments
{
    Mat query;
    std::vector<Mat> trains, masks;
    Mat images[2];
    KeyPoints keypoints[2];  // mostly one for each descriptor
    std::vector<Point2f> predicted;
    std::vector<DMatch> matches;
    Mat F;
    int norm, k, maxDistance;
    bool isSwitchedOn;  // crossCheck, bothWays and the like
    double ratio;
    Size2f reach;
    float correlation, scaleFactor;
};

Mat fundamental(FuzzedDataProvider& data)
{
    Mat F(3, 3, data.ConsumeBool() ? CV_64FC1 : CV_32FC1);
    for (int i = 0; i < 9; i++)
        F.row(i / 3).col(i % 3).setTo(fuzz::real(data, -1, 1));
    return F;
}

KeyPoints keypoints(FuzzedDataProvider& data, int count)
{
    const auto real = [&](double high) { return float(fuzz::real(data, -1, high)); };
    KeyPoints result;
    for (int i = 0; i < std::max(count, 0); i++)
        result.push_back(
            KeyPoint(Point2f(real(80), real(80)), real(60), real(360), 0, fuzz::number(data, 0, 8)));
    return result;
}

Arguments argumentsFrom(FuzzedDataProvider& data)
{
    Arguments a;
    const int width = data.ConsumeBool() ? 32 : data.ConsumeIntegralInRange(1, 140);
    const auto descriptors = [&]
    {
        return data.ConsumeIntegralInRange(0, 15)
                   ? fuzz::matrix(data, Size(width, data.ConsumeIntegralInRange(1, 50)), CV_8UC1)
                   : fuzz::image(data, 24, true);
    };
    a.query = descriptors();
    do
        a.trains.push_back(descriptors());
    while (a.trains.size() < 4 && data.ConsumeBool());
    const bool isMasked = data.ConsumeBool();
    for (size_t i = 0; isMasked && i < a.trains.size(); i++)
        a.masks.push_back(
            fuzz::mask(data, Size(std::max(a.trains[i].rows, 0), std::max(a.query.rows, 0)), true));
    for (int i = 0; i < 2; i++)
    {
        a.images[i] = fuzz::image(data, 80, true);
        a.keypoints[i] = keypoints(data, (i ? a.trains[0] : a.query).rows - int(data.ConsumeBool()));
    }
    KeyPoint::convert(keypoints(data, a.query.rows), a.predicted);
    for (int count = data.ConsumeIntegralInRange(0, 60); count > 0; count--)
        a.matches.push_back(DMatch(fuzz::number(data, 0, 5), fuzz::number(data, 0, 5), 0));
    a.F = fundamental(data);
    a.norm = data.ConsumeBool() ? NORM_HAMMING : fuzz::number(data, NORM_HAMMING, NORM_HAMMING2);
    a.k = data.ConsumeBool() ? data.ConsumeIntegralInRange(1, 9) : fuzz::number(data, 0, 9) % 1000;
    a.maxDistance = fuzz::number(data, -1, 8 * width);
    a.isSwitchedOn = data.ConsumeBool();
    a.ratio = fuzz::real(data, 0, 2);
    a.reach = Size2f(float(fuzz::real(data, 0, 60)), float(fuzz::real(data, 0, 60)));
    a.correlation = float(fuzz::real(data, -1, 1));
    a.scaleFactor = float(fuzz::real(data, 0, 7));
    return a;
}

template <typename T> Mat bytesOf(const std::vector<T>& values)
{
    const Mat bytes(int(values.size()), int(sizeof(T)), CV_8UC1, const_cast<T*>(values.data()));
    return bytes.clone();
}

//! The outputs of all functions.
std::vector<Mat> resultsOf(const Arguments& a)
{
    std::vector<std::vector<DMatch>> nearest, near;
    Mat outputs[8];
    const Mat& train = a.trains[0];
    fuzz::isCalled(
        [&]
        {
            aqorb::HammingMatcher matcher(a.norm, a.isSwitchedOn);
            matcher.add(a.trains);
            matcher.knnMatch(a.query, nearest, a.k, a.masks);
            matcher.radiusMatch(a.query, near, float(a.maxDistance), a.masks);
        });
    fuzz::isCalled(aqorb::matchArrays, a.query, train, outputs[0], outputs[1], a.ratio, a.isSwitchedOn,
                   a.maxDistance, a.norm);
    fuzz::isCalled(aqorb::knnMatchArrays, a.query, train, outputs[2], outputs[3], a.k, a.norm);
    fuzz::isCalled(aqorb::matchByPosition, a.query, a.predicted, train, a.keypoints[1], a.reach, outputs[4],
                   outputs[5], a.ratio, a.isSwitchedOn, a.maxDistance, a.norm);
    fuzz::isCalled(aqorb::matchGuided, a.query, a.keypoints[0], train, a.keypoints[1], a.F, a.reach.width,
                   outputs[6], outputs[7], a.ratio, a.maxDistance, a.norm);
    std::vector<DMatch> refined = a.matches, grown = a.matches;
    KeyPoints keypoints1, keypoints2;
    std::vector<Point2f> points1[2], points2[2];
    std::vector<float> deviations[2];
    fuzz::isCalled(
        [&]
        {
            aqorb::refineMatches(a.images[0], a.keypoints[0], a.images[1], a.keypoints[1], refined,
                                 points1[0], points2[0], deviations[0], a.correlation, a.scaleFactor);
        });
    const bool isGrown = fuzz::isCalled(aqorb::growMatches, a.images[0], a.keypoints[0], a.images[1],
                                        a.keypoints[1], grown, keypoints1, keypoints2, points1[1], points2[1],
                                        deviations[1], a.correlation, a.scaleFactor, a.isSwitchedOn);
    for (const DMatch& match : grown)
        fuzz::require(!isGrown || (size_t(match.queryIdx) < keypoints1.size() &&
                                   size_t(match.trainIdx) < keypoints2.size()),
                      "a match of no keypoint");
    std::vector<Mat> results(outputs, outputs + 8);
    for (const auto& lists : {nearest, near})
        for (const std::vector<DMatch>& list : lists)
            results.push_back(bytesOf(list));
    for (int i = 0; i < 2; i++)
        results.insert(results.end(), {bytesOf(i ? grown : refined), bytesOf(points1[i]), bytesOf(points2[i]),
                                       bytesOf(deviations[i])});
    results.insert(results.end(), {bytesOf(keypoints1), bytesOf(keypoints2)});
    return results;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* bytes, size_t size)
{
    FuzzedDataProvider data(bytes, size);
    const Arguments arguments = argumentsFrom(data);
    std::vector<Mat> results[2];
    for (int run = 0; run < 2; run++)
    {
        setUseOptimized(run == 0);
        setNumThreads(1 + run);
        results[run] = resultsOf(arguments);
    }
    setUseOptimized(true);
    fuzz::require(results[0].size() == results[1].size(), "the number of results");
    for (size_t i = 0; i < results[0].size(); i++)
        fuzz::require(bool(sameMat(results[0][i], results[1][i])), "result " + std::to_string(i));
    return 0;
}
