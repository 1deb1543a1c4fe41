// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// How long matching takes beside cv::BFMatcher, alone and in the whole work for two images, and refinement beside
// cv::calcOpticalFlowPyrLK.

#include "benchmark.hpp"
#include "table.hpp"

#include <opencv2/aqorb.hpp>
#include <opencv2/core/utility.hpp>
#if CV_VERSION_MAJOR >= 5
#include <opencv2/geometry.hpp>
#else
#include <opencv2/calib3d.hpp>
#endif
#include <opencv2/video/tracking.hpp>

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
    double timeNearest(const DescriptorMatcher& matcher, int k, const Mat& mask = Mat())
    {
        lists.clear();
        return milliseconds([&] { matcher.knnMatch(query, train, lists, k, mask); });
    }

    Mat query, train;
    // Outputs, which keep their memory.
    std::vector<DMatch> matches;
    std::vector<std::vector<DMatch>> lists;
};

//! Two images, with the features and the cross-checked matches of them.
struct Pair
{
    Pair(const std::string& first, const std::string& second) : images{Image(first), Image(second)} {}
    void match(Feature2D& detector, const DescriptorMatcher& matcher)
    {
        for (int i = 0; i < 2; i++)
            detector.detectAndCompute(images[i].pixels, noArray(), features[i].keypoints,
                                      features[i].descriptors);
        matcher.match(features[0].descriptors, features[1].descriptors, matches);
    }
    //! The positions of the matches.
    void locate()
    {
        from.clear();
        to.clear();
        for (const DMatch& match : matches)
        {
            from.push_back(features[0].keypoints[match.queryIdx].pt);
            to.push_back(features[1].keypoints[match.trainIdx].pt);
        }
    }
    void refine()
    {
        aqorb::refineMatches(images[0].pixels, features[0].keypoints, images[1].pixels, features[1].keypoints,
                             matches, from, to);
    }
    //! Milliseconds of the whole work for two images: features, matches and the homography.
    double timeHomography(Feature2D& detector, const DescriptorMatcher& matcher, bool isRefined)
    {
        return milliseconds(
            [&]
            {
                match(detector, matcher);
                isRefined ? refine() : locate();
                if (matches.size() >= 4)
                    findHomography(from, to, RANSAC, isRefined ? 1 : 3);
            });
    }

    Image images[2];
    Features features[2];
    std::vector<DMatch> matches;
    std::vector<Point2f> from, to;
};

std::vector<Pair> pairsOf(const Settings& settings)
{
    std::vector<Pair> pairs;
    if (!settings.images.empty())
        pairs.push_back(Pair(settings.images[0], settings.images[1]));
    for (const char* set : {"bikes", "leuven", "bark", "trees", "ubc"})
    {
        if (!settings.images.empty())
            break;
        pairs.push_back(Pair(set, imageOfSet(set, 2)));
        pairs.back().images[0].name = set;
    }
    return pairs;
}

}  // namespace

void measurePairs(const Settings& settings)
{
    const BFMatcher slow(NORM_HAMMING, true);
    const HammingMatcher fast(NORM_HAMMING, true);
    std::vector<Pair> pairs = pairsOf(settings);
    std::cout << cpuName() << "\n\n";
    Table table({"pair", "n", "threads", "cv::ORB and cv::BFMatcher, ms", "aqorb and HammingMatcher, ms",
                 "times as fast", "with cv::BFMatcher", "refined"});
    for (const int threads : settings.threads)
    {
        setNumThreads(threads);
        for (const int n : settings.numbers)
        {
            const Ptr<Feature2D> theirs = orb().create(n), ours = aqorbHere().create(n);
            std::vector<double> gains, gainsOfDetector, gainsRefined;
            for (Pair& pair : pairs)
            {
                const auto time = [&](Feature2D& detector, const DescriptorMatcher& matcher, bool isRefined)
                {
                    if (settings.cold)
                        touchOtherMemory();
                    return pair.timeHomography(detector, matcher, isRefined);
                };
                const auto timeTheirs = [&] { return time(*theirs, slow, false); };
                double ms[2];
                gains.push_back(medianRatio(
                    timeTheirs, [&] { return time(*ours, fast, false); }, settings.turns, ms));
                gainsOfDetector.push_back(medianRatio(
                    timeTheirs, [&] { return time(*ours, slow, false); }, settings.turns));
                gainsRefined.push_back(medianRatio(
                    timeTheirs, [&] { return time(*ours, fast, true); }, settings.turns));
                table.add({pair.images[0].name, std::to_string(n), std::to_string(threads), cell(ms[0]),
                           cell(ms[1]), cell(gains.back(), 1), cell(gainsOfDetector.back(), 1),
                           cell(gainsRefined.back(), 1)});
            }
            if (pairs.size() > 1)
                table.add({"geometric mean", std::to_string(n), std::to_string(threads), "", "",
                           cell(geometricMean(gains), 1), cell(geometricMean(gainsOfDetector), 1),
                           cell(geometricMean(gainsRefined), 1)});
        }
    }
    std::cout << table.text() << std::flush;
}

void measureRefinement(const Settings& settings)
{
    std::vector<Pair> pairs = pairsOf(settings);
    std::cout << cpuName() << "\n\n";
    Table table({"pair", "n", "threads", "matches", "cv::calcOpticalFlowPyrLK, us a match",
                 "refineMatches, us a match", "times as fast"});
    for (const int threads : settings.threads)
    {
        setNumThreads(threads);
        for (const int n : settings.numbers)
        {
            std::vector<double> gains;
            for (Pair& pair : pairs)
            {
                pair.match(*aqorbHere().create(n), HammingMatcher(NORM_HAMMING, true));
                pair.locate();
                const std::vector<DMatch> matches = pair.matches;
                const std::vector<Point2f> start = pair.to, from = pair.from;
                const auto timeTheirs = [&]
                {
                    touchOtherMemory();
                    pair.to = start;
                    std::vector<uchar> status;
                    std::vector<float> errors;
                    return milliseconds(
                        [&]
                        {
                            calcOpticalFlowPyrLK(pair.images[0].pixels, pair.images[1].pixels, from, pair.to,
                                                 status, errors, Size(13, 13), 0,
                                                 TermCriteria(TermCriteria::COUNT, 4, 0),
                                                 OPTFLOW_USE_INITIAL_FLOW);
                        });
                };
                const auto timeOurs = [&]
                {
                    touchOtherMemory();
                    pair.matches = matches;
                    return milliseconds([&] { pair.refine(); });
                };
                double ms[2];
                gains.push_back(medianRatio(timeTheirs, timeOurs, settings.turns, ms));
                const double count = double(std::max(matches.size(), size_t(1)));
                table.add({pair.images[0].name, std::to_string(n), std::to_string(threads),
                           std::to_string(matches.size()), cell(1000 * ms[0] / count),
                           cell(1000 * ms[1] / count), cell(gains.back(), 1)});
            }
            if (pairs.size() > 1)
                table.add({"geometric mean", std::to_string(n), std::to_string(threads), "", "", "",
                           cell(geometricMean(gains), 1)});
        }
    }
    std::cout << table.text() << std::flush;
}

void measureMatching(const Settings& settings)
{
    const BFMatcher theirCross(NORM_HAMMING, true), theirs(NORM_HAMMING);
    const HammingMatcher ourCross(NORM_HAMMING, true), ours(NORM_HAMMING);
    const struct Task
    {
        const char* name;
        int k;  // 0 for a cross check
        bool isMasked;
    } tasks[] = {{"cross check", 0, false},   {"two nearest", 2, false},    {"10 nearest", 10, false},
                 {"100 nearest", 100, false}, {"nearest, masked", 1, true}, {"10 nearest, masked", 10, true}};
    std::cout << cpuName() << "\n\n";
    Table table({"", "n", "threads", "cv::BFMatcher, ms", "HammingMatcher, ms", "times as fast"});
    for (const int threads : settings.threads)
    {
        setNumThreads(threads);
        for (const Task& task : tasks)
        {
            std::vector<double> gains;
            for (const int n : settings.numbers)
            {
                Descriptors d(n, 32);
                const Mat mask = task.isMasked ? Mat(n, n, CV_8UC1, Scalar(255)) : Mat();
                const auto time = [&](const DescriptorMatcher& cross, const DescriptorMatcher& all)
                { return task.k == 0 ? d.timeCrossCheck(cross) : d.timeNearest(all, task.k, mask); };
                double ms[2];
                gains.push_back(medianRatio([&] { return time(theirCross, theirs); },
                                            [&] { return time(ourCross, ours); }, settings.turns, ms));
                table.add({task.name, std::to_string(n), std::to_string(threads), cell(ms[0], 3),
                           cell(ms[1], 3), cell(gains.back(), 1)});
            }
            table.add({task.name, "geometric mean", std::to_string(threads), "", "",
                       cell(geometricMean(gains), 1)});
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
                times[2].push_back(d.timeNearest(all, 2));
            }
            table.add({"64 bytes", std::to_string(n), std::to_string(threads), cell(median(times[0]), 3),
                       cell(median(times[1]), 3), cell(median(times[2]), 3)});
        }
    }
    std::cout << table.text() << std::flush;
}
