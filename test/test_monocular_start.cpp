// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "test_precomp.hpp"

#include "geometry.hpp"
#include "start_matches.hpp"

#include "opencv2/aqorb/slam.hpp"

#ifdef AQORB_HAVE_GEOMETRY
#include "../samples/stereo_odometry.hpp"
#endif

#include <iostream>

// What a SLAM system with one camera needs of its keypoints when it starts: start_matches.hpp. If there are too few
// matches, the later frame becomes the reference that the frames after it are matched with. The figures are printed.

namespace opencv_test
{
namespace
{

using aqorb::SlamExtractor;

const int MATCHES_TO_START = 100;

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

#ifdef AQORB_HAVE_GEOMETRY

TEST(Aqorb_MonocularStart, on_a_road)
{
    if (sequenceFile("").empty())
        AQORB_SKIP("AQORB_TEST_SEQUENCE is not set");
    if (sizeof(void*) == 4)
        AQORB_SKIP("the emulator of a CPU of 32 bits cannot list the folders of some file systems");
    const StereoSequence drive = readStereoSequence(sequenceFile(""));
    std::vector<Mat> frames;
    for (const String& file : drive.left)
        frames.push_back(imread(file, IMREAD_GRAYSCALE));
    ASSERT_GE(frames.size(), 20u);
    ASSERT_LE(frames.size(), drive.poses.size());
    for (int nfeatures : {500, 1000, 2000})
    {
        Start starts[METHODS];
        for (int method = 0; method < METHODS; method++)
            starts[method] =
                measureStart(extractAll(method, nfeatures, frames),
                             [&](int from, int to, const PointPair& match)
                             {
                                 const Matx44d motion = drive.poses[to].inv() * drive.poses[from];
                                 return isOnEpipolarLine(match, fundamentalMatrix(drive.camera, motion));
                             });
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

#endif  // AQORB_HAVE_GEOMETRY

}  // namespace
}  // namespace opencv_test
