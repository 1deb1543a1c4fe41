// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "homography.hpp"

#include <opencv2/imgproc.hpp>

#include <algorithm>
#include <cmath>

namespace
{

const double DISTANCE = 3;  // pixels, as in tools/evaluate
const int MOST_SAMPLES = 2000;
const double CONFIDENCE = 0.999;
const size_t FEWEST = 10;

std::vector<size_t> agreeing(const cv::Matx33d& homography, const std::vector<cv::Point2f>& from,
                             const std::vector<cv::Point2f>& to)
{
    std::vector<size_t> result;
    for (size_t i = 0; i < from.size(); i++)
    {
        if (agrees(homography, from[i], to[i], DISTANCE))
            result.push_back(i);
    }
    return result;
}

//! Twice the area of a triangle, with the sign of its orientation.
double area(const cv::Point2f& a, const cv::Point2f& b, const cv::Point2f& c)
{
    return double(b.x - a.x) * double(c.y - a.y) - double(c.x - a.x) * double(b.y - a.y);
}

/** Whether four pairs of points can be four views of the same plane from its front: no three of them are nearly on a
 line, and each triangle keeps its orientation. */
bool isPlausible(const cv::Point2f (&from)[4], const cv::Point2f (&to)[4])
{
    const double SMALLEST = 50;  // square pixels
    for (int i = 0; i < 4; i++)
    {
        const int j = (i + 1) % 4, k = (i + 2) % 4;
        const double a = area(from[i], from[j], from[k]), b = area(to[i], to[j], to[k]);
        if (std::abs(a) < SMALLEST || std::abs(b) < SMALLEST || (a > 0) != (b > 0))
            return false;
    }
    return true;
}

//! Moves the points' mean to the origin and makes their mean distance from it the square root of 2.
cv::Matx33d normalization(const std::vector<cv::Point2f>& points, const std::vector<size_t>& chosen)
{
    cv::Point2d mean(0, 0);
    for (const size_t i : chosen)
        mean += cv::Point2d(points[i]) / double(chosen.size());
    double distance = 0;
    for (const size_t i : chosen)
        distance += cv::norm(cv::Point2d(points[i]) - mean) / double(chosen.size());
    const double scale = std::sqrt(2.) / std::max(distance, 1e-9);
    return cv::Matx33d(scale, 0, -scale * mean.x, 0, scale, -scale * mean.y, 0, 0, 1);
}

//! The normalized direct linear transformation of the chosen pairs.
cv::Matx33d leastSquares(const std::vector<cv::Point2f>& from, const std::vector<cv::Point2f>& to,
                         const std::vector<size_t>& chosen)
{
    const cv::Matx33d ofFrom = normalization(from, chosen), ofTo = normalization(to, chosen);
    cv::Matx<double, 9, 9> sum = cv::Matx<double, 9, 9>::zeros();
    for (const size_t i : chosen)
    {
        const cv::Vec3d a = ofFrom * cv::Vec3d(from[i].x, from[i].y, 1),
                        b = ofTo * cv::Vec3d(to[i].x, to[i].y, 1);
        const cv::Vec<double, 9> x(a[0], a[1], 1, 0, 0, 0, -b[0] * a[0], -b[0] * a[1], -b[0]);
        const cv::Vec<double, 9> y(0, 0, 0, a[0], a[1], 1, -b[1] * a[0], -b[1] * a[1], -b[1]);
        sum += x * x.t() + y * y.t();
    }
    cv::Mat values, vectors;
    cv::eigen(sum, values, vectors);  // the largest value first
    const cv::Matx33d normalized(vectors.ptr<double>(8));
    const cv::Matx33d homography = ofTo.inv() * normalized * ofFrom;
    return homography * (1 / homography(2, 2));
}

}  // namespace

bool agrees(const cv::Matx33d& homography, const cv::Point2f& from, const cv::Point2f& to, double distance)
{
    const cv::Vec3d mapped = homography * cv::Vec3d(from.x, from.y, 1);
    const cv::Point2d error(mapped[0] / mapped[2] - to.x, mapped[1] / mapped[2] - to.y);
    return mapped[2] > 0 && error.dot(error) <= distance * distance;
}

bool findHomography(const std::vector<cv::Point2f>& from, const std::vector<cv::Point2f>& to,
                    cv::Matx33d& homography)
{
    const int count = int(from.size());
    std::vector<size_t> best;
    cv::RNG rng(4);
    double samples = MOST_SAMPLES;
    for (int sample = 0; sample < samples && count >= 4; sample++)
    {
        cv::Point2f a[4], b[4];
        for (int i = 0; i < 4; i++)
        {
            const int chosen = rng.uniform(0, count);
            a[i] = from[chosen];
            b[i] = to[chosen];
        }
        if (!isPlausible(a, b))
            continue;  // one that holds a pair twice is not, either
        const std::vector<size_t> found = agreeing(cv::Matx33d(cv::getPerspectiveTransform(a, b)), from, to);
        if (found.size() <= best.size())
            continue;
        best = found;
        const double ofOne = std::pow(double(best.size()) / count, 4);
        samples = std::min<double>(MOST_SAMPLES,
                                   10 + std::log(1 - CONFIDENCE) / std::log(1 - std::min(ofOne, 0.999)));
    }
    for (int i = 0; i < 3 && best.size() >= FEWEST; i++)
    {
        homography = leastSquares(from, to, best);
        best = agreeing(homography, from, to);
    }
    return best.size() >= FEWEST;
}
