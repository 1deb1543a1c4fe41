// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// Stereo visual odometry from frame to frame, on sequences in KITTI's layout. It compares detectors, and shows the
// effect of growMatches. It matches the points of a rectified pair along the rows, and then with the points of the
// frame before. PnP finds the motion that projects the points of one frame onto their matches in the next.

#include "sample.hpp"

#include <opencv2/aqorb.hpp>
#include <opencv2/core/affine.hpp>

#include <fstream>

using namespace cv;

namespace
{

const char* const ABOUT =
    "Stereo visual odometry with cv::ORB, with cv::aqorb::AdaptiveQuadtreeORB, and with this and\n"
    "cv::aqorb::growMatches, on a folder laid out as KITTI's odometry sequences: calib.txt, image_0 and\n"
    "image_1 (or image_l and image_r) and, for the error, poses.txt. Prints a table, and draws the features\n"
    "tracked into the last frame.";

const char* const KEYS = "{help      |                     | print this text }"
                         "{nfeatures | 1000                | number of keypoints to ask for }"
                         "{out       | stereo_odometry.jpg | picture to write }"
                         "{@folder   |                     | a sequence as KITTI's }";

//! A sequence of rectified image pairs.
struct Sequence
{
    std::vector<String> left, right;  // files
    std::vector<Affine3d> poses;      // from the left camera to the world; empty if unknown
    Matx33d camera;
    double baseline;  // in metres
};

//! Features of the left image with a depth from the right image.
struct Frame
{
    Mat image;
    std::vector<KeyPoint> keypoints;
    Mat descriptors;
    std::vector<Point3d> points;  // in coordinates of the left camera, metres
};

//! The path of a camera by one detector.
struct Odometry
{
    Odometry(const String& name_, const Ptr<ORB>& detector_, bool grows_)
        : name(name_), detector(detector_), grows(grows_)
    {
    }

    String name;
    Ptr<ORB> detector;
    bool grows;                      // whether growMatches refines and adds matches
    Frame frame;                     // last frame
    std::vector<Point2f> from, to;   // inliers of the last motion, in both left images
    std::vector<Affine3d> motions;   // each from a frame's coordinates to those of the frame before
    double depths = 0, inliers = 0;  // sums over the frames
};

//! Reads matrices of 3x4 numbers from a file, one per line, with or without a label such as "P0:".
std::vector<Matx34d> readMatrices(const String& file)
{
    std::vector<Matx34d> matrices;
    std::ifstream words(file);
    for (Matx34d matrix; words;)
    {
        if (std::isalpha(words.peek()))
            words.ignore(100, ':');
        for (double& value : matrix.val)
            words >> value;
        if (words)
            matrices.push_back(matrix);
        words >> std::ws;
    }
    return matrices;
}

Sequence readSequence(const String& folder)
{
    Sequence sequence;
    const std::vector<Matx34d> projections = readMatrices(folder + "/calib.txt");
    if (projections.size() < 2)
        CV_Error(Error::StsObjectNotFound, folder + ": needs calib.txt, with the matrices P0 and P1");
    for (const Matx34d& pose : readMatrices(folder + "/poses.txt"))
        sequence.poses.push_back(Affine3d(pose.get_minor<3, 3>(0, 0), Vec3d(pose.col(3).val)));
    const bool isKitti = utils::fs::exists(folder + "/image_0");
    utils::fs::glob(folder + (isKitti ? "/image_0" : "/image_l"), "*.png", sequence.left);
    utils::fs::glob(folder + (isKitti ? "/image_1" : "/image_r"), "*.png", sequence.right);
    if (sequence.right.size() != sequence.left.size() ||
        (!sequence.poses.empty() && sequence.poses.size() < sequence.left.size()))
        CV_Error(Error::StsObjectNotFound,
                 folder + ": needs as many images of both cameras, and as many poses");
    sequence.camera = projections[0].get_minor<3, 3>(0, 0);
    sequence.baseline = (projections[0](0, 3) - projections[1](0, 3)) / projections[0](0, 0);
    return sequence;
}

//! Positions of matches. growMatches refines these, and appends matches and their keypoints.
void positions(bool grows, Frame& frame1, Frame& frame2, std::vector<DMatch>& matches,
               std::vector<Point2f>& points1, std::vector<Point2f>& points2, bool bothWays)
{
    std::vector<float> deviations;
    if (grows)
        return aqorb::growMatches(frame1.image, frame1.keypoints, frame2.image, frame2.keypoints, matches,
                                  frame1.keypoints, frame2.keypoints, points1, points2, deviations, 0.8f, 1,
                                  bothWays);
    for (const DMatch& match : matches)
    {
        points1.push_back(frame1.keypoints[match.queryIdx].pt);
        points2.push_back(frame2.keypoints[match.trainIdx].pt);
    }
}

Frame detect(const Ptr<ORB>& detector, const Mat& image)
{
    Frame frame;
    frame.image = image;
    detector->detectAndCompute(image, noArray(), frame.keypoints, frame.descriptors);
    return frame;
}

/** Features of the left image with a mutually best match in the right image, within some rows and at most MAX_DISPARITY
 pixels further left; then grown ones, which have no descriptor. */
Frame stereoFrame(Odometry& odometry, const Mat& left, const Mat& right, const Sequence& sequence)
{
    const float ROWS = 3, MIN_DISPARITY = 0.5f, MAX_DISPARITY = 200;
    Frame leftFrame = detect(odometry.detector, left), rightFrame = detect(odometry.detector, right), frame;
    std::vector<Point2f> predicted, pointsLeft, pointsRight;
    for (const KeyPoint& keypoint : leftFrame.keypoints)
        predicted.push_back(keypoint.pt - Point2f((MIN_DISPARITY + MAX_DISPARITY) / 2, 0));
    const Size2f reach((MAX_DISPARITY - MIN_DISPARITY) / 2, ROWS);
    Mat pairs, distances;
    aqorb::matchByPosition(leftFrame.descriptors, predicted, rightFrame.descriptors, rightFrame.keypoints,
                           reach, pairs, distances, 0, true);
    std::vector<DMatch> matches;
    for (int i = 0; i < pairs.rows; i++)
        matches.emplace_back(pairs.at<int>(i, 0), pairs.at<int>(i, 1), 0.f);
    positions(odometry.grows, leftFrame, rightFrame, matches, pointsLeft, pointsRight, true);

    frame.image = left;
    const Matx33d& k = sequence.camera;
    for (size_t i = 0; i < matches.size(); i++)
    {
        const int query = matches[i].queryIdx;
        const Point2f p = pointsLeft[i], disparity = p - pointsRight[i];
        if (disparity.x < MIN_DISPARITY)
            continue;
        const double depth = k(0, 0) * sequence.baseline / disparity.x;
        frame.keypoints.push_back(leftFrame.keypoints[query]);
        if (query < leftFrame.descriptors.rows)
            frame.descriptors.push_back(leftFrame.descriptors.row(query));
        frame.points.emplace_back((p.x - k(0, 2)) * depth / k(0, 0), (p.y - k(1, 2)) * depth / k(1, 1),
                                  depth);
    }
    odometry.depths += double(frame.points.size());
    return frame;
}

//! Motion from the last frame to the next: PnP with RANSAC, refined on the inliers. Too few matches repeat the last one.
Affine3d estimateMotion(Odometry& odometry, Frame next, const Matx33d& camera)
{
    const float THRESHOLD = odometry.grows ? 0.5f : 1.5f;  // pixels; 1.5 is best for cv::ORB
    Frame& last = odometry.frame;
    std::vector<DMatch> matches;  // mutual nearest neighbours
    if (!last.descriptors.empty() && !next.descriptors.empty())
        aqorb::HammingMatcher(NORM_HAMMING, true).match(last.descriptors, next.descriptors, matches);
    std::vector<Point2f> from, to;
    positions(odometry.grows, last, next, matches, from, to, false);  // only the last frame's have a depth
    std::vector<Point3d> points, inlierPoints;
    for (const DMatch& match : matches)
        points.push_back(last.points[match.queryIdx]);
    odometry.from.clear();
    odometry.to.clear();
    Vec3d rotation, translation;
    std::vector<int> inliers;
    if (matches.size() < 6 ||
        !solvePnPRansac(points, to, camera, noArray(), rotation, translation, false, 1000, THRESHOLD, 0.9999,
                        inliers, SOLVEPNP_P3P) ||
        inliers.size() < 6)
        return odometry.motions.empty() ? Affine3d() : odometry.motions.back();
    for (int i : inliers)
    {
        inlierPoints.push_back(points[i]);
        odometry.from.push_back(from[i]);
        odometry.to.push_back(to[i]);
    }
    odometry.inliers += double(inliers.size());
    solvePnPRefineLM(inlierPoints, odometry.to, camera, noArray(), rotation, translation);
    return Affine3d(rotation, translation).inv();
}

//! Error of the translation over `step` frames, in per cent of the path.
double translationError(const std::vector<Affine3d>& motions, const std::vector<Affine3d>& truth, size_t step)
{
    std::vector<Affine3d> path(1);
    for (const Affine3d& motion : motions)
        path.push_back(path.back() * motion);
    double sum = 0;
    size_t first = 0;
    for (; first + step < path.size(); first++)
    {
        double length = 0;
        for (size_t i = first; i < first + step; i++)
            length += norm(truth[i + 1].translation() - truth[i].translation());
        const Affine3d motion = path[first].inv() * path[first + step];
        const Affine3d trueMotion = truth[first].inv() * truth[first + step];
        sum += 100 * norm((trueMotion.inv() * motion).translation()) / std::max(length, 1e-6);
    }
    return sum / std::max(double(first), 1.);
}

//! The left image with the tracked features: each has a line from its position in the frame before.
Mat trackPicture(const Odometry& odometry)
{
    Mat picture;
    cvtColor(odometry.frame.image, picture, COLOR_GRAY2BGR);
    for (size_t i = 0; i < odometry.to.size(); i++)
    {
        line(picture, odometry.from[i], odometry.to[i], Scalar(40, 200, 40), 1, LINE_AA);
        circle(picture, odometry.to[i], 2, Scalar(40, 200, 40), FILLED, LINE_AA);
    }
    return captioned(picture, odometry.name + format(": %d inliers", int(odometry.to.size())));
}

int stereoOdometry(int argc, char** argv)
{
    const CommandLineParser parser = parseOptions(argc, argv, KEYS, ABOUT);
    const String out = pictureOption(parser);
    const String folder = option<String>(parser, "@folder");
    const int nfeatures = option<int>(parser, "nfeatures");
    if (folder.empty())
        CV_Error(Error::StsBadArg, "the folder of a sequence is needed; --help says what it has");
    const Sequence sequence = readSequence(folder);
    const Ptr<ORB> ours = aqorb::AdaptiveQuadtreeORB::create(nfeatures);
    std::vector<Odometry> odometries = {Odometry("cv::ORB", ORB::create(nfeatures), false),
                                        Odometry("AdaptiveQuadtreeORB", ours, false),
                                        Odometry("with growMatches", ours, true)};
    for (size_t i = 0; i < sequence.left.size(); i++)
    {
        const Mat left = readImage(sequence.left[i]), right = readImage(sequence.right[i]);
        for (Odometry& odometry : odometries)
        {
            const Frame frame = stereoFrame(odometry, left, right, sequence);
            if (i > 0)
                odometry.motions.push_back(estimateMotion(odometry, frame, sequence.camera));
            odometry.frame = frame;
        }
    }

    const double frames = double(sequence.left.size()), motions = std::max(frames - 1, 1.);
    std::vector<std::vector<String>> columns = {{format("%d frames", int(frames)),
                                                 "keypoints of the left image with a depth",
                                                 "inliers of the motion, mean"}};
    if (!sequence.poses.empty())
        columns[0].push_back("translation error over 10 frames, of the path");
    std::vector<Mat> tracks;
    for (const Odometry& each : odometries)
    {
        columns.push_back(
            {each.name, format("%.0f", each.depths / frames), format("%.0f", each.inliers / motions)});
        if (!sequence.poses.empty())
            columns.back().push_back(format("%.2f %%", translationError(each.motions, sequence.poses, 10)));
        tracks.push_back(trackPicture(each));
    }
    printTable(columns);
    Mat picture;
    vconcat(tracks, picture);
    writePicture(out, picture);
    return 0;
}

}  // namespace

int main(int argc, char** argv)
{
    return runSample(stereoOdometry, argc, argv);
}
