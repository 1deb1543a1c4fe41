// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "reference.hpp"

#include "plan.hpp"
#include "pyramid.hpp"

#include <numeric>

// What must hold for any image and any parameters, on thousands of small random cases. A failure prints the
// seed and the parameters of its case.

namespace opencv_test
{
namespace
{

using reference::randomSettings;
using reference::Settings;

Mat randomImage(RNG& rng, Size size)
{
    const int seed = rng.uniform(1, 1 << 20);
    Mat image;
    switch (rng.uniform(0, 5))
    {
    case 0:
        return makeNoise(size, seed);
    case 1:
        cv::GaussianBlur(makeNoise(size, seed), image, Size(), 1 + seed % 3);
        return image;
    case 2:
        return makeScene(size, seed) * 0.1;
    case 3:
        // corners on coarse levels
        cv::resize(makeNoise(Size(12 + seed % 20, 12), seed), image, size, 0, 0, INTER_CUBIC);
        return image;
    default:
        return makeScene(size, seed);
    }
}

Mat randomMask(RNG& rng, Size size)
{
    Mat mask(size, CV_8UC1, Scalar(rng.uniform(1, 256)));
    for (int i = rng.uniform(1, 30); i > 0; i--)
        rectangle(mask, Rect(rng.uniform(0, size.width), rng.uniform(0, size.height), 1 + i / 3, 1 + i),
                  Scalar(0), -1);
    return mask;
}

Size randomSize(RNG& rng)
{
    return Size(rng.uniform(10, 130), rng.uniform(10, 110));
}

TEST(Aqorb_Properties, cap_mask_fields_and_determinism)
{
    size_t found = 0;
    Ptr<AdaptiveQuadtreeORB> used;
    for (int seed = 1; seed <= 3000; seed++)
    {
        RNG rng(seed);
        const Settings s = randomSettings(rng);
        SCOPED_TRACE(format("seed %d: ", seed) + s.text());
        const Mat image = randomImage(rng, randomSize(rng));
        const Mat mask = seed % 2 ? randomMask(rng, image.size()) : Mat();
        // Of ten cases nine use one object, with one set of parameters.
        if (seed % 10 == 1)
            used = s.create();
        const int nfeatures = used->getMaxFeatures(), nlevels = used->getNLevels();
        const Features features = detectAndCompute(*used, image, mask);

        ASSERT_LE(features.keypoints.size(), size_t(nfeatures));
        ASSERT_EQ(int(features.keypoints.size()), features.descriptors.rows);
        for (const KeyPoint& k : features.keypoints)
        {
            ASSERT_TRUE(k.pt.x >= 0 && k.pt.y >= 0 && k.pt.x <= float(image.cols - 1) &&
                        k.pt.y <= float(image.rows - 1));
            ASSERT_TRUE(k.octave >= 0 && k.octave < nlevels);
            ASSERT_TRUE(k.angle >= 0 && k.angle < 360 && std::isfinite(k.response));
            ASSERT_TRUE(mask.empty() || mask.at<uchar>(cvRound(k.pt.y), cvRound(k.pt.x)) != 0);
        }
        ASSERT_TRUE(sameFeatures(features, detectAndCompute(*used, image.clone(), mask)));
        found += features.keypoints.size();
    }
    EXPECT_GT(found, 10000u);
}

TEST(Aqorb_Properties, quotas_add_up_to_the_number_of_features)
{
    RNG rng(1);
    for (int i = 0; i < 20000; i++)
    {
        const int n = rng.uniform(0, 3) ? rng.uniform(0, 3000) : int(rng.next() >> 1);
        const double factor = rng.uniform(1.001, 4.);
        const int nlevels = rng.uniform(1, 40);
        const std::vector<int> quotas = aqorb::levelQuotas(n, factor, nlevels);
        ASSERT_EQ(size_t(nlevels), quotas.size());
        ASSERT_EQ(reference::quotas(n, factor, nlevels), quotas) << n << " " << factor << " " << nlevels;
        ASSERT_GE(*std::min_element(quotas.begin(), quotas.end()), 0) << n << " " << factor << " " << nlevels;
        ASSERT_EQ(n, std::accumulate(quotas.begin(), quotas.end(), int64(0)))
            << n << " " << factor << " " << nlevels;
    }
}

TEST(Aqorb_Properties, as_many_features_as_there_are_corners)
{
    // If nfeatures is large enough, every corner becomes a keypoint. If not, exactly nfeatures of them do. (That these are
    // the corners of cv::FAST is among the promises.)
    int64 corners = 0;
    for (int seed = 1; seed <= 400; seed++)
    {
        RNG rng(seed);
        const Settings s = randomSettings(rng);
        SCOPED_TRACE(format("seed %d: ", seed) + s.text());
        const Mat image = randomImage(rng, randomSize(rng));
        const Mat mask = seed % 3 ? Mat() : randomMask(rng, image.size());
        const Ptr<AdaptiveQuadtreeORB> detector = s.create();
        KeyPoints keypoints;
        detector->setMaxFeatures(1 << 20);
        detector->detect(image, keypoints, mask);
        const int all = int(keypoints.size());
        corners += all;
        for (int i = 0; i < 4; i++)
        {
            const int n = rng.uniform(0, all + 10);
            detector->setMaxFeatures(n);
            detector->detect(image, keypoints, mask);
            ASSERT_EQ(std::min(n, all), int(keypoints.size())) << "nfeatures " << n;
        }
    }
    EXPECT_GT(corners, 10000);
}

TEST(Aqorb_Properties, more_features_keep_the_others)
{
    // On one level with a quadtree of given depth the choice is a prefix of a sequence that does not depend
    // on nfeatures. (With several levels a quota may shrink as nfeatures grows, by what coarser levels
    // leave over; with -1 the depth grows, and with it shrinks the disc in which corners are ranked.)
    size_t compared = 0;
    for (int seed = 1; seed <= 400; seed++)
    {
        RNG rng(seed);
        Settings s = reference::randomSettings(rng);
        s.nlevels = 1;
        s.firstLevel = 0;
        s.maxDepth = rng.uniform(0, 7);
        s.rankRadius = 0;
        SCOPED_TRACE(format("seed %d: ", seed) + s.text());
        const Mat image = randomImage(rng, randomSize(rng));
        const Ptr<AdaptiveQuadtreeORB> detector = s.create();
        KeyPoints fewer, more;
        for (int n = 0; n <= 300; n += rng.uniform(1, 90))
        {
            detector->setMaxFeatures(n);
            detector->detect(image, more);
            size_t found = 0;  // of the fewer ones, which must be there unchanged and in the same order
            for (const KeyPoint& k : more)
                found += found < fewer.size() && sameKeypoints(KeyPoints(1, k), KeyPoints(1, fewer[found]));
            ASSERT_EQ(fewer.size(), found) << "nfeatures " << n;
            compared += found;
            fewer = more;
        }
    }
    EXPECT_GT(compared, 10000u);
}

TEST(Aqorb_Properties, the_scene_moved_by_whole_cells_gives_the_same_moved)
{
    // On one level with a fixed threshold: a move by whole cells of the mesh and whole groups of the
    // quadtree's leaves, of a scene on flat ground that the frame does not cut, nor a disc in which its
    // corners are ranked.
    const int EDGE = 16, ROOT = 256, GROUP = 64, FROM_CORNERS = 20;  // to the side of the root
    size_t compared = 0;
    for (int seed = 1; seed <= 300; seed++)
    {
        RNG rng(seed);
        Settings s = reference::randomSettings(rng);
        s.nfeatures = rng.uniform(1, 150);
        s.nlevels = 1;
        s.firstLevel = 0;
        s.edgeThreshold = EDGE;
        s.patchSize = 31;
        s.adaptiveThreshold = false;
        s.cellSize = 8 << rng.uniform(0, 4);  // 8 to 64
        s.maxDepth = rng.uniform(0, 4);       // 2^depth leaves over ROOT, 4 to a group
        if (s.maxDepth > 0)
            s.maxDepth += 2;  // 8 to 32 leaves, groups of 128 to 32 pixels
        s.rankRadius = std::min(s.rankRadius, FROM_CORNERS * std::sqrt(double(s.nfeatures)) / ROOT);
        const int step = s.maxDepth == 3 ? 2 * GROUP : GROUP;
        SCOPED_TRACE(format("seed %d: ", seed) + s.text());

        const Mat scene = randomImage(rng, Size(50, 45));
        const Point place(EDGE + 26 + rng.uniform(0, 20), EDGE + 26 + rng.uniform(0, 20));
        const int columns = (ROOT - 72 - place.x + EDGE - 26) / step,
                  rows = (ROOT - 67 - place.y + EDGE - 26) / step;
        const Point shift(step * rng.uniform(0, columns + 1), step * rng.uniform(0, rows + 1));
        Mat images[2];
        for (int i = 0; i < 2; i++)
        {
            images[i].create(ROOT + 2 * EDGE, ROOT + 2 * EDGE, CV_8UC1);
            images[i].setTo(90);
            scene.copyTo(images[i](Rect(place + (i ? shift : Point()), scene.size())));
        }
        const Ptr<AdaptiveQuadtreeORB> detector = s.create();
        Features first = detectAndCompute(*detector, images[0]);
        const Features second = detectAndCompute(*detector, images[1]);
        ASSERT_EQ(first.keypoints.size(), second.keypoints.size());
        for (size_t i = 0; i < first.keypoints.size(); i++)
        {
            KeyPoint& moved = first.keypoints[i];
            moved.pt += Point2f(shift);
            // A fraction of a pixel is rounded to another float further right and down.
            const Point2f d = moved.pt - second.keypoints[i].pt;
            ASSERT_LE(std::max(std::abs(d.x), std::abs(d.y)), s.subPixel ? 1e-4f : 0.f);
            moved.pt = second.keypoints[i].pt;
        }
        ASSERT_TRUE(sameFeatures(first, second));
        compared += shift != Point() ? first.keypoints.size() : 0;
    }
    EXPECT_GT(compared, 3000u);
}

TEST(Aqorb_Properties, a_mask_takes_corners_away_and_nothing_else)
{
    // This holds on one level where corners do not compete: with one fixed threshold, without suppression,
    // and with an nfeatures that no image reaches.
    size_t removed = 0, compared = 0;
    for (int seed = 1; seed <= 500; seed++)
    {
        RNG rng(seed);
        Settings s = reference::randomSettings(rng);
        s.nfeatures = 1 << 20;
        s.nlevels = 1;
        s.firstLevel = 0;
        s.scoreType = ORB::FAST_SCORE;
        s.adaptiveThreshold = false;
        s.minThresholdRatio = 1;
        s.subPixel = false;
        SCOPED_TRACE(format("seed %d: ", seed) + s.text());
        const Mat image = randomImage(rng, randomSize(rng)), mask = randomMask(rng, image.size());
        const Ptr<AdaptiveQuadtreeORB> detector = s.create();
        KeyPoints all, masked;
        detector->detect(image, all);
        detector->detect(image, masked, mask);
        removed += all.size() - std::min(all.size(), masked.size());
        compared += masked.size();
        all.erase(std::remove_if(all.begin(), all.end(),
                                 [&](const KeyPoint& k)
                                 { return mask.at<uchar>(int(k.pt.y), int(k.pt.x)) == 0; }),
                  all.end());
        ASSERT_TRUE(sameKeypoints(all, masked));
    }
    EXPECT_GT(removed, 1000u);
    EXPECT_GT(compared, 1000u);
}

TEST(Aqorb_Properties, retain_uniform_keeps_as_many_as_there_are_inside)
{
    for (int seed = 1; seed <= 2000; seed++)
    {
        RNG rng(seed);
        SCOPED_TRACE(seed);
        const Size size(rng.uniform(1, 300), rng.uniform(1, 300));
        KeyPoints given(rng.uniform(0, 200));
        int inside = 0;
        for (size_t i = 0; i < given.size(); i++)
        {
            given[i] = KeyPoint(Point2f(rng.uniform(-20.f, 320.f), rng.uniform(-20.f, 320.f)), 7.f, 0.f,
                                rng.uniform(0.f, 1.f), 0, int(i));
            const Point2f p = given[i].pt;
            inside += p.x >= 0 && p.y >= 0 && p.x < float(size.width) && p.y < float(size.height);
        }
        const int n = rng.uniform(0, 220);
        KeyPoints kept = given;
        aqorb::retainUniform(kept, size, n);
        ASSERT_EQ(std::min(n, inside), int(kept.size()));
        int last = -1;
        for (const KeyPoint& k : kept)
        {
            ASSERT_GT(k.class_id, last);  // They keep their order.
            ASSERT_TRUE(sameKeypoints(KeyPoints(1, k), KeyPoints(1, given[k.class_id])));
            last = k.class_id;
        }
    }
}

}  // namespace
}  // namespace opencv_test
