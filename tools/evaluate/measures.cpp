// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "measures.hpp"

#include <opencv2/aqorb.hpp>

#include <algorithm>

using opencv_test::Features;
using opencv_test::Matches;

namespace
{

const float SAME_PLACE = 3;  // pixels between two keypoints that count as one found again

std::vector<cv::Point2f> transformed(const Features& features, const cv::Mat& homography)
{
    std::vector<cv::Point2f> points, mapped;
    cv::KeyPoint::convert(features.keypoints, points);
    if (!points.empty())
        cv::perspectiveTransform(points, mapped, homography);
    return mapped;
}

//! Those of the points that lie inside an image of this size.
std::vector<cv::Point2f> inside(const std::vector<cv::Point2f>& points, cv::Size size)
{
    std::vector<cv::Point2f> result;
    for (const cv::Point2f& p : points)
        if (p.x >= 0 && p.y >= 0 && p.x <= size.width - 1 && p.y <= size.height - 1)
            result.push_back(p);
    return result;
}

double repeatability(const Features& a, const Features& b, const cv::Mat& homography, cv::Size sizeA,
                     cv::Size sizeB)
{
    // The keypoints of each image that the other one shows as well, in pixels of b.
    const std::vector<cv::Point2f> pointsA = inside(transformed(a, homography), sizeB);
    const std::vector<cv::Point2f> shown = inside(transformed(b, homography.inv()), sizeA);
    if (pointsA.empty() || shown.empty())
        return 0;
    std::vector<cv::Point2f> pointsB;
    cv::perspectiveTransform(shown, pointsB, homography);
    // Mutual nearest neighbours, so that none counts twice.
    std::vector<cv::DMatch> pairs;
    cv::BFMatcher(cv::NORM_L2, true).match(cv::Mat(pointsA).reshape(1), cv::Mat(pointsB).reshape(1), pairs);
    const auto found = std::count_if(pairs.begin(), pairs.end(),
                                     [](const cv::DMatch& pair) { return pair.distance <= SAME_PLACE; });
    return double(found) / double(std::min(pointsA.size(), pointsB.size()));
}

}  // namespace

Matching countMatches(const Matches& matches, const std::vector<size_t>& correct, cv::Size sizeA)
{
    Matching result = {};
    std::vector<cv::KeyPoint> found;
    for (const size_t i : correct)
        found.push_back(cv::KeyPoint(matches.from[i], 1));
    result.matches = int(matches.from.size());
    result.correct = int(correct.size());
    result.distinct = int(opencv_test::distinctMatches(matches, correct).size());
    const cv::Size grid(16, 12);
    result.places = cvRound(cv::aqorb::distributionOccupancy(found, sizeA, grid) * grid.area());
    return result;
}

std::vector<double> homographyErrors(const Matches& matches, const cv::Mat& homography, cv::Size sizeA,
                                     int seeds)
{
    std::vector<double> errors;
    for (int seed = 1; seed <= seeds; seed++)
        errors.push_back(opencv_test::homographyError(matches, homography, sizeA, seed * 7919));
    return errors;
}

double areaUnderCurve(const std::vector<double>& errors, double limit)
{
    double sum = 0;
    for (const double error : errors)
        sum += std::max(0., 1 - error / limit);
    return errors.empty() ? 0 : sum / double(errors.size());
}

Matching measureMatching(const Features& a, const Features& b, int norm, const cv::Mat& homography,
                         cv::Size sizeA, cv::Size sizeB, int seeds)
{
    const Matches matches = opencv_test::matchFeatures(a, b, norm);
    Matching result = countMatches(matches, opencv_test::correctMatches(matches, homography), sizeA);
    result.repeatability = repeatability(a, b, homography, sizeA, sizeB);
    result.errors = homographyErrors(matches, homography, sizeA, seeds);
    return result;
}
