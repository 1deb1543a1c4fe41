// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "stereo_odometry.hpp"

#include <numeric>

StereoSequence readPosedSequence(const std::string& folder)
{
    const StereoSequence sequence = readStereoSequence(folder);
    if (sequence.poses.empty())
        CV_Error(cv::Error::StsObjectNotFound, folder + ": needs poses.txt with a pose for each image pair");
    return sequence;
}

// As the sample does, but for descriptors of any norm, and within more rows for large features, as they are located less
// exactly.
StereoFrame triangulate(const StereoSequence& sequence, const opencv_test::Features& left,
                        const opencv_test::Features& right, int norm)
{
    const float ROWS = 2, ORB_SIZE = 31, MIN_DISPARITY = 0.5f, MAX_DISPARITY = 200;
    const std::vector<cv::KeyPoint>& others = right.keypoints;
    std::vector<int> byRow(others.size());
    std::iota(byRow.begin(), byRow.end(), 0);
    std::sort(byRow.begin(), byRow.end(), [&](int a, int b) { return others[a].pt.y < others[b].pt.y; });

    std::vector<cv::DMatch> bestOfLeft(left.keypoints.size()), bestOfRight(others.size());
    for (int i = 0; i < int(left.keypoints.size()); i++)
    {
        const cv::Point2f p = left.keypoints[i].pt;
        const float rows = ROWS * std::max(1.f, left.keypoints[i].size / ORB_SIZE);
        auto candidate = std::lower_bound(byRow.begin(), byRow.end(), p.y - rows,
                                          [&](int index, float y) { return others[index].pt.y < y; });
        for (; candidate != byRow.end() && others[*candidate].pt.y <= p.y + rows; ++candidate)
        {
            const float disparity = p.x - others[*candidate].pt.x;
            if (disparity < MIN_DISPARITY || disparity > MAX_DISPARITY)
                continue;
            const double distance =
                cv::norm(left.descriptors.row(i), right.descriptors.row(*candidate), norm);
            const cv::DMatch match(i, *candidate, float(distance));
            if (match < bestOfLeft[i])
                bestOfLeft[i] = match;
            if (match < bestOfRight[*candidate])
                bestOfRight[*candidate] = match;
        }
    }
    cv::Mat pairs;
    for (int i = 0; i < int(bestOfLeft.size()); i++)
    {
        const int match = bestOfLeft[i].trainIdx;
        if (match >= 0 && bestOfRight[match].queryIdx == i)
            pairs.push_back(cv::Mat(cv::Matx<int, 1, 2>(i, match)));
    }
    return triangulatePairs(left.keypoints, left.descriptors, others, pairs, sequence);
}

OdometryStep estimateMotion(const StereoSequence& sequence, const StereoFrame& earlier, size_t earlierIndex,
                            const StereoFrame& later, size_t laterIndex, std::vector<cv::DMatch> matches,
                            int seed)
{
    cv::RNG random(seed);
    for (size_t i = matches.size(); seed && i > 1; i--)
        std::swap(matches[i - 1], matches[random.uniform(0, int(i))]);
    const StereoMotion motion = estimateMotion(earlier, later, matches, sequence);
    OdometryStep step;
    step.points = int(later.points.size());
    step.matches = motion.matches;
    step.inliers = motion.inliers;
    step.found = motion.found;
    if (motion.found)
        motionError(motion.motion, sequence.poses[earlierIndex].inv() * sequence.poses[laterIndex],
                    step.metres, step.degrees);
    return step;
}
