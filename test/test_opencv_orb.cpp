// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "reference.hpp"

// Equality with the installed cv::ORB: descriptors bit for bit, and compute with all its habits. That the count is
// never lower is checked in test_masks.cpp and test_promises.cpp.

namespace opencv_test
{
namespace
{

#define AQORB_NEEDS_FMA_BLUR()                                                       \
    do                                                                               \
    {                                                                                \
        if (!orbBlursWithFMA())                                                      \
            AQORB_SKIP("cv::ORB of this OpenCV and CPU blurs without multiply-add"); \
    } while (false)

/** Bits in which a descriptor may differ from cv::ORB's: none, except where OpenCV is compiled such that it may round
 a turned test point to another pixel. Compiled with OpenCV's own headers only, as 4.14 and 5 are here, it takes sine
 and cosine of a double, and such a point is part of several tests. */
int toleratedBits()
{
#if defined(__OPENCV_BUILD) || CV_VERSION_MAJOR >= 5 || CV_VERSION_MINOR >= 14
    return 8;
#else
    static const int bits = reference::opencvFusesMultiplyAdd() ? 1 : 0;
    return bits;
#endif
}

using reference::Settings;

//! The defaults of cv::ORB.
Settings orbDefaults()
{
    Settings settings;
    settings.edgeThreshold = 31;
    return settings;
}

//! Random parameters, those of cv::ORB over all that it takes, such that no level is too large or too small for it.
Settings randomParameters(RNG& rng, Size imageSize)
{
    Settings p = reference::randomSettings(rng);
    p.nfeatures = rng.uniform(20, 700);
    p.scaleFactor = rng.uniform(1.1f, 2.5f);
    p.firstLevel = rng.uniform(0, 4);
    // At most 9 times the image's pixels on level 0, at least 8 pixels on the last level.
    const double shortest = std::min(imageSize.width, imageSize.height);
    while (std::pow(double(p.scaleFactor), p.firstLevel) > 3)
        p.firstLevel--;
    p.nlevels = p.firstLevel + 1;
    const int nlevels = rng.uniform(1, 11);
    while (p.nlevels < nlevels && shortest / std::pow(double(p.scaleFactor), p.nlevels - p.firstLevel) >= 8)
        p.nlevels++;
    p.edgeThreshold = rng.uniform(0, 41);
    p.WTA_K = rng.uniform(2, 5);
    p.scoreType = rng.uniform(0, 2) ? ORB::HARRIS_SCORE : ORB::FAST_SCORE;
    p.patchSize = rng.uniform(0, 3) ? rng.uniform(2, 62) : 31;
    p.fastThreshold = rng.uniform(5, 30);
    return p;
}

/** Whether the descriptors of our keypoints are what cv::ORB computes for them. With firstLevel > 0
 cv::ORB::compute may drop some near the border; they are found again by class_id. */
void expectDescriptorsOfOrb(const Settings& p, const Mat& image)
{
    SCOPED_TRACE(p.text());
    const Features ours = detectAndCompute(*p.create(), image);
    KeyPoints tagged = ours.keypoints;
    for (size_t i = 0; i < tagged.size(); i++)
        tagged[i].class_id = int(i);
    Mat descriptors;
    p.createOrb()->compute(image, tagged, descriptors);
    if (p.firstLevel == 0)
    {
        EXPECT_EQ(ours.keypoints.size(), tagged.size());
    }
    ASSERT_EQ(int(tagged.size()), descriptors.rows);
    const int tolerance = toleratedBits();
    int last = -1;
    for (size_t i = 0; i < tagged.size(); i++)
    {
        ASSERT_GT(tagged[i].class_id, last);  // cv::ORB keeps the order, too.
        last = tagged[i].class_id;
        ASSERT_LE(cv::norm(ours.descriptors.row(tagged[i].class_id), descriptors.row(int(i)), NORM_HAMMING),
                  tolerance)
            << "at (" << tagged[i].pt.x << ", " << tagged[i].pt.y << ") octave " << tagged[i].octave;
    }
}

//! Whether both computes leave the same keypoints, in all fields, and the same descriptors.
void expectSameCompute(const Settings& p, const Mat& image, const KeyPoints& keypoints)
{
    SCOPED_TRACE(p.text());
    Features ours, theirs;
    ours.keypoints = theirs.keypoints = keypoints;
    p.create()->compute(image, ours.keypoints, ours.descriptors);
    p.createOrb()->compute(image, theirs.keypoints, theirs.descriptors);
    EXPECT_TRUE(sameKeypoints(ours.keypoints, theirs.keypoints));
    ASSERT_EQ(theirs.descriptors.size(), ours.descriptors.size());
    for (int i = 0; i < ours.descriptors.rows; i++)
        ASSERT_LE(cv::norm(ours.descriptors.row(i), theirs.descriptors.row(i), NORM_HAMMING), toleratedBits())
            << i;
}

KeyPoints orbKeypoints(const Settings& p, const Mat& image)
{
    KeyPoints keypoints;
    p.createOrb()->detect(image, keypoints);
    return keypoints;
}

//! A coordinate anywhere, or in eighths of a pixel around where cv::ORB::compute begins to drop points.
float arbitraryCoordinate(RNG& rng, int edgeThreshold, int length)
{
    const float eighths = float(rng.uniform(-16, 17)) / 8;
    const float values[] = {rng.uniform(-40.f, length + 40.f), edgeThreshold + eighths,
                            length - edgeThreshold + eighths};
    const float value = values[rng.uniform(0, 3)];
    // With edgeThreshold 0 cv::ORB::compute keeps points outside and reads beyond its memory for them.
    return edgeThreshold > 0 ? value : std::min(std::max(value, -0.5f), length - 0.125f);
}

//! Keypoints all over the image and its border, octaves in disorder, every field set to something.
KeyPoints arbitraryKeypoints(RNG& rng, const Settings& p, Size imageSize)
{
    KeyPoints keypoints;
    for (int i = 0; i < 1000; i++)
    {
        const Point2f point(arbitraryCoordinate(rng, p.edgeThreshold, imageSize.width),
                            arbitraryCoordinate(rng, p.edgeThreshold, imageSize.height));
        keypoints.push_back(KeyPoint(point, rng.uniform(1.f, 90.f), rng.uniform(0.f, 360.f),
                                     rng.uniform(-1.f, 1.f), rng.uniform(0, p.nlevels),
                                     rng.uniform(-5, 500)));
    }
    return keypoints;
}

TEST(Aqorb_OpenCVOrb, descriptors_and_compute_equal_for_random_parameters)
{
    AQORB_NEEDS_FMA_BLUR();
    RNG rng(3);
    for (int i = 0; i < 200; i++)
    {
        SCOPED_TRACE(i);
        const Size size(rng.uniform(60, 260), rng.uniform(60, 260));
        const Mat image = i % 8 == 0 ? makeNoise(size, i) : makeScene(size, i + 1);
        Settings p = randomParameters(rng, size);
        const int edgeThresholds[] = {p.edgeThreshold, 0, 1, size.height / 2 + rng.uniform(-1, 2)};
        p.edgeThreshold = edgeThresholds[i / 2 % 4];
        expectDescriptorsOfOrb(p, image);
        expectSameCompute(p, image, orbKeypoints(p, image));
        // Some of these are dropped at the sides and corners, and all are sorted by octave.
        expectSameCompute(p, image, arbitraryKeypoints(rng, p, size));
    }
}

TEST(Aqorb_OpenCVOrb, descriptors_and_compute_equal_on_photographs)
{
    AQORB_NEEDS_DATA();
    AQORB_NEEDS_FMA_BLUR();
    RNG rng(4);
    const std::vector<Mat> images = photographs();
    for (size_t i = 0; i < images.size(); i++)
    {
        SCOPED_TRACE(i);
        for (int j = 0; j < 8; j++)
        {
            const Settings p = j > 0 ? randomParameters(rng, images[i].size()) : orbDefaults();
            expectDescriptorsOfOrb(p, images[i]);
            expectSameCompute(p, images[i], orbKeypoints(p, images[i]));
        }
    }
}

TEST(Aqorb_OpenCVOrb, compute_takes_octaves_beyond_the_levels)
{
    // Up to the last octave whose level has a pixel.
    AQORB_NEEDS_FMA_BLUR();
    RNG rng(9);
    const Mat scene = makeScene(Size(800, 600));
    Settings p = orbDefaults();
    p.patchSize = 15;
    p.edgeThreshold = 16;
    for (int nlevels : {1, 8})
    {
        p.nlevels = nlevels;
        KeyPoints keypoints;
        for (int octave = 8; octave <= 38; octave++)
        {
            for (int i = 0; i < 10; i++)
                keypoints.push_back(KeyPoint(Point2f(rng.uniform(16.f, 780.f), rng.uniform(16.f, 580.f)),
                                             31.f, rng.uniform(0.f, 360.f), 1.f, octave, i));
        }
        expectSameCompute(p, scene, keypoints);
    }
    // The next one raises before the other levels are made.
    KeyPoints keypoints(1, KeyPoint(Point2f(400, 300), 31, 0, 1, 38));
    Mat descriptors;
    EXPECT_NO_THROW(p.create()->compute(scene, keypoints, descriptors));
    keypoints[0].octave = 39;
    EXPECT_THROW(p.create()->compute(scene, keypoints, descriptors), cv::Exception);
    EXPECT_EQ(1u, keypoints.size());
}

TEST(Aqorb_OpenCVOrb, compute_equal_in_a_direction_that_puts_a_point_between_two_pixels)
{
    // cv::ORB takes sine and cosine of a float, which are not always the floats nearest to the exact values;
    // at this angle the point (14, -23) of the pattern comes to lie on -22.5 or just beyond.
    AQORB_NEEDS_FMA_BLUR();
    KeyPoints keypoints;
    for (int i = 0; i < 200; i++)
        keypoints.push_back(KeyPoint(Point2f(40.f + i % 20 * 6, 40.f + i / 20 * 8), 47.f, 295.352722f));
    Settings p;
    p.patchSize = 47;
    for (p.WTA_K = 2; p.WTA_K <= 4; p.WTA_K++)
        expectSameCompute(p, makeNoise(Size(200, 160)), keypoints);
}

}  // namespace
}  // namespace opencv_test
