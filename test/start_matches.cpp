// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "start_matches.hpp"

#include <opencv2/core/hal/hal.hpp>

#include <algorithm>
#include <climits>
#include <cmath>

namespace opencv_test
{

const float WINDOW = 100;  // largest distance along x and y from the place in the reference frame, in pixels
const double RATIO = 0.9;  // of the distances of the nearest and the second nearest descriptor
const int BINS = 30;       // of the histogram of the differences between angles
const int BINS_KEPT = 3;   // those that most matches are in

Features finestLevel(const Features& features)
{
    Features finest;
    for (size_t i = 0; i < features.keypoints.size(); i++)
    {
        if (features.keypoints[i].octave == 0)
        {
            finest.keypoints.push_back(features.keypoints[i]);
            finest.descriptors.push_back(features.descriptors.row(int(i)));
        }
    }
    return finest;
}

//! Index of the bin of the difference between two angles in degrees.
static int angleBin(float from, float to)
{
    const float difference = from - to;
    return cvFloor((difference < 0 ? difference + 360 : difference) * BINS / 360) % BINS;
}

std::vector<PointPair> matchToStart(const Features& reference, const Features& later)
{
    struct Choice
    {
        int from = -1;
        int distance = INT_MAX;
    };
    std::vector<Choice> choices(later.keypoints.size());
    for (int i = 0; i < int(reference.keypoints.size()); i++)
    {
        int nearest = INT_MAX, second = INT_MAX;
        int chosen = -1;
        for (int j = 0; j < int(later.keypoints.size()); j++)
        {
            const cv::Point2f step = later.keypoints[j].pt - reference.keypoints[i].pt;
            if (std::abs(step.x) > WINDOW || std::abs(step.y) > WINDOW)
                continue;
            const int distance = cv::hal::normHamming(reference.descriptors.ptr(i), later.descriptors.ptr(j),
                                                      later.descriptors.cols);
            if (distance < nearest)
            {
                second = nearest;
                nearest = distance;
                chosen = j;
            }
            else
            {
                second = std::min(second, distance);
            }
        }
        if (chosen >= 0 && nearest < RATIO * second && nearest < choices[chosen].distance)
        {
            choices[chosen].from = i;
            choices[chosen].distance = nearest;
        }
    }

    std::vector<PointPair> bins[BINS];
    for (int j = 0; j < int(choices.size()); j++)
    {
        if (choices[j].from >= 0)
        {
            const cv::KeyPoint& from = reference.keypoints[choices[j].from];
            const cv::KeyPoint& to = later.keypoints[j];
            bins[angleBin(from.angle, to.angle)].push_back({from.pt, to.pt});
        }
    }
    std::stable_sort(bins, bins + BINS,
                     [](const std::vector<PointPair>& a, const std::vector<PointPair>& b)
                     { return a.size() > b.size(); });
    std::vector<PointPair> matches;
    for (int i = 0; i < BINS_KEPT; i++)
        matches.insert(matches.end(), bins[i].begin(), bins[i].end());
    return matches;
}

cv::Matx33d fundamentalMatrix(const cv::Matx33d& camera, const cv::Matx44d& motion)
{
    const cv::Vec3d t(motion(0, 3), motion(1, 3), motion(2, 3));
    const cv::Matx33d cross(0, -t[2], t[1], t[2], 0, -t[0], -t[1], t[0], 0);
    return camera.inv().t() * cross * motion.get_minor<3, 3>(0, 0) * camera.inv();
}

bool isOnEpipolarLine(const PointPair& match, const cv::Matx33d& fundamental)
{
    const cv::Vec3d line = fundamental * cv::Vec3d(match.from.x, match.from.y, 1);
    return std::abs(line.dot(cv::Vec3d(match.to.x, match.to.y, 1))) <= 2 * std::hypot(line[0], line[1]);
}

}  // namespace opencv_test
