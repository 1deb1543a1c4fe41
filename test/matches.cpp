// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "matches.hpp"
#include "geometry.hpp"

#include <opencv2/aqorb/matching.hpp>

#ifdef AQORB_HAVE_GEOMETRY

#include <algorithm>
#include <cmath>

namespace opencv_test
{

static std::vector<cv::Point2f> mapped(const std::vector<cv::Point2f>& points, const cv::Mat& homography)
{
    std::vector<cv::Point2f> result;
    if (!points.empty())
        cv::perspectiveTransform(points, result, homography);
    return result;
}

cv::Ptr<cv::BFMatcher> makeMatcher(int norm, bool crossCheck)
{
    if (norm == cv::NORM_HAMMING || norm == cv::NORM_HAMMING2)
        return cv::aqorb::HammingMatcher::create(norm, crossCheck);
    return cv::BFMatcher::create(norm, crossCheck);
}

Matches matchFeatures(const Features& a, const Features& b, int norm)
{
    std::vector<cv::DMatch> matches;
    if (!a.descriptors.empty() && !b.descriptors.empty())
        makeMatcher(norm, true)->match(a.descriptors, b.descriptors, matches);
    std::stable_sort(matches.begin(), matches.end());
    Matches result;
    for (const cv::DMatch& match : matches)
    {
        result.from.push_back(a.keypoints[match.queryIdx].pt);
        result.to.push_back(b.keypoints[match.trainIdx].pt);
    }
    return result;
}

std::vector<size_t> correctMatches(const Matches& matches, const cv::Mat& homography)
{
    const std::vector<cv::Point2f> expected = mapped(matches.from, homography);
    std::vector<size_t> correct;
    for (size_t i = 0; i < expected.size(); i++)
    {
        if (cv::norm(expected[i] - matches.to[i]) <= 3)
            correct.push_back(i);
    }
    return correct;
}

std::vector<size_t> matchesOnEpipolarLines(const Matches& matches, const cv::Mat& fundamental)
{
    const cv::Matx33d f(fundamental);
    std::vector<size_t> agreeing;
    for (size_t i = 0; i < matches.from.size(); i++)
    {
        const cv::Vec3d from(matches.from[i].x, matches.from[i].y, 1),
            to(matches.to[i].x, matches.to[i].y, 1);
        const cv::Vec3d lineOfFrom = f * from, lineOfTo = f.t() * to;
        const double product = std::abs(to.dot(lineOfFrom));
        if (product <=
            3 * std::min(std::hypot(lineOfFrom[0], lineOfFrom[1]), std::hypot(lineOfTo[0], lineOfTo[1])))
            agreeing.push_back(i);
    }
    return agreeing;
}

std::vector<size_t> distinctMatches(const Matches& matches, const std::vector<size_t>& correct)
{
    std::vector<size_t> distinct;
    for (const size_t i : correct)
    {
        const auto isNear = [&](size_t better)
        {
            return cv::norm(matches.from[i] - matches.from[better]) < 4 ||
                   cv::norm(matches.to[i] - matches.to[better]) < 4;
        };
        if (std::none_of(distinct.begin(), distinct.end(), isNear))
            distinct.push_back(i);
    }
    return distinct;
}

std::vector<size_t> distinctCorrectMatches(const Matches& matches, const cv::Mat& homography)
{
    return distinctMatches(matches, correctMatches(matches, homography));
}

double homographyError(const Matches& matches, const cv::Mat& homography, cv::Size size, int seed)
{
    if (matches.from.size() < 4)
        return NO_HOMOGRAPHY;
    cv::UsacParams params;
    params.score = cv::SCORE_METHOD_MAGSAC;
    params.sampler = cv::SAMPLING_UNIFORM;
    params.loMethod = cv::LOCAL_OPTIM_SIGMA;
    params.loIterations = 10;
    params.maxIterations = 5000;
    params.confidence = 0.9999;
    params.threshold = 3;
    params.randomGeneratorState = seed;
    const cv::Mat estimate = cv::findHomography(matches.from, matches.to, cv::noArray(), params);
    if (estimate.empty())
        return NO_HOMOGRAPHY;
    const float right = float(size.width - 1), bottom = float(size.height - 1);
    const std::vector<cv::Point2f> corners = {{0, 0}, {right, 0}, {right, bottom}, {0, bottom}};
    const std::vector<cv::Point2f> estimated = mapped(corners, estimate), known = mapped(corners, homography);
    double sum = 0;
    for (size_t i = 0; i < corners.size(); i++)
        sum += cv::norm(estimated[i] - known[i]);
    const double error = sum / double(corners.size());
    return cvIsNaN(error) ? NO_HOMOGRAPHY : std::min(error, NO_HOMOGRAPHY);
}

}  // namespace opencv_test

#endif
