// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// The path of a stereo camera from the features of AdaptiveQuadtreeORB, and from those of cv::ORB.

#include "stereo_odometry.hpp"

#include <opencv2/aqorb.hpp>
#include <opencv2/core/utility.hpp>
#include <opencv2/highgui.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include <iostream>

using namespace cv;

namespace
{

const char* const KEYS =
    "{help      |                     | print this text }"
    "{nfeatures | 1000                | number of keypoints to ask for }"
    "{show      |                     | show the picture in a window, too, frame by frame }"
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
    StereoMotion motion;         // to the last frame
    std::vector<Matx44d> poses;  // of the left camera, from the first frame's on
    int lost = 0;                // frames whose motion was not found; they repeat the last motion
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
            odometry.motion.motion = before;
        odometry.lost += !odometry.motion.found;
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

struct Errors
{
    double translation;  // of the motion over `step` frames, per cent of the path
    double rotation;     // of the same motion, degrees per 100 m
    double end;          // of the last position, per cent of the path
};

Errors errorsOf(const std::vector<Matx44d>& poses, const std::vector<Matx44d>& truth, size_t step)
{
    Errors errors = {0, 0, 0};
    double metres, degrees;
    int count = 0;
    for (size_t i = 0; i + step < poses.size(); i++, count++)
    {
        const double length = std::max(pathLength(truth, i, i + step), 1e-6);
        motionError(poses[i].inv() * poses[i + step], truth[i].inv() * truth[i + step], metres, degrees);
        errors.translation += 100 * metres / length;
        errors.rotation += 100 * degrees / length;
    }
    errors.translation /= std::max(count, 1);
    errors.rotation /= std::max(count, 1);
    const size_t last = poses.size() - 1;
    motionError(poses[last], truth[0].inv() * truth[last], metres, degrees);
    errors.end = 100 * metres / std::max(pathLength(truth, 0, last), 1e-6);
    return errors;
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
    row("frames whose motion was not found", "%.0f", orb.lost, ours.lost);
    row("length of the path", "%.2f m", pathLength(orb.poses, 0, orb.poses.size() - 1),
        pathLength(ours.poses, 0, ours.poses.size() - 1));
    if (sequence.poses.empty())
        return;
    std::printf("  by poses.txt: %.2f m\n", pathLength(sequence.poses, 0, orb.poses.size() - 1));
    const Errors errorsOrb = errorsOf(orb.poses, sequence.poses, STEP);
    const Errors errorsOurs = errorsOf(ours.poses, sequence.poses, STEP);
    row("translation error over 10 frames, of the path", "%.2f %%", errorsOrb.translation,
        errorsOurs.translation);
    row("rotation error over 10 frames, degrees/100 m", "%.2f", errorsOrb.rotation, errorsOurs.rotation);
    row("error of the last position, of the path", "%.2f %%", errorsOrb.end, errorsOurs.end);
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
    std::vector<std::vector<Point2d>> lines;
    Point2d low(-5, -5), high(5, 5);
    for (const std::vector<Matx44d>& path : paths)
    {
        lines.push_back({});
        for (const Matx44d& pose : path)
        {
            const Point2d p(pose(0, 3), pose(2, 3));
            low = Point2d(std::min(low.x, p.x), std::min(low.y, p.y));
            high = Point2d(std::max(high.x, p.x), std::max(high.y, p.y));
            lines.back().push_back(p);
        }
    }
    const double margin = 20;
    const double scale =
        std::min((size.width - 2 * margin) / (high.x - low.x), (size.height - 4 * margin) / (high.y - low.y));
    const Point2d centre = 0.5 * (low + high);
    Mat picture(size, CV_8UC3, Scalar::all(255));
    for (size_t i = 0; i < lines.size(); i++)
    {
        std::vector<Point> pixels;
        for (const Point2d& p : lines[i])
            pixels.push_back(Point(cvRound(size.width * 0.5 + (p.x - centre.x) * scale),
                                   cvRound(size.height * 0.5 - (p.y - centre.y) * scale)));
        polylines(picture, pixels, false, colours[i], 2, LINE_AA);
    }
    const int metres = 10, length = cvRound(metres * scale);
    const Point start(10, size.height - 10);
    line(picture, start, start + Point(length, 0), Scalar::all(0), 2);
    putText(picture, format("%d m", metres), start - Point(0, 8), FONT_HERSHEY_SIMPLEX, 0.5, Scalar::all(0),
            1, LINE_AA);
    putText(picture, "Paths from above; grey: poses.txt", Point(start.x, cvRound(margin)),
            FONT_HERSHEY_SIMPLEX, 0.5, Scalar::all(0), 1, LINE_AA);
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

}  // namespace

int main(int argc, char** argv)
{
    CommandLineParser parser(argc, argv, KEYS);
    parser.about(
        "Stereo visual odometry with cv::aqorb::AdaptiveQuadtreeORB and with cv::ORB, on a folder laid out "
        "as\n"
        "KITTI's odometry sequences: calib.txt, image_0 and image_1 (or image_l and image_r) and, for the\n"
        "errors, poses.txt. Prints a table and writes the paths and the features tracked into the last\n"
        "frame to a picture.");
    const String folder = parser.get<String>("@folder"), out = parser.get<String>("out");
    const int nfeatures = parser.get<int>("nfeatures");
    const bool show = parser.has("show");
    if (parser.has("help") || !parser.check() || folder.empty())
    {
        parser.printErrors();
        parser.printMessage();
        return !parser.has("help");
    }

    StereoSequence sequence;
    try
    {
        sequence = readStereoSequence(folder);
    }
    catch (const cv::Exception& exception)
    {
        std::cerr << exception.err << std::endl;
        return 1;
    }
    std::vector<Odometry> odometries = {
        Odometry("cv::ORB", ORB::create(nfeatures), Scalar(60, 60, 230)),
        Odometry("AdaptiveQuadtreeORB", aqorb::AdaptiveQuadtreeORB::create(nfeatures), Scalar(40, 200, 40))};
    Mat left;
    for (size_t i = 0; i < sequence.left.size(); i++)
    {
        left = imread(sequence.left[i], IMREAD_GRAYSCALE);
        const Mat right = imread(sequence.right[i], IMREAD_GRAYSCALE);
        if (left.empty() || left.size() != right.size())
        {
            std::cerr << sequence.left[i] << ": not a pair of images of one size\n";
            return 1;
        }
        for (Odometry& odometry : odometries)
            track(odometry, left, right, sequence);
        if (show)
        {
            imshow("stereo odometry (Esc: stop)", drawAll(odometries, sequence, left));
            if (waitKey(30) == 27)
                break;
        }
    }
    printTable(odometries, sequence);
    if (!imwrite(out, drawAll(odometries, sequence, left)))
        return 1;
    std::cout << "Picture: " << out << '\n';
    return 0;
}
