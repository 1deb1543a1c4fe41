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

struct Method
{
    String name;
    Ptr<ORB> detector;
    bool grows;  // whether growMatches refines and adds matches
};

//! An image and its features. Those of a pair of images have a depth.
struct Frame
{
    Mat image;
    std::vector<KeyPoint> keypoints;
    Mat descriptors;
    std::vector<Point3d> points;  // in coordinates of the left camera, metres
};

//! The path of a camera by one method.
struct Odometry
{
    Affine3d motion;  // from the coordinates of the last frame to those of the frame before
    std::vector<Affine3d> path = {motion};  // from the coordinates of each frame to those of the first
    std::vector<Point2f> from, to;          // inliers of the last motion, in both left images
    double depths = 0, inliers = 0;         // sums over the frames
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
Frame stereoFrame(const Method& method, const Mat& leftImage, const Mat& rightImage, const Sequence& sequence)
{
    const float ROWS = 3, MIN_DISPARITY = 0.5f, MAX_DISPARITY = 200;
    Frame left = detect(method.detector, leftImage), right = detect(method.detector, rightImage), frame;
    std::vector<Point2f> predicted, pointsLeft, pointsRight;
    for (const KeyPoint& keypoint : left.keypoints)
        predicted.push_back(keypoint.pt - Point2f((MIN_DISPARITY + MAX_DISPARITY) / 2, 0));
    const Size2f reach((MAX_DISPARITY - MIN_DISPARITY) / 2, ROWS);
    Mat pairs, distances;
    aqorb::matchByPosition(left.descriptors, predicted, right.descriptors, right.keypoints, reach, pairs,
                           distances, 0, true);
    std::vector<DMatch> matches;
    for (int i = 0; i < pairs.rows; i++)
        matches.emplace_back(pairs.at<int>(i, 0), pairs.at<int>(i, 1), 0.f);
    positions(method.grows, left, right, matches, pointsLeft, pointsRight, true);

    frame.image = leftImage;
    const Matx33d& k = sequence.camera;
    for (size_t i = 0; i < matches.size(); i++)
    {
        const int query = matches[i].queryIdx;
        const Point2f p = pointsLeft[i], disparity = p - pointsRight[i];
        if (disparity.x < MIN_DISPARITY)
            continue;
        const double depth = k(0, 0) * sequence.baseline / disparity.x;
        frame.keypoints.push_back(left.keypoints[query]);
        if (query < left.descriptors.rows)
            frame.descriptors.push_back(left.descriptors.row(query));
        frame.points.emplace_back((p.x - k(0, 2)) * depth / k(0, 0), (p.y - k(1, 2)) * depth / k(1, 1),
                                  depth);
    }
    return frame;
}

//! Adds the motion from the last frame to the next: PnP with RANSAC, refined on the inliers. Where there are too few,
//! the camera goes on as before.
void follow(const Method& method, Frame last, Frame next, const Matx33d& camera, Odometry& odometry)
{
    const float THRESHOLD = method.grows ? 0.5f : 1.5f;  // pixels; 1.5 is best for cv::ORB
    const size_t MIN_MATCHES = 6;
    std::vector<DMatch> matches;  // mutual nearest neighbours
    if (!last.descriptors.empty() && !next.descriptors.empty())
        aqorb::HammingMatcher(NORM_HAMMING, true).match(last.descriptors, next.descriptors, matches);
    std::vector<Point2f> from, to;
    positions(method.grows, last, next, matches, from, to, false);  // only the last frame's have a depth
    std::vector<Point3d> points;
    for (const DMatch& match : matches)
        points.push_back(last.points[match.queryIdx]);
    Vec3d rotation, translation;
    std::vector<int> inliers;
    if (matches.size() >= MIN_MATCHES)
        solvePnPRansac(points, to, camera, noArray(), rotation, translation, false, 1000, THRESHOLD, 0.9999,
                       inliers, SOLVEPNP_P3P);
    std::vector<uchar> agrees(matches.size());
    for (int i : inliers)
        agrees[i] = 1;
    odometry.from = flagged(from, agrees);
    odometry.to = flagged(to, agrees);
    if (inliers.size() >= MIN_MATCHES)
    {
        solvePnPRefineLM(flagged(points, agrees), odometry.to, camera, noArray(), rotation, translation);
        odometry.motion = Affine3d(rotation, translation).inv();
    }
    odometry.path.push_back(odometry.path.back() * odometry.motion);
    odometry.inliers += double(inliers.size());
}

//! Error of the translation over `step` frames, in per cent of the path.
double translationError(const std::vector<Affine3d>& path, const std::vector<Affine3d>& truth, size_t step)
{
    double sum = 0;
    size_t first = 0;
    for (; first + step < std::min(path.size(), truth.size()); first++)
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

//! An image with the tracked features: each has a line from its position in the frame before.
Mat trackPicture(const Mat& image, const Odometry& odometry, const String& name)
{
    Mat picture;
    cvtColor(image, picture, COLOR_GRAY2BGR);
    for (size_t i = 0; i < odometry.to.size(); i++)
    {
        line(picture, odometry.from[i], odometry.to[i], Scalar(40, 200, 40), 1, LINE_AA);
        circle(picture, odometry.to[i], 2, Scalar(40, 200, 40), FILLED, LINE_AA);
    }
    return captioned(picture, name + format(": %d inliers", int(odometry.to.size())));
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
    const Method methods[] = {{"cv::ORB", ORB::create(nfeatures), false},
                              {"AdaptiveQuadtreeORB", ours, false},
                              {"with growMatches", ours, true}};

    const size_t frames = sequence.left.size();
    std::vector<std::vector<String>> columns = {
        {format("%d frames", int(frames)), "keypoints of the left image with a depth",
         "inliers of the motion, mean", "translation error over 10 frames, of the path"}};
    std::vector<Mat> tracks;
    for (const Method& method : methods)
    {
        Odometry odometry;
        Frame last;
        for (size_t i = 0; i < frames; i++)
        {
            const Mat left = readImage(sequence.left[i]), right = readImage(sequence.right[i]);
            const Frame frame = stereoFrame(method, left, right, sequence);
            if (i > 0)
                follow(method, last, frame, sequence.camera, odometry);
            odometry.depths += double(frame.points.size());
            last = frame;
        }
        const double motions = std::max(double(frames) - 1, 1.);
        const double error = translationError(odometry.path, sequence.poses, 10);
        columns.push_back({method.name, format("%.0f", odometry.depths / double(frames)),
                           format("%.0f", odometry.inliers / motions),
                           sequence.poses.empty() ? "no poses.txt" : format("%.2f %%", error)});
        tracks.push_back(trackPicture(last.image, odometry, method.name));
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
