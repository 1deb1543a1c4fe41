// This file is part of the aqorb project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.

#include "measures.hpp"

#include <opencv2/aqorb.hpp>

namespace
{

const float CORRECT = 3;  // pixels

std::vector<cv::Point2f> transformed(const Features& features, const cv::Mat& homography)
{
    std::vector<cv::Point2f> points, mapped;
    cv::KeyPoint::convert(features.keypoints, points);
    if (!points.empty())
        cv::perspectiveTransform(points, mapped, homography);
    return mapped;
}

//! The points inside an image: those of a that, mapped, another image shows.
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
    // Those that both images show, in pixels of b.
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
                                     [](const cv::DMatch& pair) { return pair.distance <= CORRECT; });
    return double(found) / double(std::min(pointsA.size(), pointsB.size()));
}

double errorOfEstimate(const std::vector<cv::Point2f>& from, const std::vector<cv::Point2f>& to,
                       const cv::Mat& homography, cv::Size size, int seed)
{
    if (from.size() < 4)
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
    const cv::Mat estimate = cv::findHomography(from, to, cv::noArray(), params);
    if (estimate.empty())
        return NO_HOMOGRAPHY;
    const double error = cornerError(estimate, homography, size);
    return cvIsNaN(error) ? NO_HOMOGRAPHY : std::min(error, NO_HOMOGRAPHY);
}

}  // namespace

double Matching::medianError() const
{
    return median(errors);
}

Matching measureMatching(const Features& a, const Features& b, int norm, const cv::Mat& homography,
                         cv::Size sizeA, cv::Size sizeB, int seeds)
{
    Matching result = {};
    const std::vector<cv::DMatch> matches = matchFeatures(a, b, norm);
    std::vector<cv::Point2f> from, to, mapped;
    matchedPoints(a, b, matches, from, to);
    if (!from.empty())
        cv::perspectiveTransform(from, mapped, homography);
    std::vector<cv::KeyPoint> correct;
    for (size_t i = 0; i < matches.size(); i++)
        if (cv::norm(mapped[i] - to[i]) <= CORRECT)
            correct.push_back(a.keypoints[matches[i].queryIdx]);
    result.matches = int(matches.size());
    result.correct = int(correct.size());
    result.distinct = int(distinctCorrect(a, b, matches, homography).size());
    const cv::Size grid(16, 12);
    result.places = cvRound(cv::aqorb::distributionOccupancy(correct, sizeA, grid) * grid.area());
    result.repeatability = repeatability(a, b, homography, sizeA, sizeB);
    for (int seed = 1; seed <= seeds; seed++)
        result.errors.push_back(errorOfEstimate(from, to, homography, sizeA, seed * 7919));
    return result;
}

double areaUnderCurve(const std::vector<double>& errors, double limit)
{
    double sum = 0;
    for (double error : errors)
        sum += std::max(0., 1 - error / limit);
    return errors.empty() ? 0 : sum / double(errors.size());
}

double median(std::vector<double> values)
{
    if (values.empty())
        return 0;
    std::sort(values.begin(), values.end());
    const size_t half = values.size() / 2;
    return values.size() % 2 ? values[half] : (values[half - 1] + values[half]) / 2;
}
