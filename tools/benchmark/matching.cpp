// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// How long matching takes beside cv::BFMatcher, alone and in the whole work for two images.

#include "benchmark.hpp"
#include "table.hpp"

#include <opencv2/aqorb.hpp>
#include <opencv2/core/utility.hpp>
#if CV_VERSION_MAJOR >= 5
#include <opencv2/geometry.hpp>
#else
#include <opencv2/calib3d.hpp>
#endif

#include <algorithm>
#include <iostream>

using namespace cv;
using aqorb::HammingMatcher;

namespace
{

//! Descriptors of two images, of which 6 of 10 are of the same points: of these some bits differ.
struct Descriptors
{
    Descriptors(int n, int bytes) : query(n, bytes, CV_8UC1), train(n, bytes, CV_8UC1)
    {
        RNG rng(1);
        rng.fill(query, RNG::UNIFORM, 0, 256);
        rng.fill(train, RNG::UNIFORM, 0, 256);
        std::vector<int> order(n);
        for (int i = 0; i < n; i++)
            std::swap(order[i] = i, order[rng.uniform(0, i + 1)]);
        for (int i = 0; i < n * 6 / 10; i++)
        {
            query.row(i).copyTo(train.row(order[i]));
            for (int j = 0; j < 20; j++)
                train.at<uchar>(order[i], rng.uniform(0, bytes)) ^= uchar(1 << rng.uniform(0, 8));
        }
    }
    double timeCrossCheck(const DescriptorMatcher& matcher)
    {
        return milliseconds([&] { matcher.match(query, train, matches); });
    }
    double timeTwoNearest(const DescriptorMatcher& matcher)
    {
        lists.clear();
        return milliseconds([&] { matcher.knnMatch(query, train, lists, 2); });
    }

    Mat query, train;
    // Outputs, which keep their memory.
    std::vector<DMatch> matches;
    std::vector<std::vector<DMatch>> lists;
};

//! The whole work for two images: features, matches and the homography.
void findHomographyOf(const Mat& first, const Mat& second, Feature2D& detector,
                      const DescriptorMatcher& matcher)
{
    Features features[2];
    detector.detectAndCompute(first, noArray(), features[0].keypoints, features[0].descriptors);
    detector.detectAndCompute(second, noArray(), features[1].keypoints, features[1].descriptors);
    std::vector<DMatch> matches;
    matcher.match(features[0].descriptors, features[1].descriptors, matches);
    std::vector<Point2f> from, to;
    for (const DMatch& match : matches)
    {
        from.push_back(features[0].keypoints[match.queryIdx].pt);
        to.push_back(features[1].keypoints[match.trainIdx].pt);
    }
    if (matches.size() >= 4)
        findHomography(from, to, RANSAC);
}

}  // namespace

void measurePairs(const Settings& settings)
{
    const BFMatcher slow(NORM_HAMMING, true);
    const HammingMatcher fast(NORM_HAMMING, true);
    std::vector<std::pair<Image, Image>> pairs;
    if (settings.images.empty())
        for (const char* set : {"bikes", "leuven", "bark", "trees", "ubc"})
        {
            pairs.push_back({Image(set), Image(imageOfSet(set, 2))});
            pairs.back().first.name = set;
        }
    else
        pairs.push_back({Image(settings.images[0]), Image(settings.images[1])});

    std::cout << cpuName() << "\n\n";
    Table table({"pair", "n", "threads", "cv::ORB and cv::BFMatcher, ms", "aqorb and HammingMatcher, ms",
                 "times as fast", "with cv::BFMatcher"});
    for (const int threads : settings.threads)
    {
        setNumThreads(threads);
        for (const int n : settings.numbers)
        {
            const Ptr<Feature2D> theirs = orb().create(n), ours = aqorbHere().create(n);
            std::vector<double> gains, gainsOfDetector;
            for (const auto& pair : pairs)
            {
                const auto time = [&](Feature2D& detector, const DescriptorMatcher& matcher) {
                    return milliseconds(
                        [&] { findHomographyOf(pair.first.pixels, pair.second.pixels, detector, matcher); });
                };
                double ms[2];
                gains.push_back(medianRatio([&] { return time(*theirs, slow); },
                                            [&] { return time(*ours, fast); }, settings.turns, ms));
                gainsOfDetector.push_back(medianRatio([&] { return time(*theirs, slow); },
                                                      [&] { return time(*ours, slow); }, settings.turns));
                table.add({pair.first.name, std::to_string(n), std::to_string(threads), cell(ms[0]),
                           cell(ms[1]), cell(gains.back(), 1), cell(gainsOfDetector.back(), 1)});
            }
            if (pairs.size() > 1)
                table.add({"geometric mean", std::to_string(n), std::to_string(threads), "", "",
                           cell(geometricMean(gains), 1), cell(geometricMean(gainsOfDetector), 1)});
        }
    }
    std::cout << table.text() << std::flush;
}

void measureMatching(const Settings& settings)
{
    const BFMatcher theirCross(NORM_HAMMING, true), theirs(NORM_HAMMING);
    const HammingMatcher ourCross(NORM_HAMMING, true), ours(NORM_HAMMING);
    std::cout << cpuName() << "\n\n";
    Table table({"", "n", "threads", "cv::BFMatcher, ms", "HammingMatcher, ms", "times as fast"});
    for (const int threads : settings.threads)
    {
        setNumThreads(threads);
        for (const bool crossCheck : {true, false})
        {
            const std::string task = crossCheck ? "cross check" : "two nearest";
            std::vector<double> gains;
            for (const int n : settings.numbers)
            {
                Descriptors d(n, 32);
                const auto time = [&](const DescriptorMatcher& cross, const DescriptorMatcher& all)
                { return crossCheck ? d.timeCrossCheck(cross) : d.timeTwoNearest(all); };
                double ms[2];
                gains.push_back(medianRatio([&] { return time(theirCross, theirs); },
                                            [&] { return time(ourCross, ours); }, settings.turns, ms));
                table.add({task, std::to_string(n), std::to_string(threads), cell(ms[0], 3), cell(ms[1], 3),
                           cell(gains.back(), 1)});
            }
            table.add(
                {task, "geometric mean", std::to_string(threads), "", "", cell(geometricMean(gains), 1)});
        }
    }
    std::cout << table.text() << std::flush;
}

void measureProgram(const Settings& settings)
{
    const BFMatcher cross(NORM_HAMMING, true), all(NORM_HAMMING);
    std::cout << cpuName() << "\n\n";
    Table table({"cv::BFMatcher", "n", "threads", "match, ms", "cross check, ms", "two nearest, ms"});
    for (const int threads : settings.threads)
    {
        setNumThreads(threads);
        for (const int n : settings.numbers)
        {
            Descriptors d(n, 64);
            std::vector<double> times[3];
            for (int turn = 0; turn < settings.turns; turn++)
            {
                times[0].push_back(d.timeCrossCheck(all));
                times[1].push_back(d.timeCrossCheck(cross));
                times[2].push_back(d.timeTwoNearest(all));
            }
            table.add({"64 bytes", std::to_string(n), std::to_string(threads), cell(median(times[0]), 3),
                       cell(median(times[1]), 3), cell(median(times[2]), 3)});
        }
    }
    std::cout << table.text() << std::flush;
}
