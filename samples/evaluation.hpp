// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// How aqorb_demo.cpp judges detectors: by the matches between two images of a plane, and by time.

#ifndef AQORB_SAMPLES_EVALUATION_HPP
#define AQORB_SAMPLES_EVALUATION_HPP

#include <opencv2/aqorb/features.hpp>
#include <opencv2/aqorb/geometry.hpp>

#include <algorithm>
#include <vector>

//! The features of one image.
struct Features
{
    std::vector<cv::KeyPoint> keypoints;
    cv::Mat descriptors;
};

//! Mutual nearest neighbours, the best first.
inline std::vector<cv::DMatch> matchFeatures(const Features& a, const Features& b, int normType)
{
    std::vector<cv::DMatch> matches;
    if (!a.descriptors.empty() && !b.descriptors.empty())
        cv::BFMatcher(normType, true).match(a.descriptors, b.descriptors, matches);
    std::stable_sort(matches.begin(), matches.end());
    return matches;
}

//! The positions of matches in both images.
inline void matchedPoints(const Features& a, const Features& b, const std::vector<cv::DMatch>& matches,
                          std::vector<cv::Point2f>& from, std::vector<cv::Point2f>& to)
{
    for (const cv::DMatch& match : matches)
    {
        from.push_back(a.keypoints[match.queryIdx].pt);
        to.push_back(b.keypoints[match.trainIdx].pt);
    }
}

//! The homography from the first image to the second; empty where the matches give none.
inline cv::Mat estimateHomography(const Features& a, const Features& b,
                                  const std::vector<cv::DMatch>& matches)
{
    std::vector<cv::Point2f> from, to;
    matchedPoints(a, b, matches, from, to);
    if (matches.size() < 4)
        return cv::Mat();
    return cv::findHomography(from, to, cv::USAC_MAGSAC, 3, cv::noArray(), 10000, 0.9999);
}

/** The matches within 3 pixels of the homography, each at least 4 pixels away from every better one in
 both images: several keypoints on one corner of the scene say no more about it than one. */
inline std::vector<cv::DMatch> distinctCorrect(const Features& a, const Features& b,
                                               const std::vector<cv::DMatch>& matches,
                                               const cv::Mat& homography)
{
    std::vector<cv::DMatch> distinct;
    if (matches.empty() || homography.empty())
        return distinct;
    std::vector<cv::Point2f> from, to, mapped;
    matchedPoints(a, b, matches, from, to);
    cv::perspectiveTransform(from, mapped, homography);
    std::vector<size_t> kept;
    for (size_t i = 0; i < matches.size(); i++)
    {
        const auto isNear = [&](size_t k)
        { return cv::norm(from[i] - from[k]) < 4 || cv::norm(to[i] - to[k]) < 4; };
        if (cv::norm(mapped[i] - to[i]) > 3 || std::any_of(kept.begin(), kept.end(), isNear))
            continue;
        kept.push_back(i);
        distinct.push_back(matches[i]);
    }
    return distinct;
}

//! How far apart two homographies map the corners of an image, on average; in pixels.
inline double cornerError(const cv::Mat& a, const cv::Mat& b, cv::Size size)
{
    const float right = float(size.width - 1), bottom = float(size.height - 1);
    const std::vector<cv::Point2f> corners = {{0, 0}, {right, 0}, {right, bottom}, {0, bottom}};
    std::vector<cv::Point2f> cornersA, cornersB;
    cv::perspectiveTransform(corners, cornersA, a);
    cv::perspectiveTransform(corners, cornersB, b);
    double sum = 0;
    for (size_t i = 0; i < corners.size(); i++)
        sum += cv::norm(cornersA[i] - cornersB[i]);
    return sum / corners.size();
}

//! Median times of detectAndCompute in ms. The detectors take turns, so that other load slows all of them.
inline std::vector<double> medianTimes(const std::vector<cv::Ptr<cv::ORB>>& detectors, const cv::Mat& image,
                                       int repeats = 31)
{
    std::vector<std::vector<double>> times(detectors.size());
    for (int i = 0; i < repeats * int(detectors.size()); i++)
    {
        const size_t turn = i % detectors.size();
        Features features;
        const int64 start = cv::getTickCount();
        detectors[turn]->detectAndCompute(image, cv::noArray(), features.keypoints, features.descriptors);
        times[turn].push_back(1e3 * (cv::getTickCount() - start) / cv::getTickFrequency());
    }
    std::vector<double> medians;
    for (std::vector<double>& all : times)
    {
        std::sort(all.begin(), all.end());
        medians.push_back(all[all.size() / 2]);
    }
    return medians;
}

#endif
