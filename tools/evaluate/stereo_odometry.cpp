// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "stereo_odometry.hpp"

#include <opencv2/aqorb/features.hpp>
#include <opencv2/aqorb/geometry.hpp>
#include <opencv2/core/utils/filesystem.hpp>

#include <algorithm>
#include <fstream>
#include <numeric>
#include <sstream>

namespace
{

//! The matrices in a file, one a line; lines without twelve numbers are left out.
std::vector<cv::Matx34d> readMatrices(const std::string& path)
{
    std::vector<cv::Matx34d> matrices;
    std::ifstream file(path);
    for (std::string line; std::getline(file, line);)
    {
        std::istringstream numbers(line.substr(line.find(':') + 1));  // all of it where there is no label
        cv::Matx34d matrix;
        int read = 0;
        while (read < 12 && numbers >> matrix.val[read])
            read++;
        if (read == 12)
            matrices.push_back(matrix);
    }
    return matrices;
}

//! The images in the first of two folders that is there.
std::vector<std::string> listImages(const std::string& folder, const std::string& other)
{
    const std::string path = cv::utils::fs::exists(folder) ? folder : other;
    std::vector<cv::String> files;
    if (cv::utils::fs::isDirectory(path))
        cv::glob(path + "/*.png", files);
    return std::vector<std::string>(files.begin(), files.end());
}

cv::Matx44d rigidMotion(const cv::Matx33d& rotation, const cv::Vec3d& translation)
{
    cv::Matx44d motion = cv::Matx44d::eye();
    for (int row = 0; row < 3; row++)
    {
        for (int column = 0; column < 3; column++)
            motion(row, column) = rotation(row, column);
        motion(row, 3) = translation[row];
    }
    return motion;
}

/** For each feature of the left image its match in the right one, or -1. Both are each other's best among those
 that a rectified pair allows: within two pixels of the row, more for large features, as they are located less
 exactly, and not further apart than the nearest things to be seen. */
std::vector<int> matchAlongRows(const opencv_test::Features& left, const opencv_test::Features& right,
                                int norm)
{
    const float ROWS = 2, ORB_SIZE = 31, MIN_DISPARITY = 0.5f, MAX_DISPARITY = 200;
    std::vector<int> byRow(right.keypoints.size());
    std::iota(byRow.begin(), byRow.end(), 0);
    std::sort(byRow.begin(), byRow.end(),
              [&](int a, int b) { return right.keypoints[a].pt.y < right.keypoints[b].pt.y; });

    std::vector<cv::DMatch> bestOfLeft(left.keypoints.size()), bestOfRight(right.keypoints.size());
    for (int i = 0; i < int(left.keypoints.size()); i++)
    {
        const cv::KeyPoint& keypoint = left.keypoints[i];
        const float rows = ROWS * std::max(1.f, keypoint.size / ORB_SIZE);
        for (const int candidate : byRow)
        {
            const cv::Point2f difference = keypoint.pt - right.keypoints[candidate].pt;
            if (right.keypoints[candidate].pt.y < keypoint.pt.y - rows)
                continue;
            if (right.keypoints[candidate].pt.y > keypoint.pt.y + rows)
                break;
            if (difference.x < MIN_DISPARITY || difference.x > MAX_DISPARITY)
                continue;
            const double distance = cv::norm(left.descriptors.row(i), right.descriptors.row(candidate), norm);
            const cv::DMatch match(i, candidate, float(distance));
            bestOfLeft[i] = std::min(bestOfLeft[i], match);
            bestOfRight[candidate] = std::min(bestOfRight[candidate], match);
        }
    }

    std::vector<int> matches(left.keypoints.size(), -1);
    for (int i = 0; i < int(matches.size()); i++)
    {
        const int match = bestOfLeft[i].trainIdx;
        if (match >= 0 && bestOfRight[match].queryIdx == i)
            matches[i] = match;
    }
    return matches;
}

//! From the coordinates of the later frame to those of the earlier one; false where none is found.
bool solveMotion(const StereoSequence& sequence, const StereoFrame& earlier, const StereoFrame& later,
                 const std::vector<cv::DMatch>& matches, OdometryStep& step, cv::Matx44d& motion)
{
    const size_t FEWEST = 6;
    std::vector<cv::Point3d> points;
    std::vector<cv::Point2d> pixels;
    for (const cv::DMatch& match : matches)
    {
        points.push_back(earlier.points[match.queryIdx]);
        pixels.push_back(later.features.keypoints[match.trainIdx].pt);
    }

    cv::Vec3d rotation, translation;
    std::vector<int> inliers;
    const float THRESHOLD = 2;  // pixels
    if (matches.size() < FEWEST ||
        !cv::solvePnPRansac(points, pixels, sequence.camera, cv::noArray(), rotation, translation, false,
                            1000, THRESHOLD, 0.9999, inliers, cv::SOLVEPNP_P3P) ||
        inliers.size() < FEWEST)
        return false;
    step.inliers = int(inliers.size());
    std::vector<cv::Point3d> inlierPoints;
    std::vector<cv::Point2d> inlierPixels;
    for (const int i : inliers)
    {
        inlierPoints.push_back(points[i]);
        inlierPixels.push_back(pixels[i]);
    }
    cv::solvePnPRefineLM(inlierPoints, inlierPixels, sequence.camera, cv::noArray(), rotation, translation);

    cv::Matx33d toLater;
    cv::Rodrigues(rotation, toLater);
    motion = rigidMotion(toLater.t(), -(toLater.t() * translation));
    return true;
}

}  // namespace

StereoSequence readStereoSequence(const std::string& folder)
{
    StereoSequence sequence;
    sequence.left = listImages(folder + "/image_l", folder + "/image_0");
    sequence.right = listImages(folder + "/image_r", folder + "/image_1");
    for (const cv::Matx34d& pose : readMatrices(folder + "/poses.txt"))
        sequence.poses.push_back(
            rigidMotion(pose.get_minor<3, 3>(0, 0), cv::Vec3d(pose(0, 3), pose(1, 3), pose(2, 3))));
    const std::vector<cv::Matx34d> projections = readMatrices(folder + "/calib.txt");
    if (projections.size() < 2 || sequence.left.empty() || sequence.right.size() != sequence.left.size())
        CV_Error(cv::Error::StsObjectNotFound,
                 folder + ": needs calib.txt and as many images of both cameras");
    if (sequence.poses.size() < sequence.left.size())
        CV_Error(cv::Error::StsObjectNotFound, folder + ": needs poses.txt with a pose for each image pair");
    sequence.camera = projections[0].get_minor<3, 3>(0, 0);
    sequence.baseline = (projections[0](0, 3) - projections[1](0, 3)) / projections[0](0, 0);
    return sequence;
}

StereoFrame triangulate(const StereoSequence& sequence, const opencv_test::Features& left,
                        const opencv_test::Features& right, int norm)
{
    const std::vector<int> matches = matchAlongRows(left, right, norm);
    const cv::Matx33d& k = sequence.camera;
    StereoFrame frame;
    for (size_t i = 0; i < matches.size(); i++)
    {
        if (matches[i] < 0)
            continue;
        const cv::Point2f p = left.keypoints[i].pt;
        const double depth = k(0, 0) * sequence.baseline / (p.x - right.keypoints[matches[i]].pt.x);
        frame.features.keypoints.push_back(left.keypoints[i]);
        frame.features.descriptors.push_back(left.descriptors.row(int(i)));
        frame.points.emplace_back((p.x - k(0, 2)) * depth / k(0, 0), (p.y - k(1, 2)) * depth / k(1, 1),
                                  depth);
    }
    return frame;
}

std::vector<cv::DMatch> matchFrames(const StereoFrame& earlier, const StereoFrame& later, int norm)
{
    std::vector<cv::DMatch> matches;
    if (!earlier.points.empty() && !later.points.empty())
        cv::BFMatcher(norm, true).match(earlier.features.descriptors, later.features.descriptors, matches);
    return matches;
}

OdometryStep estimateMotion(const StereoSequence& sequence, const StereoFrame& earlier, size_t earlierIndex,
                            const StereoFrame& later, size_t laterIndex, std::vector<cv::DMatch> matches,
                            int seed)
{
    cv::RNG random(seed);
    for (size_t i = matches.size(); seed && i > 1; i--)
        std::swap(matches[i - 1], matches[random.uniform(0, int(i))]);
    OdometryStep step;
    step.points = int(later.points.size());
    step.matches = int(matches.size());
    cv::Matx44d motion;
    step.found = solveMotion(sequence, earlier, later, matches, step, motion);
    if (step.found)
    {
        const cv::Matx44d truth = sequence.poses[earlierIndex].inv() * sequence.poses[laterIndex];
        const cv::Matx44d error = truth.inv() * motion;
        cv::Vec3d rotation;
        cv::Rodrigues(error.get_minor<3, 3>(0, 0), rotation);
        step.metres = cv::norm(cv::Vec3d(error(0, 3), error(1, 3), error(2, 3)));
        step.degrees = cv::norm(rotation) * 180 / CV_PI;
    }
    return step;
}
