// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "test_precomp.hpp"

#include "opencv2/aqorb/geometry.hpp"
#include "opencv2/aqorb/slam.hpp"
#include "opencv2/core/hal/hal.hpp"
#include "opencv2/core/utils/filesystem.hpp"

#include <fstream>
#include <functional>
#include <iostream>
#include <sstream>

// What a SLAM system with one camera needs of its keypoints when it starts. Written from the description in the
// paper of ORB-SLAM: keypoints of the finest level of two frames are matched, and if there are too few matches, the
// later frame becomes the reference that the frames after it are matched with. The figures are printed.

namespace opencv_test
{
namespace
{

using aqorb::SlamExtractor;

const float WINDOW = 100;  // largest distance along x and y from the place in the reference frame, in pixels
const double RATIO = 0.9;  // of the distances of the nearest and the second nearest descriptor
const int BINS = 30;       // of the histogram of the differences between angles
const int BINS_KEPT = 3;   // those that most matches are in
const int MATCHES_TO_START = 100;

struct PointPair
{
    Point2f from, to;
};

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
int angleBin(float from, float to)
{
    const float difference = from - to;
    return cvFloor((difference < 0 ? difference + 360 : difference) * BINS / 360) % BINS;
}

//! Matches between keypoints of the finest level. One of the later frame is in one match only, the nearer one.
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
            const Point2f step = later.keypoints[j].pt - reference.keypoints[i].pt;
            if (std::abs(step.x) > WINDOW || std::abs(step.y) > WINDOW)
                continue;
            const int distance = hal::normHamming(reference.descriptors.ptr(i), later.descriptors.ptr(j),
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
            const KeyPoint& from = reference.keypoints[choices[j].from];
            const KeyPoint& to = later.keypoints[j];
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

//! Keypoints of the finest level so far from each other that no two are in one window, with random descriptors.
Features sparseFeatures(int count)
{
    Features features;
    for (int i = 0; i < count; i++)
        features.keypoints.push_back(KeyPoint(Point2f(400.f * i, 50), 31, 0));  // at an angle of 0 degrees
    features.descriptors.create(count, 32, CV_8UC1);
    RNG(1).fill(features.descriptors, RNG::UNIFORM, 0, 256);
    return features;
}

TEST(Aqorb_MonocularStart, matches_lie_within_the_window)
{
    const Features reference = sparseFeatures(20);
    const Point2f steps[] = {{0, 0}, {100, -100}, {-100, 100}, {101, 0}, {-101, 0}, {0, 101}, {0, -101}};
    for (const Point2f& step : steps)
    {
        Features later = reference;
        for (KeyPoint& keypoint : later.keypoints)
            keypoint.pt += step;
        const bool isWithin = std::abs(step.x) <= 100 && std::abs(step.y) <= 100;
        EXPECT_EQ(isWithin ? 20u : 0u, matchToStart(reference, later).size()) << step;
    }
}

TEST(Aqorb_MonocularStart, the_nearest_descriptor_must_be_nearer_than_the_second)
{
    Features reference = sparseFeatures(1), later = sparseFeatures(2);
    later.keypoints[1].pt = later.keypoints[0].pt + Point2f(5, 0);
    // distances to the reference: 18 bits, and 20 or 21
    reference.descriptors.setTo(0);
    later.descriptors.setTo(0);
    later.descriptors(Rect(0, 0, 9, 1)).setTo(3);
    later.descriptors(Rect(0, 1, 10, 1)).setTo(3);
    EXPECT_TRUE(matchToStart(reference, later).empty());
    later.descriptors.at<uchar>(1, 10) = 1;
    const std::vector<PointPair> matches = matchToStart(reference, later);
    ASSERT_EQ(1u, matches.size());
    EXPECT_EQ(later.keypoints[0].pt, matches[0].to);
}

TEST(Aqorb_MonocularStart, the_nearer_of_two_keypoints_has_the_match)
{
    const Features later = sparseFeatures(1);
    for (int nearer = 0; nearer < 2; nearer++)
    {
        Features reference = sparseFeatures(2);
        reference.keypoints[1].pt = reference.keypoints[0].pt + Point2f(5, 0);
        for (int i = 0; i < 2; i++)
            later.descriptors.copyTo(reference.descriptors.row(i));
        reference.descriptors.at<uchar>(1 - nearer, 7) ^= 1;
        const std::vector<PointPair> matches = matchToStart(reference, later);
        ASSERT_EQ(1u, matches.size());
        EXPECT_EQ(reference.keypoints[nearer].pt, matches[0].from);
    }
}

TEST(Aqorb_MonocularStart, matches_of_three_angles_are_kept)
{
    const Features reference = sparseFeatures(100);
    Features later = reference;
    // 40 turn by 0 degrees, 30 by 340, 15 by 100, 10 by 200, and 5 by 20
    for (int i = 0; i < 100; i++)
        later.keypoints[i].angle = i < 40 ? 0.f : i < 70 ? 340.f : i < 85 ? 100.f : i < 95 ? 200.f : 20.f;
    EXPECT_EQ(85u, matchToStart(reference, later).size());
}

//! The methods that are compared, in this order.
enum
{
    DEFAULT,
    PAPER,
    OPENCV_ORB,
    METHODS
};

const char* const METHOD_NAMES[] = {"SlamExtractor", "SlamExtractor, the paper's selection", "cv::ORB"};

std::vector<Features> extractAll(int method, int nfeatures, const std::vector<Mat>& frames)
{
    const int nlevels = 8;
    SlamExtractor extractor(nfeatures, 1.2f, nlevels, 20, 7);
    if (method == PAPER)
    {
        extractor.detector()->setSelectionType(AdaptiveQuadtreeORB::BALANCED_SELECTION);
        extractor.detector()->setOctaveSuppression(-1);
    }
    const Ptr<ORB> orb = ORB::create(nfeatures + nlevels, 1.2f, nlevels);
    std::vector<Features> result;
    for (const Mat& frame : frames)
    {
        Features features;
        if (method == OPENCV_ORB)
            features = detectAndCompute(*orb, frame);
        else
            extractor(frame, noArray(), features.keypoints, features.descriptors);
        result.push_back(finestLevel(features));
    }
    return result;
}

//! What a method gives on a sequence, as means of all its beginnings.
struct Start
{
    double keypoints = 0;  // of the finest level
    double matches = 0;    // with the next frame
    double correct = 0;    // of these
    //! Frames until one has enough matches with the one before. One more than are left, if none has.
    double wait = 0;
    //! How many frames in a row have enough matches with one reference, up to 10.
    double held = 0;
};

//! Whether a match of the frames with these indices agrees with the motion between them.
typedef std::function<bool(int from, int to, const PointPair& match)> Motion;

Start measureStart(const std::vector<Features>& frames, const Motion& isCorrect)
{
    const int count = int(frames.size()), pairs = count - 1;
    const int horizon = std::min(pairs, 10);  // a frame is matched with so many after it
    std::vector<std::vector<int>> matches(count, std::vector<int>(horizon + 1));
    Start start;
    for (int from = 0; from < count; from++)
    {
        start.keypoints += double(frames[from].keypoints.size()) / count;
        for (int step = 1; step <= horizon && from + step < count; step++)
        {
            const std::vector<PointPair> found = matchToStart(frames[from], frames[from + step]);
            matches[from][step] = int(found.size());
            if (step == 1)
            {
                start.matches += double(found.size()) / pairs;
                for (const PointPair& match : found)
                    start.correct += double(isCorrect(from, from + 1, match)) / pairs;
            }
            if (matches[from][step] < MATCHES_TO_START)
                break;
        }
    }
    for (int first = 0; first < pairs; first++)
    {
        int reference = first;
        while (reference < pairs && matches[reference][1] < MATCHES_TO_START)
            reference++;
        start.wait += double(reference + 1 - first) / pairs;
    }
    const int references = count - horizon;
    for (int from = 0; from < references; from++)
    {
        int step = 1;
        while (step <= horizon && matches[from][step] >= MATCHES_TO_START)
            step++;
        start.held += double(step - 1) / references;
    }
    return start;
}

void report(const std::string& title, const Start (&starts)[METHODS])
{
    std::cout << format("[ FIGURE   ] %-36s keypoints  matches  correct  waits  holds", title.c_str())
              << std::endl;
    for (int method = 0; method < METHODS; method++)
    {
        const Start& start = starts[method];
        std::cout << format("[ FIGURE   ] %-36s %9.0f %8.1f %8.1f %6.1f %6.1f", METHOD_NAMES[method],
                            start.keypoints, start.matches, start.correct, start.wait, start.held)
                  << std::endl;
    }
}

//! What must hold wherever the methods are compared.
void expectBestIsDefault(const Start (&starts)[METHODS])
{
    EXPECT_GT(starts[DEFAULT].correct, starts[OPENCV_ORB].correct);
    EXPECT_GE(starts[DEFAULT].matches, starts[PAPER].matches);
    EXPECT_GE(starts[DEFAULT].correct, starts[PAPER].correct);
    EXPECT_LE(starts[DEFAULT].wait, starts[PAPER].wait);
    EXPECT_GE(starts[DEFAULT].held, starts[PAPER].held);
}

//! A camera that flies over a drawn plane: it turns, comes nearer and moves along, and its images have noise.
struct Flight
{
    explicit Flight(int seed) : plane(makeScene(Size(1200, 900), seed))
    {
        RNG rng(seed);
        for (int i = 0; i < 12; i++)
        {
            const Point2f centre(560 + 7.f * i, 440 + 3.f * i);
            const double roll = -6 + 1.2 * i, zoom = std::pow(1.012, i);
            // from the plane to the image, of which the centre is (320, 240)
            Mat motion = getRotationMatrix2D(centre, roll, zoom);
            motion.at<double>(0, 2) += 320 - centre.x;
            motion.at<double>(1, 2) += 240 - centre.y;
            Mat frame, noise(480, 640, CV_16SC1);
            warpAffine(plane, frame, motion, Size(640, 480), INTER_LINEAR);
            rng.fill(noise, RNG::NORMAL, 0, 3);
            cv::add(frame, noise, frame, noArray(), CV_8U);
            motions.push_back(motion);
            frames.push_back(frame);
        }
    }
    //! Within 3 pixels.
    bool isCorrect(int from, int to, const PointPair& match) const
    {
        Mat back;
        invertAffineTransform(motions[from], back);
        return cv::norm(mapped(motions[to], mapped(back, match.from)) - Point2d(match.to)) <= 3;
    }
    static Point2d mapped(const Mat& motion, const Point2d& point)
    {
        const Mat_<double> m = motion;
        return Point2d(m(0, 0) * point.x + m(0, 1) * point.y + m(0, 2),
                       m(1, 0) * point.x + m(1, 1) * point.y + m(1, 2));
    }

    const Mat plane;
    std::vector<Mat> motions, frames;
};

TEST(Aqorb_MonocularStart, over_a_drawn_plane)
{
    for (int nfeatures : {500, 1000})
    {
        Start starts[METHODS];
        for (int seed = 1; seed <= 3; seed++)
        {
            const Flight flight(seed);
            for (int method = 0; method < METHODS; method++)
                starts[method] = measureStart(extractAll(method, nfeatures, flight.frames),
                                              [&](int from, int to, const PointPair& match)
                                              { return flight.isCorrect(from, to, match); });
            report(format("drawn plane %d, %d features", seed, nfeatures), starts);
            expectBestIsDefault(starts);
            if (nfeatures >= 1000)
            {
                EXPECT_DOUBLE_EQ(1, starts[DEFAULT].wait);  // every frame matches the next
                EXPECT_GE(starts[DEFAULT].held, 4);
            }
        }
    }
}

//! The left images of a sequence in KITTI's layout, and the motion of the camera.
struct Drive
{
    Drive()
    {
        std::vector<String> files;
        for (const char* folder : {"image_0", "image_l"})
        {
            if (files.empty() && utils::fs::isDirectory(sequenceFile(folder)))
                glob(sequenceFile(folder) + "/*.png", files);
        }
        for (const String& file : files)
            frames.push_back(imread(file, IMREAD_GRAYSCALE));
        for (const Matx34d& matrix : matrices("poses.txt"))
        {
            poses.push_back(Matx44d::eye());
            for (int i = 0; i < 12; i++)
                poses.back().val[i] = matrix.val[i];
        }
        const std::vector<Matx34d> projections = matrices("calib.txt");
        if (!projections.empty())
            camera = projections[0].get_minor<3, 3>(0, 0);
    }

    //! Within 2 pixels of the line on which the motion puts the point.
    bool isCorrect(int from, int to, const PointPair& match) const
    {
        const Matx44d motion = poses[to].inv() * poses[from];
        const Vec3d t(motion(0, 3), motion(1, 3), motion(2, 3));
        const Matx33d cross(0, -t[2], t[1], t[2], 0, -t[0], -t[1], t[0], 0);
        const Matx33d fundamental = camera.inv().t() * cross * motion.get_minor<3, 3>(0, 0) * camera.inv();
        const Vec3d line = fundamental * Vec3d(match.from.x, match.from.y, 1);
        return std::abs(line.dot(Vec3d(match.to.x, match.to.y, 1))) <= 2 * std::hypot(line[0], line[1]);
    }

    //! The matrices of a file, one a line, with or without a label.
    static std::vector<Matx34d> matrices(const std::string& name)
    {
        std::vector<Matx34d> result;
        std::ifstream file(sequenceFile(name));
        for (std::string line; std::getline(file, line);)
        {
            const size_t label = line.find(':');
            std::istringstream numbers(label == std::string::npos ? line : line.substr(label + 1));
            Matx34d matrix;
            int count = 0;
            while (count < 12 && numbers >> matrix.val[count])
                count++;
            if (count == 12)
                result.push_back(matrix);
        }
        return result;
    }

    std::vector<Mat> frames;
    std::vector<Matx44d> poses;
    Matx33d camera;
};

TEST(Aqorb_MonocularStart, on_a_road)
{
    if (sequenceFile("").empty())
        AQORB_SKIP("AQORB_TEST_SEQUENCE is not set");
    const Drive drive;
    if (drive.frames.empty() && sizeof(void*) == 4)
        AQORB_SKIP("the emulator of a CPU of 32 bits cannot list the folders of some file systems");
    ASSERT_GE(drive.frames.size(), 20u);
    ASSERT_EQ(drive.frames.size(), drive.poses.size());
    for (int nfeatures : {500, 1000, 2000})
    {
        Start starts[METHODS];
        for (int method = 0; method < METHODS; method++)
            starts[method] = measureStart(extractAll(method, nfeatures, drive.frames),
                                          [&](int from, int to, const PointPair& match)
                                          { return drive.isCorrect(from, to, match); });
        report(format("road, %d features", nfeatures), starts);
        expectBestIsDefault(starts);
        if (nfeatures >= 1000)
        {
            EXPECT_LE(starts[DEFAULT].wait, 2);
        }
        if (nfeatures >= 2000)
        {
            EXPECT_GE(starts[DEFAULT].held, 2);
        }
    }
}

}  // namespace
}  // namespace opencv_test
