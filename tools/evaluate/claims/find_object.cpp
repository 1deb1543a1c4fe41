// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "../../../test/geometry.hpp"
#include "subjects.hpp"

#include <opencv2/aqorb/features.hpp>

// The same as OpenCV's sample find_obj.py with its brute-force matcher.
void measureFindObject(const cv::Mat& object, const cv::Mat& scene, Method& method, int n,
                       Measurements& results)
{
    const Features a = method.compute(object, n), b = method.compute(scene, n);
    std::vector<std::vector<cv::DMatch>> twoBest;
    if (!a.descriptors.empty() && !b.descriptors.empty())
        opencv_test::makeMatcher(method.norm(), false)->knnMatch(a.descriptors, b.descriptors, twoBest, 2);
    std::vector<cv::Point2f> from, to;
    for (const std::vector<cv::DMatch>& best : twoBest)
    {
        if (best.size() < 2 || best[0].distance >= 0.75f * best[1].distance)
            continue;
        from.push_back(a.keypoints[best[0].queryIdx].pt);
        to.push_back(b.keypoints[best[0].trainIdx].pt);
    }
    cv::Mat inliers;
    if (from.size() >= 4)
        cv::findHomography(from, to, cv::RANSAC, 5, inliers);
    results.add({"object", "box", method.name, n, "matches", double(from.size())});
    results.add({"object", "box", method.name, n, "inliers",
                 inliers.empty() ? 0. : double(cv::countNonZero(inliers))});
}
