// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// Stereo visual odometry from frame to frame, on sequences in KITTI's layout. It shows what a detector's features are
// worth for this. Points of a rectified pair are matched along the rows, and then with those of the frame before. The
// motion is the one under which the points of one frame project onto their matches in the next (PnP).

#ifndef AQORB_SAMPLES_STEREO_ODOMETRY_HPP
#define AQORB_SAMPLES_STEREO_ODOMETRY_HPP

#include <opencv2/aqorb/features.hpp>
#include <opencv2/aqorb/matching.hpp>
#include <opencv2/core/utils/filesystem.hpp>
#if CV_VERSION_MAJOR >= 5
#include <opencv2/geometry.hpp>
#else
#include <opencv2/calib3d.hpp>
#endif

#include <algorithm>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

//! A sequence of rectified image pairs.
struct StereoSequence
{
    std::vector<cv::String> left, right;  // files
    std::vector<cv::Matx44d> poses;       // from the left camera to the world; empty where they are not known
    cv::Matx33d camera;
    double baseline;  // in metres
};

//! Features of the left image for which the right one gives a depth.
struct StereoFrame
{
    std::vector<cv::KeyPoint> keypoints;
    cv::Mat descriptors;
    std::vector<cv::Point3d> points;  // in coordinates of the left camera, metres
};

struct StereoMotion
{
    cv::Matx44d motion = cv::Matx44d::eye();  // from coordinates of the later frame to those of the earlier
    int matches = 0, inliers = 0;
    bool found = false;
    std::vector<cv::Point2f> from, to;  // the inliers, in the earlier and the later left image
};

/** Reads calib.txt (P0 and P1, with or without these labels), the folders of images (image_0 and image_1 as
 KITTI's, or image_l and image_r) and, where it is there, poses.txt. */
inline StereoSequence readStereoSequence(const std::string& folder)
{
    const auto readMatrices = [&](const std::string& name)
    {
        std::vector<cv::Matx34d> matrices;
        std::ifstream file(folder + "/" + name);
        for (std::string line; std::getline(file, line);)
        {
            const size_t label = line.find(':');
            std::istringstream numbers(label == std::string::npos ? line : line.substr(label + 1));
            cv::Matx34d matrix;
            int count = 0;
            while (count < 12 && numbers >> matrix.val[count])
                count++;
            if (count == 12)
                matrices.push_back(matrix);
        }
        return matrices;
    };
    const auto images = [&](const std::string& a, const std::string& b)
    {
        std::vector<cv::String> files;
        const std::string path = folder + "/" + (cv::utils::fs::exists(folder + "/" + a) ? a : b);
        if (cv::utils::fs::isDirectory(path))
            cv::glob(path + "/*.png", files);
        return files;
    };

    StereoSequence sequence;
    const std::vector<cv::Matx34d> projections = readMatrices("calib.txt");
    for (const cv::Matx34d& pose : readMatrices("poses.txt"))
    {
        cv::Matx44d rigid = cv::Matx44d::eye();
        std::copy(pose.val, pose.val + 12, rigid.val);
        sequence.poses.push_back(rigid);
    }
    sequence.left = images("image_l", "image_0");
    sequence.right = images("image_r", "image_1");
    if (projections.size() < 2 || sequence.left.empty() || sequence.right.size() != sequence.left.size())
        CV_Error(cv::Error::StsObjectNotFound,
                 folder + ": needs calib.txt and as many images of both cameras");
    if (!sequence.poses.empty() && sequence.poses.size() < sequence.left.size())
        CV_Error(cv::Error::StsObjectNotFound, folder + ": poses.txt has fewer poses than there are images");
    sequence.camera = projections[0].get_minor<3, 3>(0, 0);
    sequence.baseline = (projections[0](0, 3) - projections[1](0, 3)) / projections[0](0, 0);
    return sequence;
}

//! The features of the left image that are in a pair with one of the right image: CV_32SC1, a row for each pair.
inline StereoFrame triangulatePairs(const std::vector<cv::KeyPoint>& left, const cv::Mat& leftDescriptors,
                                    const std::vector<cv::KeyPoint>& right, const cv::Mat& pairs,
                                    const StereoSequence& sequence)
{
    StereoFrame frame;
    const cv::Matx33d& k = sequence.camera;
    for (int i = 0; i < pairs.rows; i++)
    {
        const int index = pairs.at<int>(i, 0);
        const cv::Point2f p = left[index].pt;
        const double depth = k(0, 0) * sequence.baseline / (p.x - right[pairs.at<int>(i, 1)].pt.x);
        frame.keypoints.push_back(left[index]);
        frame.descriptors.push_back(leftDescriptors.row(index));
        frame.points.emplace_back((p.x - k(0, 2)) * depth / k(0, 0), (p.y - k(1, 2)) * depth / k(1, 1),
                                  depth);
    }
    return frame;
}

/** The features of the left image that match one of the right image best, and the other way round, among those within
 some rows and at most maxDisparity pixels further left. */
inline StereoFrame stereoFrame(const std::vector<cv::KeyPoint>& left, const cv::Mat& leftDescriptors,
                               const std::vector<cv::KeyPoint>& right, const cv::Mat& rightDescriptors,
                               int norm, const StereoSequence& sequence, float maxDisparity = 200)
{
    const float ROWS = 3, MIN_DISPARITY = 0.5f;
    std::vector<cv::Point2f> predicted;
    for (const cv::KeyPoint& keypoint : left)
        predicted.push_back(keypoint.pt - cv::Point2f((MIN_DISPARITY + maxDisparity) / 2, 0));
    const cv::Size2f reach((maxDisparity - MIN_DISPARITY) / 2, ROWS);
    cv::Mat pairs, distances;
    cv::aqorb::matchByPosition(leftDescriptors, predicted, rightDescriptors, right, reach, pairs, distances,
                               0, true, -1, norm);
    return triangulatePairs(left, leftDescriptors, right, pairs, sequence);
}

//! Mutual nearest neighbours of the features of two frames, if the matcher checks both directions.
inline std::vector<cv::DMatch> matchFrames(const StereoFrame& earlier, const StereoFrame& later,
                                           const cv::DescriptorMatcher& matcher)
{
    std::vector<cv::DMatch> matches;
    if (!earlier.descriptors.empty() && !later.descriptors.empty())
        matcher.match(earlier.descriptors, later.descriptors, matches);
    return matches;
}

//! The motion between two frames from their matches: PnP with RANSAC, refined on the inliers.
inline StereoMotion estimateMotion(const StereoFrame& earlier, const StereoFrame& later,
                                   const std::vector<cv::DMatch>& matches, const StereoSequence& sequence)
{
    const float THRESHOLD = 2;  // pixels
    StereoMotion result;
    std::vector<cv::Point3d> points;
    std::vector<cv::Point2d> pixels;
    for (const cv::DMatch& match : matches)
    {
        points.push_back(earlier.points[match.queryIdx]);
        pixels.push_back(later.keypoints[match.trainIdx].pt);
    }
    result.matches = int(matches.size());
    if (matches.size() < 6)
        return result;

    cv::Vec3d rotation, translation;
    std::vector<int> inliers;
    if (!cv::solvePnPRansac(points, pixels, sequence.camera, cv::noArray(), rotation, translation, false,
                            1000, THRESHOLD, 0.9999, inliers, cv::SOLVEPNP_P3P) ||
        inliers.size() < 6)
        return result;
    std::vector<cv::Point3d> inlierPoints;
    std::vector<cv::Point2d> inlierPixels;
    for (int i : inliers)
    {
        inlierPoints.push_back(points[i]);
        inlierPixels.push_back(pixels[i]);
        result.from.push_back(earlier.keypoints[matches[i].queryIdx].pt);
        result.to.push_back(later.keypoints[matches[i].trainIdx].pt);
    }
    cv::solvePnPRefineLM(inlierPoints, inlierPixels, sequence.camera, cv::noArray(), rotation, translation);

    cv::Matx33d r;
    cv::Rodrigues(rotation, r);
    const cv::Vec3d t = -(r.t() * translation);
    for (int row = 0; row < 3; row++)
    {
        for (int column = 0; column < 3; column++)
            result.motion(row, column) = r(column, row);
        result.motion(row, 3) = t[row];
    }
    result.inliers = int(inliers.size());
    result.found = true;
    return result;
}

//! The distance between two rigid motions: the length and the angle of what remains of one after undoing the other.
inline void motionError(const cv::Matx44d& estimate, const cv::Matx44d& truth, double& metres,
                        double& degrees)
{
    const cv::Matx44d rest = truth.inv() * estimate;
    metres = cv::norm(cv::Vec3d(rest(0, 3), rest(1, 3), rest(2, 3)));
    cv::Vec3d rotation;
    cv::Rodrigues(rest.get_minor<3, 3>(0, 0), rotation);
    degrees = cv::norm(rotation) * 180 / CV_PI;
}

#endif
