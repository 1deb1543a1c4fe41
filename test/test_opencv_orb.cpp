// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "reference.hpp"

// Equality with the installed cv::ORB: descriptors bit for bit, compute with all its habits, and a count
// that is never lower.

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

struct Parameters
{
    int nfeatures;
    float scaleFactor;
    int nlevels, edgeThreshold, firstLevel, WTA_K;
    ORB::ScoreType scoreType;
    int patchSize, fastThreshold;

    Parameters()
        : nfeatures(500),
          scaleFactor(1.2f),
          nlevels(8),
          edgeThreshold(31),
          firstLevel(0),
          WTA_K(2),
          scoreType(ORB::HARRIS_SCORE),
          patchSize(31),
          fastThreshold(20)
    {
    }

    Ptr<AdaptiveQuadtreeORB> ours() const
    {
        return AdaptiveQuadtreeORB::create(nfeatures, scaleFactor, nlevels, edgeThreshold, firstLevel, WTA_K,
                                           scoreType, patchSize, fastThreshold);
    }

    Ptr<ORB> theirs() const
    {
        return ORB::create(nfeatures, scaleFactor, nlevels, edgeThreshold, firstLevel, WTA_K, scoreType,
                           patchSize, fastThreshold);
    }

    std::string text() const
    {
        return format("nfeatures %d scaleFactor %g nlevels %d edgeThreshold %d firstLevel %d WTA_K %d "
                      "scoreType %d patchSize %d fastThreshold %d",
                      nfeatures, scaleFactor, nlevels, edgeThreshold, firstLevel, WTA_K, int(scoreType),
                      patchSize, fastThreshold);
    }
};

//! Random parameters over all that cv::ORB takes, such that no level is too large or too small for it.
Parameters randomParameters(RNG& rng, Size imageSize)
{
    Parameters p;
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
void expectDescriptorsOfOrb(const Parameters& p, const Mat& image)
{
    SCOPED_TRACE(p.text());
    const Features ours = detectAndCompute(*p.ours(), image);
    KeyPoints tagged = ours.keypoints;
    for (size_t i = 0; i < tagged.size(); i++)
        tagged[i].class_id = int(i);
    Mat descriptors;
    p.theirs()->compute(image, tagged, descriptors);
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
void expectSameCompute(const Parameters& p, const Mat& image, const KeyPoints& keypoints)
{
    SCOPED_TRACE(p.text());
    Features ours, theirs;
    ours.keypoints = theirs.keypoints = keypoints;
    p.ours()->compute(image, ours.keypoints, ours.descriptors);
    p.theirs()->compute(image, theirs.keypoints, theirs.descriptors);
    EXPECT_TRUE(sameKeypoints(ours.keypoints, theirs.keypoints));
    ASSERT_EQ(theirs.descriptors.size(), ours.descriptors.size());
    for (int i = 0; i < ours.descriptors.rows; i++)
        ASSERT_LE(cv::norm(ours.descriptors.row(i), theirs.descriptors.row(i), NORM_HAMMING), toleratedBits())
            << i;
}

KeyPoints orbKeypoints(const Parameters& p, const Mat& image)
{
    KeyPoints keypoints;
    p.theirs()->detect(image, keypoints);
    return keypoints;
}

//! Keypoints all over the image and its border, octaves in disorder, every field set to something.
KeyPoints arbitraryKeypoints(RNG& rng, Size imageSize, int octaves, int count)
{
    KeyPoints keypoints;
    for (int i = 0; i < count; i++)
    {
        const Point2f point(rng.uniform(0.f, imageSize.width - 1.f),
                            rng.uniform(0.f, imageSize.height - 1.f));
        keypoints.push_back(KeyPoint(point, rng.uniform(1.f, 90.f), rng.uniform(0.f, 360.f),
                                     rng.uniform(-1.f, 1.f), rng.uniform(0, octaves), rng.uniform(-5, 500)));
    }
    return keypoints;
}

TEST(Aqorb_OpenCVOrb, descriptors_equal_for_default_parameters)
{
    AQORB_NEEDS_FMA_BLUR();
    expectDescriptorsOfOrb(Parameters(), makeScene(Size(640, 480)));
}

TEST(Aqorb_OpenCVOrb, descriptors_equal_for_each_parameter)
{
    AQORB_NEEDS_FMA_BLUR();
    const Mat scene = makeScene(Size(320, 240), 2);
    Parameters p;
    for (p.WTA_K = 2; p.WTA_K <= 4; p.WTA_K++)
        expectDescriptorsOfOrb(p, scene);
    p = Parameters();
    for (p.patchSize = 2; p.patchSize <= 61; p.patchSize++)
    {
        p.WTA_K = 2 + p.patchSize % 3;
        expectDescriptorsOfOrb(p, scene);
    }
    p = Parameters();
    for (p.edgeThreshold = 0; p.edgeThreshold <= 40; p.edgeThreshold++)
        expectDescriptorsOfOrb(p, scene);
    p = Parameters();
    for (p.nlevels = 1; p.nlevels <= 10; p.nlevels++)
        expectDescriptorsOfOrb(p, scene);
    p = Parameters();
    for (p.firstLevel = 0; p.firstLevel <= 3; p.firstLevel++)
        expectDescriptorsOfOrb(p, scene);
    p = Parameters();
    p.nlevels = 4;
    for (p.scaleFactor = 1.1f; p.scaleFactor < 2.55f; p.scaleFactor += 0.1f)
        expectDescriptorsOfOrb(p, scene);
    p = Parameters();
    p.scoreType = ORB::FAST_SCORE;
    expectDescriptorsOfOrb(p, scene);
    p = Parameters();
    p.scaleFactor = 1;  // legal with one level
    p.nlevels = 1;
    try
    {
        p.theirs();
    }
    catch (const cv::Exception&)  // not for the cv::ORB of OpenCV 4.14
    {
        EXPECT_NO_THROW(p.ours());
        return;
    }
    expectDescriptorsOfOrb(p, scene);
    expectSameCompute(p, scene, orbKeypoints(p, scene));
}

TEST(Aqorb_OpenCVOrb, descriptors_equal_for_random_parameters)
{
    AQORB_NEEDS_FMA_BLUR();
    RNG rng(3);
    for (int i = 0; i < 80; i++)
    {
        SCOPED_TRACE(i);
        const Size size(rng.uniform(60, 260), rng.uniform(60, 260));
        const Parameters p = randomParameters(rng, size);
        expectDescriptorsOfOrb(p, i % 8 == 0 ? makeNoise(size, i) : makeScene(size, i + 1));
    }
}

TEST(Aqorb_OpenCVOrb, descriptors_equal_in_colour)
{
    AQORB_NEEDS_FMA_BLUR();
    Mat colour, colourAlpha;
    const Mat channels[] = {makeScene(Size(320, 240), 1), makeScene(Size(320, 240), 2),
                            makeScene(Size(320, 240), 3), makeNoise(Size(320, 240), 4)};
    merge(channels, 3, colour);
    merge(channels, 4, colourAlpha);
    expectDescriptorsOfOrb(Parameters(), colour);
    expectDescriptorsOfOrb(Parameters(), colourAlpha);
}

TEST(Aqorb_OpenCVOrb, descriptors_equal_on_photographs)
{
    AQORB_NEEDS_DATA();
    AQORB_NEEDS_FMA_BLUR();
    RNG rng(4);
    const std::vector<Mat> images = photographs();
    for (size_t i = 0; i < images.size(); i++)
    {
        SCOPED_TRACE(i);
        expectDescriptorsOfOrb(Parameters(), images[i]);
        for (int j = 0; j < 8; j++)
            expectDescriptorsOfOrb(randomParameters(rng, images[i].size()), images[i]);
    }
}

TEST(Aqorb_OpenCVOrb, compute_equal_on_its_keypoints)
{
    AQORB_NEEDS_FMA_BLUR();
    RNG rng(5);
    for (int i = 0; i < 60; i++)
    {
        SCOPED_TRACE(i);
        const Mat scene = makeScene(Size(rng.uniform(80, 260), rng.uniform(80, 260)), i + 1);
        const Parameters p = randomParameters(rng, scene.size());
        const KeyPoints keypoints = orbKeypoints(p, scene);
        expectSameCompute(p, scene, keypoints);
    }
}

TEST(Aqorb_OpenCVOrb, compute_equal_on_its_keypoints_of_photographs)
{
    AQORB_NEEDS_DATA();
    AQORB_NEEDS_FMA_BLUR();
    RNG rng(6);
    const std::vector<Mat> images = photographs();
    for (size_t i = 0; i < images.size(); i++)
    {
        SCOPED_TRACE(i);
        expectSameCompute(Parameters(), images[i], orbKeypoints(Parameters(), images[i]));
        for (int j = 0; j < 5; j++)
        {
            const Parameters p = randomParameters(rng, images[i].size());
            expectSameCompute(p, images[i], orbKeypoints(p, images[i]));
        }
    }
}

TEST(Aqorb_OpenCVOrb, compute_drops_at_border_and_sorts_as_orb)
{
    AQORB_NEEDS_FMA_BLUR();
    RNG rng(7);
    for (int i = 0; i < 40; i++)
    {
        SCOPED_TRACE(i);
        const Mat scene = makeScene(Size(rng.uniform(80, 260), rng.uniform(80, 260)), i + 1);
        const Parameters p = randomParameters(rng, scene.size());
        expectSameCompute(p, scene, arbitraryKeypoints(rng, scene.size(), p.nlevels, 300));
    }
}

TEST(Aqorb_OpenCVOrb, compute_drops_points_outside_as_orb)
{
    // With edgeThreshold 0 cv::ORB::compute keeps points outside and reads beyond its memory for them.
    AQORB_NEEDS_FMA_BLUR();
    const Mat scene = makeScene(Size(200, 150));
    KeyPoints keypoints;
    for (int y = -40; y < 200; y += 4)
    {
        for (int x = -40; x < 250; x += 4)
            keypoints.push_back(KeyPoint(Point2f(x + 0.5f, y + 0.5f), 31.f, 77.f, 1.f, 0, x));
    }
    Parameters p;
    for (int edgeThreshold : {1, 2, 16, 31, 74, 75, 76, 100})
    {
        p.edgeThreshold = edgeThreshold;
        expectSameCompute(p, scene, keypoints);
    }
}

TEST(Aqorb_OpenCVOrb, compute_builds_the_levels_of_the_keypoints)
{
    // Whatever nlevels says: levels beyond it are built, too.
    AQORB_NEEDS_FMA_BLUR();
    RNG rng(8);
    const Mat scene = makeScene(Size(320, 240));
    Parameters p;
    p.nlevels = 1;
    p.edgeThreshold = 16;
    const KeyPoints keypoints = arbitraryKeypoints(rng, scene.size(), 12, 400);
    expectSameCompute(p, scene, keypoints);
    KeyPoints kept = keypoints;
    Mat descriptors;
    p.ours()->compute(scene, kept, descriptors);
    EXPECT_EQ(11, kept.back().octave);
    for (size_t i = 1; i < kept.size(); i++)
        ASSERT_LE(kept[i - 1].octave, kept[i].octave);
}

TEST(Aqorb_OpenCVOrb, compute_takes_octaves_beyond_the_levels)
{
    // Up to the last octave whose level has a pixel.
    AQORB_NEEDS_FMA_BLUR();
    RNG rng(9);
    const Mat scene = makeScene(Size(800, 600));
    Parameters p;
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
    EXPECT_NO_THROW(p.ours()->compute(scene, keypoints, descriptors));
    keypoints[0].octave = 39;
    EXPECT_THROW(p.ours()->compute(scene, keypoints, descriptors), cv::Exception);
    EXPECT_EQ(1u, keypoints.size());
}

TEST(Aqorb_OpenCVOrb, compute_drops_at_every_side_and_corner_as_orb)
{
    // Points in steps of an eighth of a pixel across each side and each corner of the image.
    AQORB_NEEDS_FMA_BLUR();
    const Mat scene = makeScene(Size(141, 107));
    Parameters p;
    for (int edgeThreshold : {0, 1, 16, 31})
    {
        p.edgeThreshold = edgeThreshold;
        std::vector<float> xs(1, 70.25f), ys(1, 53.25f);
        const float reach = edgeThreshold == 0 ? 0.f : 2.f;  // cv::ORB keeps points outside with 0
        for (float d = -2; d <= 2; d += 0.125f)
        {
            if (edgeThreshold + d >= -0.5f)
            {
                xs.push_back(edgeThreshold + d);
                ys.push_back(edgeThreshold + d);
            }
            if (d < reach)
            {
                xs.push_back(scene.cols - edgeThreshold + d);
                ys.push_back(scene.rows - edgeThreshold + d);
            }
        }
        KeyPoints keypoints;
        for (float y : ys)
        {
            for (float x : xs)
            {
                for (int octave : {0, 1, 3})
                    keypoints.push_back(
                        KeyPoint(Point2f(x, y), 31.f, x + y, 1.f, octave, int(keypoints.size())));
            }
        }
        for (int firstLevel : {0, 1})
        {
            p.firstLevel = firstLevel;
            expectSameCompute(p, scene, keypoints);
        }
    }
}

TEST(Aqorb_OpenCVOrb, compute_keeps_order_within_sorted_octaves_and_all_fields)
{
    const Mat scene = makeScene(Size(200, 200));
    KeyPoints keypoints;
    const int octaves[] = {0, 0, 2, 2, 5};
    for (int i = 0; i < 5; i++)
        keypoints.push_back(
            KeyPoint(Point2f(120.25f - 10.f * i, 90.75f), 3.f + i, 10.f * i, -1.f * i, octaves[i], 100 - i));
    const KeyPoints before = keypoints;
    Mat descriptors;
    AdaptiveQuadtreeORB::create()->compute(scene, keypoints, descriptors);
    EXPECT_TRUE(sameKeypoints(before, keypoints));
    EXPECT_EQ(5, descriptors.rows);
}

void expectNoFewerThanOrb(const Parameters& p, const Mat& image)
{
    SCOPED_TRACE(p.text());
    KeyPoints ours, theirs;
    p.ours()->detect(image, ours);
    p.theirs()->detect(image, theirs);
    // By rounding, or by ties with FAST_SCORE, cv::ORB may exceed nfeatures; we never do.
    EXPECT_GE(ours.size(), std::min(theirs.size(), size_t(p.nfeatures)));
    EXPECT_LE(ours.size(), size_t(p.nfeatures));
}

TEST(Aqorb_OpenCVOrb, never_fewer_keypoints)
{
    RNG rng(9);
    for (int i = 0; i < 60; i++)
    {
        SCOPED_TRACE(i);
        const Size size(rng.uniform(60, 260), rng.uniform(60, 260));
        Parameters p = randomParameters(rng, size);
        const Mat image = i % 6 == 0 ? makeNoise(size, i) : makeScene(size, i + 1);
        expectNoFewerThanOrb(p, image);
        p.nfeatures = 10000;
        expectNoFewerThanOrb(p, image);
    }
    Parameters p;
    p.nfeatures = 10000;
    expectNoFewerThanOrb(p, makeScene(Size(640, 480)));
    expectNoFewerThanOrb(p, makeNoise(Size(640, 480)));
}

TEST(Aqorb_OpenCVOrb, never_fewer_keypoints_on_photographs)
{
    AQORB_NEEDS_DATA();
    const std::vector<Mat> images = photographs();
    for (size_t i = 0; i < images.size(); i++)
    {
        SCOPED_TRACE(i);
        Parameters p;
        for (int nfeatures : {1, 7, 500, 2000, 10000})
        {
            p.nfeatures = nfeatures;
            expectNoFewerThanOrb(p, images[i]);
        }
        p.edgeThreshold = 16;
        p.fastThreshold = 7;
        expectNoFewerThanOrb(p, images[i]);
    }
}

}  // namespace
}  // namespace opencv_test
