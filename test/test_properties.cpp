// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "reference.hpp"

#include "selection.hpp"
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

}  // namespace
}  // namespace opencv_test
