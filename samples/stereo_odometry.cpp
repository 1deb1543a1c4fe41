// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// The path of a stereo camera from the features of AdaptiveQuadtreeORB, and from those of cv::ORB.

#include "stereo_odometry.hpp"
#include "sample.hpp"

#include <opencv2/aqorb.hpp>
#include <opencv2/imgproc.hpp>

using namespace cv;

namespace
{

const char* const ABOUT =
    "Stereo visual odometry with cv::aqorb::AdaptiveQuadtreeORB and with cv::ORB, on a folder laid out as "
    "KITTI's\n"
    "odometry sequences: calib.txt, image_0 and image_1 (or image_l and image_r) and, for the errors, "
    "poses.txt.\n"
    "Prints a table, and writes the paths and the features tracked into the last frame to a picture.";

const char* const KEYS = "{help      |                     | print this text }"
                         "{nfeatures | 1000                | number of keypoints to ask for }"
                         "{out       | stereo_odometry.jpg | picture to write }"
                         "{@folder   |                     | a sequence as KITTI's }";

struct Odometry
{
    Odometry(const char* name_, const Ptr<ORB>& detector_, const Scalar& colour_)
        : name(name_), detector(detector_), colour(colour_)
    {
    }

    const char* name;
    Ptr<ORB> detector;
    Scalar colour;
    StereoFrame frame;
    StereoMotion motion;                            // to the last frame
    std::vector<Matx44d> poses;                     // of the left camera, from the first frame's on
    double keypoints = 0, depths = 0, inliers = 0;  // sums over the frames
};

void track(Odometry& odometry, const Mat& left, const Mat& right, const StereoSequence& sequence)
{
    std::vector<KeyPoint> keypointsLeft, keypointsRight;
    Mat descriptorsLeft, descriptorsRight;
    odometry.detector->detectAndCompute(left, noArray(), keypointsLeft, descriptorsLeft);
    odometry.detector->detectAndCompute(right, noArray(), keypointsRight, descriptorsRight);
    const int norm = odometry.detector->defaultNorm();
    const StereoFrame frame =
        stereoFrame(keypointsLeft, descriptorsLeft, keypointsRight, descriptorsRight, norm, sequence);
    odometry.keypoints += double(keypointsLeft.size());
    odometry.depths += double(frame.keypoints.size());
    if (odometry.poses.empty())
    {
        odometry.poses.push_back(Matx44d::eye());
    }
    else
    {
        const Matx44d before = odometry.motion.motion;
        // The matches of BFMatcher(norm, true).
        odometry.motion =
            estimateMotion(odometry.frame, frame,
                           matchFrames(odometry.frame, frame, aqorb::HammingMatcher(norm, true)), sequence);
        if (!odometry.motion.found)
            odometry.motion.motion = before;  // the camera goes on as it did
        odometry.inliers += odometry.motion.inliers;
        odometry.poses.push_back(odometry.poses.back() * odometry.motion.motion);
    }
    odometry.frame = frame;
}

double pathLength(const std::vector<Matx44d>& poses, size_t first, size_t last)
{
    double length = 0;
    for (size_t i = first; i < last; i++)
        length += norm(Vec3d(poses[i + 1](0, 3) - poses[i](0, 3), poses[i + 1](1, 3) - poses[i](1, 3),
                             poses[i + 1](2, 3) - poses[i](2, 3)));
    return length;
}

//! The error of the motion over `step` frames, in per cent of the path.
double translationError(const std::vector<Matx44d>& poses, const std::vector<Matx44d>& truth, size_t step)
{
    double sum = 0, metres, degrees;
    size_t count = 0;
    for (; count + step < poses.size(); count++)
    {
        motionError(poses[count].inv() * poses[count + step], truth[count].inv() * truth[count + step],
                    metres, degrees);
        sum += 100 * metres / std::max(pathLength(truth, count, count + step), 1e-6);
    }
    return sum / std::max(double(count), 1.);
}

void printTable(const std::vector<Odometry>& odometries, const StereoSequence& sequence)
{
    const double frames = double(odometries[0].poses.size()), motions = std::max(frames - 1, 1.);
    const size_t STEP = 10;
    const auto row = [&](const char* label, const char* format, double orb, double ours)
    {
        std::printf("%-45s %10s %20s\n", label, cv::format(format, orb).c_str(),
                    cv::format(format, ours).c_str());
    };
    const Odometry &orb = odometries[0], &ours = odometries[1];
    std::printf("%-45s %10s %20s\n", cv::format("%d frames", int(frames)).c_str(), orb.name, ours.name);
    row("keypoints of the left image, mean", "%.0f", orb.keypoints / frames, ours.keypoints / frames);
    row("  of these with a depth", "%.0f", orb.depths / frames, ours.depths / frames);
    row("inliers of the motion, mean", "%.0f", orb.inliers / motions, ours.inliers / motions);
    row("length of the path", "%.2f m", pathLength(orb.poses, 0, orb.poses.size() - 1),
        pathLength(ours.poses, 0, ours.poses.size() - 1));
    if (sequence.poses.empty())
        return;
    std::printf("  by poses.txt: %.2f m\n", pathLength(sequence.poses, 0, orb.poses.size() - 1));
    row("translation error over 10 frames, of the path", "%.2f %%",
        translationError(orb.poses, sequence.poses, STEP),
        translationError(ours.poses, sequence.poses, STEP));
}

// The left image with the tracked features: a line from where each was in the frame before.
Mat trackPicture(const Odometry& odometry, const Mat& left)
{
    Mat picture;
    cvtColor(left, picture, COLOR_GRAY2BGR);
    for (size_t i = 0; i < odometry.motion.to.size(); i++)
    {
        line(picture, odometry.motion.from[i], odometry.motion.to[i], odometry.colour, 1, LINE_AA);
        circle(picture, odometry.motion.to[i], 2, odometry.colour, FILLED, LINE_AA);
    }
    copyMakeBorder(picture, picture, 40, 0, 0, 0, BORDER_CONSTANT, Scalar::all(255));
    putText(picture, format("%s: %d inliers", odometry.name, odometry.motion.inliers), Point(12, 28),
            FONT_HERSHEY_SIMPLEX, 0.75, odometry.colour, 1, LINE_AA);
    return picture;
}

// The paths from above: x to the right, z (ahead) to the top.
Mat pathPicture(const std::vector<std::vector<Matx44d>>& paths, const std::vector<Scalar>& colours, Size size)
{
    std::vector<Mat> lines;
    std::vector<Point2f> all;
    for (const std::vector<Matx44d>& path : paths)
    {
        std::vector<Point2f> line;
        for (const Matx44d& pose : path)
            line.push_back(Point2f(float(pose(0, 3)), float(-pose(2, 3))));
        lines.push_back(Mat(line, true));
        all.insert(all.end(), line.begin(), line.end());
    }
    const Rect box = boundingRect(all);  // in metres
    const Scalar centre(box.x + box.width / 2., box.y + box.height / 2.);
    const double scale =
        std::min((size.width - 60.) / (box.width + 10), (size.height - 60.) / (box.height + 10));
    Mat picture(size, CV_8UC3, Scalar::all(255));
    for (size_t i = 0; i < lines.size(); i++)
    {
        Mat pixels = (lines[i] - centre) * scale + Scalar(size.width / 2., size.height / 2.);
        pixels.convertTo(pixels, CV_32S);
        polylines(picture, pixels, false, colours[i], 2, LINE_AA);
    }
    const Point start(10, size.height - 10);
    line(picture, start, start + Point(cvRound(10 * scale), 0), Scalar::all(0), 2);
    putText(picture, "10 m; grey: poses.txt", start - Point(0, 8), FONT_HERSHEY_SIMPLEX, 0.5, Scalar::all(0),
            1, LINE_AA);
    return picture;
}

Mat drawAll(const std::vector<Odometry>& odometries, const StereoSequence& sequence, const Mat& left)
{
    std::vector<std::vector<Matx44d>> paths;
    std::vector<Scalar> colours;
    if (!sequence.poses.empty())
    {
        paths.push_back({});
        for (size_t i = 0; i < odometries[0].poses.size(); i++)
            paths[0].push_back(sequence.poses[0].inv() * sequence.poses[i]);
        colours.push_back(Scalar::all(160));
    }
    Mat tracks, picture;
    for (const Odometry& odometry : odometries)
    {
        paths.push_back(odometry.poses);
        colours.push_back(odometry.colour);
        const Mat one = trackPicture(odometry, left);
        if (tracks.empty())
            tracks = one;
        else
            vconcat(tracks, one, tracks);
    }
    hconcat(tracks, pathPicture(paths, colours, Size(tracks.rows / 2, tracks.rows)), picture);
    return picture;
}

int stereoOdometry(int argc, char** argv)
{
    const CommandLineParser parser = parseOptions(argc, argv, KEYS, ABOUT);
    const String folder = option<String>(parser, "@folder");
    const int nfeatures = option<int>(parser, "nfeatures");
    if (folder.empty())
        CV_Error(Error::StsBadArg, "the folder of a sequence is needed; --help says what it has");
    const StereoSequence sequence = readStereoSequence(folder);
    std::vector<Odometry> odometries = {
        Odometry("cv::ORB", ORB::create(nfeatures), Scalar(60, 60, 230)),
        Odometry("AdaptiveQuadtreeORB", aqorb::AdaptiveQuadtreeORB::create(nfeatures), Scalar(40, 200, 40))};
    Mat left;
    for (size_t i = 0; i < sequence.left.size(); i++)
    {
        left = readImage(sequence.left[i]);
        const Mat right = readImage(sequence.right[i]);
        if (left.size() != right.size())
            CV_Error(Error::StsUnmatchedSizes,
                     sequence.left[i] + ": the image of the right camera has another size");
        for (Odometry& odometry : odometries)
            track(odometry, left, right, sequence);
    }
    printTable(odometries, sequence);
    writePicture(option<String>(parser, "out"), drawAll(odometries, sequence, left));
    return 0;
}

}  // namespace

int main(int argc, char** argv)
{
    return runSample(stereoOdometry, argc, argv);
}
