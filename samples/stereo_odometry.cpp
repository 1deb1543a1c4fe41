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
#if CV_VERSION_MAJOR >= 5
#include <opencv2/geometry.hpp>
#else
#include <opencv2/calib3d.hpp>
#endif

#include <fstream>
#include <sstream>

using namespace cv;

namespace
{

const char* const ABOUT =
    "Stereo visual odometry with cv::ORB, with cv::aqorb::AdaptiveQuadtreeORB, and with this and\n"
    "cv::aqorb::growMatches, on a folder laid out as KITTI's odometry sequences: calib.txt, image_0 and\n"
    "image_1 (or image_l and image_r) and, for the errors, poses.txt. Prints a table, and writes the paths\n"
    "and the features tracked into the last frame to a picture.";

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
    Odometry(const char* name_, const Ptr<ORB>& detector_, const Scalar& colour_, bool grows_ = false)
        : name(name_), detector(detector_), colour(colour_), grows(grows_)
    {
    }

    const char* name;
    Ptr<ORB> detector;
    Scalar colour;
    bool grows;                                     // whether growMatches refines and adds matches
    Frame frame;                                    // last frame
    std::vector<Point2f> from, to;                  // inliers of the last motion, in both left images
    Affine3d motion;                                // from the last frame's coordinates to the frame before
    std::vector<Affine3d> poses;                    // of the left camera, from the first frame on
    double keypoints = 0, depths = 0, inliers = 0;  // sums over the frames
};

//! Reads matrices of 3x4 numbers from a file, one per line, with or without a label such as "P0:".
std::vector<Matx34d> readMatrices(const String& file)
{
    std::vector<Matx34d> matrices;
    std::ifstream lines(file);
    for (std::string line; std::getline(lines, line);)
    {
        std::istringstream numbers(line.substr(line.find(':') + 1));  // npos + 1 is 0
        Matx34d matrix;
        int count = 0;
        while (count < 12 && numbers >> matrix.val[count])
            count++;
        if (count == 12)
            matrices.push_back(matrix);
    }
    return matrices;
}

std::vector<String> imagesOf(const String& folder)
{
    std::vector<String> files;
    if (utils::fs::isDirectory(folder))
        glob(folder + "/*.png", files);
    return files;
}

/** Reads calib.txt (P0 and P1), the folders of images (image_0 and image_1 as in KITTI, or image_l and image_r) and
 poses.txt if present. */
Sequence readSequence(const String& folder)
{
    Sequence sequence;
    const std::vector<Matx34d> projections = readMatrices(folder + "/calib.txt");
    for (const Matx34d& pose : readMatrices(folder + "/poses.txt"))
        sequence.poses.push_back(Affine3d(pose.get_minor<3, 3>(0, 0), Vec3d(pose.col(3).val)));
    const bool isKitti = !utils::fs::exists(folder + "/image_l");
    sequence.left = imagesOf(folder + (isKitti ? "/image_0" : "/image_l"));
    sequence.right = imagesOf(folder + (isKitti ? "/image_1" : "/image_r"));
    if (projections.size() < 2 || sequence.left.empty() || sequence.right.size() != sequence.left.size())
        CV_Error(Error::StsObjectNotFound, folder + ": needs calib.txt and as many images of both cameras");
    if (!sequence.poses.empty() && sequence.poses.size() < sequence.left.size())
        CV_Error(Error::StsObjectNotFound, folder + ": poses.txt has fewer poses than there are images");
    sequence.camera = projections[0].get_minor<3, 3>(0, 0);
    sequence.baseline = (projections[0](0, 3) - projections[1](0, 3)) / projections[0](0, 0);
    return sequence;
}

//! Positions of matches, which growMatches may refine and extend. Then only queryIdx stays valid.
void positions(bool grows, const Mat& image1, const std::vector<KeyPoint>& keypoints1, const Mat& image2,
               const std::vector<KeyPoint>& keypoints2, std::vector<DMatch>& matches,
               std::vector<Point2f>& points1, std::vector<Point2f>& points2)
{
    std::vector<KeyPoint> grown2;
    std::vector<float> deviations;
    if (grows)
        return aqorb::growMatches(image1, keypoints1, image2, keypoints2, matches, grown2, points1, points2,
                                  deviations);
    for (const DMatch& match : matches)
    {
        points1.push_back(keypoints1[match.queryIdx].pt);
        points2.push_back(keypoints2[match.trainIdx].pt);
    }
}

/** Features of the left image with a mutually best match in the right image, within some rows and at most MAX_DISPARITY
 pixels further left. */
Frame stereoFrame(Odometry& odometry, const Mat& left, const Mat& right, const Sequence& sequence)
{
    const float ROWS = 3, MIN_DISPARITY = 0.5f, MAX_DISPARITY = 200;
    std::vector<KeyPoint> keypointsLeft, keypointsRight;
    Mat descriptorsLeft, descriptorsRight, pairs, distances;
    odometry.detector->detectAndCompute(left, noArray(), keypointsLeft, descriptorsLeft);
    odometry.detector->detectAndCompute(right, noArray(), keypointsRight, descriptorsRight);
    std::vector<Point2f> predicted;
    for (const KeyPoint& keypoint : keypointsLeft)
        predicted.push_back(keypoint.pt - Point2f((MIN_DISPARITY + MAX_DISPARITY) / 2, 0));
    const Size2f reach((MAX_DISPARITY - MIN_DISPARITY) / 2, ROWS);
    aqorb::matchByPosition(descriptorsLeft, predicted, descriptorsRight, keypointsRight, reach, pairs,
                           distances, 0, true, -1, odometry.detector->defaultNorm());
    odometry.keypoints += double(keypointsLeft.size());

    std::vector<DMatch> matches;
    for (int i = 0; i < pairs.rows; i++)
        matches.emplace_back(pairs.at<int>(i, 0), pairs.at<int>(i, 1), 0.f);
    std::vector<Point2f> pointsLeft, pointsRight;
    positions(odometry.grows, left, keypointsLeft, right, keypointsRight, matches, pointsLeft, pointsRight);

    Frame frame;
    frame.image = left;
    const Matx33d& k = sequence.camera;
    for (size_t i = 0; i < matches.size(); i++)
    {
        const int index = matches[i].queryIdx;
        const Point2f p = pointsLeft[i], disparity = p - pointsRight[i];
        if (disparity.x < MIN_DISPARITY)
            continue;
        const double depth = k(0, 0) * sequence.baseline / disparity.x;
        frame.keypoints.push_back(keypointsLeft[index]);
        frame.descriptors.push_back(descriptorsLeft.row(index));
        frame.points.emplace_back((p.x - k(0, 2)) * depth / k(0, 0), (p.y - k(1, 2)) * depth / k(1, 1),
                                  depth);
    }
    odometry.depths += double(frame.points.size());
    return frame;
}

/** Estimates the motion from the last frame to the next: PnP with RANSAC, refined on the inliers. With too few matches
 the last motion repeats. */
void estimateMotion(Odometry& odometry, const Frame& next, const Matx33d& camera)
{
    const float THRESHOLD = odometry.grows ? 0.5f : 1.5f;  // pixels; 1.5 is best for cv::ORB
    const Frame& last = odometry.frame;
    std::vector<DMatch> matches;  // mutual nearest neighbours, as BFMatcher(norm, true) gives
    if (!last.descriptors.empty() && !next.descriptors.empty())
        aqorb::HammingMatcher(odometry.detector->defaultNorm(), true)
            .match(last.descriptors, next.descriptors, matches);
    std::vector<Point2f> from, to;
    positions(odometry.grows, last.image, last.keypoints, next.image, next.keypoints, matches, from, to);
    const std::vector<Point2d> pixels(to.begin(), to.end());
    std::vector<Point2d> inlierPixels;
    std::vector<Point3d> points, inlierPoints;
    for (const DMatch& match : matches)
        points.push_back(last.points[match.queryIdx]);
    odometry.from.clear();
    odometry.to.clear();
    Vec3d rotation, translation;
    std::vector<int> inliers;
    if (matches.size() < 6 ||
        !solvePnPRansac(points, pixels, camera, noArray(), rotation, translation, false, 1000, THRESHOLD,
                        0.9999, inliers, SOLVEPNP_P3P) ||
        inliers.size() < 6)
        return;
    for (int i : inliers)
    {
        inlierPoints.push_back(points[i]);
        inlierPixels.push_back(pixels[i]);
        odometry.from.push_back(from[i]);
        odometry.to.push_back(to[i]);
    }
    solvePnPRefineLM(inlierPoints, inlierPixels, camera, noArray(), rotation, translation);
    odometry.motion = Affine3d(rotation, translation).inv();
}

void track(Odometry& odometry, const Mat& left, const Mat& right, const Sequence& sequence)
{
    const Frame frame = stereoFrame(odometry, left, right, sequence);
    if (odometry.poses.empty())
        odometry.poses.push_back(Affine3d());
    else
    {
        estimateMotion(odometry, frame, sequence.camera);
        odometry.inliers += double(odometry.to.size());
        odometry.poses.push_back(odometry.poses.back() * odometry.motion);
    }
    odometry.frame = frame;
}

double pathLength(const std::vector<Affine3d>& poses, size_t first, size_t last)
{
    double length = 0;
    for (size_t i = first; i < last; i++)
        length += norm(poses[i + 1].translation() - poses[i].translation());
    return length;
}

//! Error of the motion over `step` frames, in per cent of the path.
double translationError(const std::vector<Affine3d>& poses, const std::vector<Affine3d>& truth, size_t step)
{
    double sum = 0;
    size_t count = 0;
    for (; count + step < poses.size(); count++)
    {
        const Affine3d motion = poses[count].inv() * poses[count + step];
        const Affine3d trueMotion = truth[count].inv() * truth[count + step];
        sum += 100 * norm((trueMotion.inv() * motion).translation()) /
               std::max(pathLength(truth, count, count + step), 1e-6);
    }
    return sum / std::max(double(count), 1.);
}

void printTable(const std::vector<Odometry>& odometries, const Sequence& sequence)
{
    const double frames = double(odometries[0].poses.size()), motions = std::max(frames - 1, 1.);
    const size_t STEP = 10;
    printRow(format("%d frames", int(frames)), odometries, [](const Odometry& o) { return String(o.name); });
    printRow("keypoints of the left image, mean", odometries,
             [&](const Odometry& o) { return format("%.0f", o.keypoints / frames); });
    printRow("  of these with a depth", odometries,
             [&](const Odometry& o) { return format("%.0f", o.depths / frames); });
    printRow("inliers of the motion, mean", odometries,
             [&](const Odometry& o) { return format("%.0f", o.inliers / motions); });
    printRow("length of the path", odometries,
             [](const Odometry& o) { return format("%.2f m", pathLength(o.poses, 0, o.poses.size() - 1)); });
    if (sequence.poses.empty())
        return;
    std::printf("  by poses.txt: %.2f m\n", pathLength(sequence.poses, 0, odometries[0].poses.size() - 1));
    printRow("translation error over 10 frames, of the path", odometries,
             [&](const Odometry& o)
             { return format("%.2f %%", translationError(o.poses, sequence.poses, STEP)); });
}

// Left image with tracked features: a line from the position in the frame before.
Mat trackPicture(const Odometry& odometry, const Mat& left)
{
    Mat picture;
    cvtColor(left, picture, COLOR_GRAY2BGR);
    for (size_t i = 0; i < odometry.to.size(); i++)
    {
        line(picture, odometry.from[i], odometry.to[i], odometry.colour, 1, LINE_AA);
        circle(picture, odometry.to[i], 2, odometry.colour, FILLED, LINE_AA);
    }
    return captioned(picture, format("%s: %d inliers", odometry.name, int(odometry.to.size())),
                     odometry.colour);
}

//! Paths from above: the detectors' paths in colours, over the true path in grey.
Mat pathPicture(const std::vector<Odometry>& odometries, const std::vector<Affine3d>& truth, Size size)
{
    std::vector<std::vector<Point2f>> lines(1);
    std::vector<Scalar> colours = {Scalar::all(160)};
    const auto add = [&](const Affine3d& pose)
    { lines.back().push_back(Point2f(float(pose.translation()[0]), float(-pose.translation()[2]))); };
    for (size_t i = 0; i < truth.size() && i < odometries[0].poses.size(); i++)
        add(truth[0].inv() * truth[i]);
    for (const Odometry& odometry : odometries)
    {
        lines.emplace_back();
        colours.push_back(odometry.colour);
        for (const Affine3d& pose : odometry.poses)
            add(pose);
    }
    std::vector<Point2f> all;
    for (const std::vector<Point2f>& points : lines)
        all.insert(all.end(), points.begin(), points.end());
    const Rect box = boundingRect(all);  // in metres
    const Scalar centre(box.x + box.width / 2., box.y + box.height / 2.);
    const double scale =
        std::min((size.width - 60.) / (box.width + 10), (size.height - 60.) / (box.height + 10));
    Mat picture(size, CV_8UC3, Scalar::all(255));
    for (size_t i = truth.empty() ? 1 : 0; i < lines.size(); i++)
    {
        Mat pixels = (Mat(lines[i]) - centre) * scale + Scalar(size.width / 2., size.height / 2.);
        pixels.convertTo(pixels, CV_32S);
        polylines(picture, pixels, false, colours[i], 2, LINE_AA);
    }
    const Point start(10, size.height - 10);
    line(picture, start, start + Point(cvRound(10 * scale), 0), Scalar::all(0), 2);
    putText(picture, "10 m; grey: poses.txt", start - Point(0, 8), FONT_HERSHEY_SIMPLEX, 0.5, Scalar::all(0),
            1, LINE_AA);
    return picture;
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
    std::vector<Odometry> odometries = {
        Odometry("cv::ORB", ORB::create(nfeatures), Scalar(60, 60, 230)),
        Odometry("AdaptiveQuadtreeORB", aqorb::AdaptiveQuadtreeORB::create(nfeatures), Scalar(40, 200, 40)),
        Odometry("with growMatches", aqorb::AdaptiveQuadtreeORB::create(nfeatures), Scalar(220, 120, 0),
                 true)};
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
    Mat picture;
    std::vector<Mat> tracks;
    for (const Odometry& odometry : odometries)
        tracks.push_back(trackPicture(odometry, left));
    vconcat(tracks, picture);
    hconcat(picture, pathPicture(odometries, sequence.poses, Size(picture.rows / 2, picture.rows)), picture);
    writePicture(out, picture);
    return 0;
}

}  // namespace

int main(int argc, char** argv)
{
    return runSample(stereoOdometry, argc, argv);
}
