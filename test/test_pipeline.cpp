// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "reference.hpp"

#include <climits>

namespace opencv_test
{
namespace
{

using reference::Settings;

const Size SMALL_IMAGE(161, 123);

void expectAsReferenceWithItsSelection(const Settings& settings, const Mat& image, const Mat& mask = Mat())
{
    SCOPED_TRACE(format("image of %d x %d, ", image.cols, image.rows) + settings.text());
    const Features expected = reference::detectAndCompute(image, mask, settings);
    const Ptr<AdaptiveQuadtreeORB> detector = settings.create();
    EXPECT_TRUE(sameFeatures(detectAndCompute(*detector, image, mask), expected));
    // The second run finds what the first has left in the work space, and uses the baseline kernels.
    WithoutOptimization baseline;
    EXPECT_TRUE(sameFeatures(detectAndCompute(*detector, image, mask), expected));
}

// With both selections.
void expectAsReference(Settings settings, const Mat& image, const Mat& mask = Mat())
{
    for (const auto type : {AdaptiveQuadtreeORB::RANKED_SELECTION, AdaptiveQuadtreeORB::QUADTREE_SELECTION})
    {
        settings.selectionType = type;
        expectAsReferenceWithItsSelection(settings, image, mask);
    }
}

// One scene full of corners of all kinds, one of noise.
void expectAsReferenceOnScenes(const Settings& settings)
{
    expectAsReference(settings, makeScene(SMALL_IMAGE, 3));
    expectAsReference(settings, makeNoise(Size(118, 97), 5));
}

TEST(Aqorb_Pipeline, equals_reference_by_default)
{
    for (int seed = 1; seed <= 5; seed++)
        expectAsReference(Settings(), makeScene(Size(320, 240), seed));
    expectAsReferenceOnScenes(Settings());
}

TEST(Aqorb_Pipeline, equals_reference_on_photographs)
{
    AQORB_NEEDS_DATA();
    for (const Mat& photograph : photographs())
    {
        const Size size(240, 180);
        expectAsReference(Settings(), photograph(Rect(Point(photograph.size() - size) / 2, size)));
    }
}

TEST(Aqorb_Pipeline, equals_reference_for_every_number_of_features)
{
    const int numbers[] = {0, 1, 2, 7, 50, 500, 10000, INT_MAX};
    for (int n : numbers)
    {
        Settings settings;
        settings.nfeatures = n;
        expectAsReferenceOnScenes(settings);
        settings.scoreType = ORB::FAST_SCORE;
        expectAsReferenceOnScenes(settings);
    }
}

TEST(Aqorb_Pipeline, equals_reference_for_every_strength_weight_and_rank_radius)
{
    const double weights[] = {0, 1e-3, 0.15, 2, 1000}, radii[] = {0, 0.5, 1, 3, 16};
    const Mat scene = makeScene(SMALL_IMAGE, 21), noise = makeNoise(Size(118, 97), 5);
    for (double weight : weights)
        for (double radius : radii)
            for (int n : {60, 400})
            {
                Settings settings;
                settings.strengthWeight = weight;
                settings.rankRadius = radius;
                settings.nfeatures = n;
                settings.scoreType = radius > 1 ? ORB::FAST_SCORE : ORB::HARRIS_SCORE;
                expectAsReferenceWithItsSelection(settings, scene);
                expectAsReferenceWithItsSelection(settings, noise);
            }
}

TEST(Aqorb_Pipeline, equals_reference_for_every_pyramid)
{
    const float factors[] = {1.1f, 1.2f, 1.8f, 2.5f};
    for (float factor : factors)
        for (int nlevels = 1; nlevels <= 8; nlevels += factor < 1.5f ? 3 : 1)
            for (int firstLevel = 0; firstLevel < std::min(nlevels, factor < 1.5f ? 3 : 2); firstLevel++)
            {
                Settings settings;
                settings.nfeatures = 150;
                settings.scaleFactor = factor;
                settings.nlevels = nlevels;
                settings.firstLevel = firstLevel;
                settings.edgeThreshold = 8;
                expectAsReference(settings, makeScene(Size(107, 90), nlevels));
            }
    Settings settings;
    settings.scaleFactor = 1.f;
    settings.nlevels = 1;
    expectAsReferenceOnScenes(settings);
}

TEST(Aqorb_Pipeline, equals_reference_for_every_border_and_patch)
{
    const int edges[] = {0, 3, 4, 16, 31}, patches[] = {2, 3, 8, 15, 31, 47};
    for (int edge : edges)
        for (int patch : patches)
        {
            Settings settings;
            settings.nfeatures = 300;
            settings.edgeThreshold = edge;
            settings.patchSize = patch;
            settings.WTA_K = 2 + (edge + patch) % 3;
            expectAsReference(settings, makeScene(SMALL_IMAGE, edge + patch));
        }
}

TEST(Aqorb_Pipeline, equals_reference_for_every_threshold)
{
    const int fastThresholds[] = {0, 1, 7, 20, 60, 255};
    const double ratios[] = {1, 1.5, 4, 10};
    for (int fast : fastThresholds)
        for (double ratio : ratios)
        {
            Settings settings;
            settings.fastThreshold = fast;
            settings.minThresholdRatio = ratio;
            expectAsReference(settings, makeScene(SMALL_IMAGE, fast));
            settings.adaptiveThreshold = false;
            expectAsReference(settings, makeScene(SMALL_IMAGE, fast));
        }
}

TEST(Aqorb_Pipeline, equals_reference_for_every_own_parameter)
{
    const ORB::ScoreType scores[] = {ORB::HARRIS_SCORE, ORB::FAST_SCORE};
    const double radii[] = {-1, 0, 0.6, 3, 40, DBL_MAX};  // the last one is infinite in pixels of the image
    for (ORB::ScoreType score : scores)
    {
        Settings settings;
        settings.scoreType = score;
        settings.nfeatures = 200;
        std::vector<Settings> changed(7, settings);
        size_t i = 0;
        for (double radius : radii)
            changed[i++].octaveSuppression = radius;
        changed[i].subPixel = false;
        for (const Settings& each : changed)
            expectAsReferenceOnScenes(each);
    }
}

// The image with some radii of octave suppression and some numbers of features.
void expectAsReferenceForRadii(const Mat& image, const std::vector<double>& radii, int least, int most,
                               int step)
{
    for (double radius : radii)
        for (int n = least; n <= most; n += step)
        {
            Settings settings;
            settings.nfeatures = n;
            settings.octaveSuppression = radius;
            settings.edgeThreshold = 5;
            expectAsReference(settings, image);
            settings.scoreType = ORB::FAST_SCORE;  // corners of one level may be near each other
            expectAsReference(settings, image);
        }
}

TEST(Aqorb_Pipeline, equals_reference_where_levels_lack_corners)
{
    // What fine levels leave over is offered to coarse ones, against the keypoints of finer ones.
    Mat smooth;
    GaussianBlur(makeScene(SMALL_IMAGE, 3), smooth, Size(), 1.5);
    expectAsReferenceForRadii(smooth, {0.5, 2, 6}, 10, 310, 30);
    // Noise enlarged eight times has the most corners on level 3: what level 0 leaves over is taken from
    // the rest of the coarse levels' sequences, against the keypoints of finer ones.
    cv::resize(makeNoise(Size(20, 16), 2), smooth, SMALL_IMAGE, 0, 0, INTER_CUBIC);
    expectAsReferenceForRadii(smooth, {0, 0.5, 2.5, 6}, 150, 550, 100);
}

TEST(Aqorb_Pipeline, equals_reference_where_one_level_has_almost_all_corners)
{
    // Faint dots are corners of the finest level only, which gets the quotas of all levels.
    Mat dots(240, 320, CV_8UC1, Scalar(128));
    RNG rng(1);
    for (int i = 0; i < 5000; i++)
        dots.at<uchar>(rng.uniform(0, dots.rows), rng.uniform(0, dots.cols)) = uchar(rng.uniform(150, 153));
    Settings settings;
    settings.adaptiveThreshold = false;
    settings.minThresholdRatio = 1;
    for (int n : {300, 400, 500})
    {
        settings.nfeatures = n;
        expectAsReference(settings, dots);
    }
}

TEST(Aqorb_Pipeline, equals_reference_where_octave_suppression_passes_over_most)
{
    // Of each level, about twice as many as its quota are put in order at first.
    const double radii[] = {2, 5, 12};
    for (double radius : radii)
    {
        Settings settings;
        settings.nfeatures = 300;
        settings.octaveSuppression = radius;
        const Mat scene = makeScene(Size(320, 240), 3);
        expectAsReference(settings, scene);
        Mat mask(scene.size(), CV_8UC1, Scalar(255));
        mask(Rect(100, 80, 60, 70)).setTo(0);
        expectAsReference(settings, scene, mask);
        settings.nlevels = 2;
        expectAsReference(settings, makeNoise(Size(240, 200), 4));
    }
}

TEST(Aqorb_Pipeline, equals_reference_with_masks)
{
    const Mat scene = makeScene(SMALL_IMAGE, 7);
    Mat ones(scene.size(), CV_8UC1, Scalar(1)), half(scene.size(), CV_8UC1, Scalar(0));
    Mat holes(scene.size(), CV_8UC1, Scalar(255)), zero(scene.size(), CV_8UC1, Scalar(0));
    half.colRange(50, half.cols).setTo(2);
    RNG rng(11);
    for (int i = 0; i < 60; i++)
        holes.at<uchar>(rng.uniform(0, holes.rows), rng.uniform(0, holes.cols)) = 0;
    circle(holes, Point(80, 60), 20, Scalar(0), -1);
    Mat dots(scene.size(), CV_8UC1, Scalar(0)), lines(scene.size(), CV_8UC1, Scalar(9)),
        corner = dots.clone();
    for (int i = 0; i < 1500; i++)
        dots.at<uchar>(rng.uniform(0, dots.rows), rng.uniform(0, dots.cols)) = 1;
    for (int i = 0; i < 12; i++)
        line(lines, Point(rng.uniform(0, 160), rng.uniform(0, 120)), Point(14 * i, 61), Scalar(0), 1 + i / 8);
    corner(Rect(120, 90, 41, 33)).setTo(255);
    const Mat masks[] = {ones, half, holes, zero, dots, lines, corner};
    for (int i = 0; i < 7; i++)
        for (int firstLevel = 0; firstLevel <= 2; firstLevel++)
        {
            SCOPED_TRACE(format("mask %d, first level %d", i, firstLevel));
            Settings settings;
            settings.edgeThreshold = 5;
            settings.firstLevel = firstLevel;
            settings.scaleFactor = firstLevel == 1 ? 1.5f : 1.2f;
            expectAsReference(settings, scene, masks[i]);
            settings.nfeatures = 40;
            expectAsReference(settings, scene, masks[i]);
            settings.nfeatures = 500;
            settings.subPixel = false;
            settings.scoreType = ORB::FAST_SCORE;
            settings.octaveSuppression = 3;
            expectAsReference(settings, scene, masks[i]);
        }
}

TEST(Aqorb_Pipeline, equals_reference_for_every_image_size)
{
    for (int i = 0; i < 40; i++)
    {
        RNG rng(100 + i);
        Size size(rng.uniform(1, 100), rng.uniform(1, 90));
        if (i % 4 == 0)
            size = Size(2 * (i % 20) + 1 + i / 20, i < 20 ? 90 : 2 * (i % 20) + 4);  // hardly a root
        Settings settings;
        settings.edgeThreshold = i % 20;
        settings.nfeatures = 3;
        settings.scaleFactor = 1.3f;
        expectAsReference(settings, makeNoise(size, i));
        settings.nfeatures = 20 + 10 * i;
        expectAsReference(settings, atOffset(makeNoise(size, i), i));
        if (std::min(size.width, size.height) > 10)
            expectAsReference(settings, atOffset(makeScene(size, i), 63 - i));
    }
}

TEST(Aqorb_Pipeline, equals_reference_in_colour)
{
    Mat planes[] = {makeScene(SMALL_IMAGE, 1), makeScene(SMALL_IMAGE, 2), makeScene(SMALL_IMAGE, 3),
                    makeNoise(SMALL_IMAGE)};
    Mat bgr, bgra;
    merge(planes, 3, bgr);
    merge(planes, 4, bgra);
    expectAsReference(Settings(), bgr);
    expectAsReference(Settings(), bgra);
}

// The largest derivatives and moments that there are.
TEST(Aqorb_Pipeline, equals_reference_at_the_largest_contrast)
{
    Mat squares(SMALL_IMAGE, CV_8UC1, Scalar(0));
    for (int i = 0; i < 12; i++)
        rectangle(squares, Rect(15 + 45 * (i % 3), 12 + 26 * (i / 3), 33, 19), Scalar(255), -1);
    expectAsReference(Settings(), squares);
    expectAsReference(Settings(), ~squares);
    expectAsReference(Settings(), makeNoise(SMALL_IMAGE) > 128);
}

TEST(Aqorb_Pipeline, equals_reference_in_the_dark_and_without_corners)
{
    for (int grey : {0, 77})
        expectAsReference(Settings(), Mat(SMALL_IMAGE, CV_8UC1, Scalar(grey)));
    const Mat scene = makeScene(SMALL_IMAGE, 9) * 0.08;
    expectAsReference(Settings(), scene);
    // a few lamps: equation (7) is far beyond 254
    Mat lamps = Mat::zeros(SMALL_IMAGE, CV_8UC1);
    for (int i = 0; i < 12; i++)
        circle(lamps, Point(20 + 11 * i, 30 + 37 * i % 70), 2, Scalar(255), -1);
    expectAsReference(Settings(), lamps);
}

}  // namespace
}  // namespace opencv_test
