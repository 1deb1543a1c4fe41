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

Features expectAsReferenceWithItsSelection(const Settings& settings, const Mat& image,
                                           const Mat& mask = Mat())
{
    SCOPED_TRACE(format("image of %d x %d, ", image.cols, image.rows) + settings.text());
    const Features expected = reference::detectAndCompute(image, mask, settings);
    const Ptr<AdaptiveQuadtreeORB> detector = settings.create();
    EXPECT_TRUE(sameFeatures(detectAndCompute(*detector, image, mask), expected));
    // The second run finds what the first has left in the work space, and uses the baseline kernels.
    WithoutOptimization baseline;
    const Features found = detectAndCompute(*detector, image, mask);
    EXPECT_TRUE(sameFeatures(found, expected));
    if (settings.firstLevel == 0)
    {
        EXPECT_TRUE(finds(*detector, image, mask, expected)) << "compute drops detected keypoints";
    }
    return found;
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

TEST(Aqorb_Pipeline, equals_reference_by_default)
{
    Mat squares(SMALL_IMAGE, CV_8UC1, Scalar(0)), lamps = squares.clone();
    for (int i = 0; i < 12; i++)
    {
        rectangle(squares, Rect(15 + 45 * (i % 3), 12 + 26 * (i / 3), 33, 19), Scalar(255), -1);
        circle(lamps, Point(20 + 11 * i, 30 + 37 * i % 70), 2, Scalar(255), -1);
    }
    std::vector<Mat> images = {squares,
                               ~squares,
                               makeNoise(SMALL_IMAGE) > 128,  // the largest derivatives
                               lamps,                         // equation (7) is far beyond 254
                               makeScene(SMALL_IMAGE, 9) * 0.08,
                               Mat(SMALL_IMAGE, CV_8UC1, Scalar(0)),
                               Mat(SMALL_IMAGE, CV_8UC1, Scalar(77))};
    for (int seed = 1; seed <= 5; seed++)
        images.push_back(makeScene(Size(320, 240), seed));
    for (const Mat& image : images)
        expectAsReference(Settings(), image);
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

// Random settings, many of them at their limits.
Settings settingsAtLimits(RNG& rng)
{
    const auto among = [&](const std::vector<double>& values)
    { return values[size_t(rng.uniform(0, int(values.size())))]; };
    Settings s = reference::randomSettings(rng);
    s.nfeatures = int(among({0, 1, 2, 7, 50, 150, 300, 500, 10000, INT_MAX}));
    s.scaleFactor = among({1.1f, 1.2f, 1.2f, 1.5f, 1.8f, 2.5f, 4, s.scaleFactor});
    s.nlevels = rng.uniform(1, 9);
    s.firstLevel = rng.uniform(0, std::min(s.nlevels, s.scaleFactor < 1.3 ? 3 : s.scaleFactor < 3 ? 2 : 1));
    s.edgeThreshold = int(among({0, 3, 4, 5, 8, 16, 31, double(s.edgeThreshold)}));
    s.patchSize = int(among({2, 3, 8, 15, 31, 47, double(s.patchSize)}));
    s.fastThreshold = int(among({INT_MIN, 0, 1, 7, 20, 20, 60, 255, 256, INT_MAX, double(s.fastThreshold)}));
    s.minThresholdRatio = among({1, 1.5, 4, 10, s.minThresholdRatio});
    s.strengthWeight = among({0, 1e-3, 0.05, 0.15, 2, 1000, s.strengthWeight});
    s.rankRadius = among({0, 0.5, 1, 3, 16, s.rankRadius});
    // The last distance is infinite in pixels of the image.
    s.octaveSuppression = among({-1, -1, 0, 0.6, 3, 40, s.octaveSuppression, DBL_MAX});
    return s;
}

TEST(Aqorb_Properties, cap_mask_fields_and_equality_with_the_reference)
{
    size_t found = 0;
    for (int seed = 1; seed <= 1200; seed++)
    {
        RNG rng(seed);
        const Settings s = settingsAtLimits(rng);
        SCOPED_TRACE(format("seed %d", seed));
        Size size(rng.uniform(1, 165), rng.uniform(1, 125));
        if (rng.uniform(0, 6) == 0)
            size.width = 2 * s.edgeThreshold + rng.uniform(1, 3);  // hardly a pixel within the border
        std::vector<Mat> planes;
        for (int i = rng.uniform(0, 5) ? 1 : rng.uniform(3, 5); i > 0; i--)
            planes.push_back(randomImage(rng, size));
        Mat image;
        merge(planes, image);
        if (planes.size() == 1)
            image = atOffset(image, seed % 64);
        // Any value but 0 is usable, also 1 on all levels.
        const Mat mask = rng.uniform(0, 2) ? Mat(randomMask(rng, size) & (seed % 3 ? 1 : 255)) : Mat();
        const Features features = expectAsReferenceWithItsSelection(s, image, mask);
        ASSERT_LE(features.keypoints.size(), size_t(s.nfeatures));
        ASSERT_EQ(int(features.keypoints.size()), features.descriptors.rows);
        for (const KeyPoint& k : features.keypoints)
        {
            ASSERT_TRUE(k.pt.x >= 0 && k.pt.y >= 0 && k.pt.x < float(size.width) &&
                        k.pt.y < float(size.height));
            ASSERT_TRUE(k.octave >= 0 && k.octave < s.nlevels);
            ASSERT_TRUE(k.angle >= 0 && k.angle < 360 && std::isfinite(k.response));
            ASSERT_TRUE(mask.empty() || mask.at<uchar>(cvRound(k.pt.y), cvRound(k.pt.x)) != 0);
        }
        found += features.keypoints.size();
    }
    EXPECT_GT(found, 10000u);
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

}  // namespace
}  // namespace opencv_test
