// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// Performance of AdaptiveQuadtreeORB, or of cv::ORB, with default parameters.

#include "perf_precomp.hpp"

namespace opencv_test
{
namespace
{

typedef tuple<std::string, int> Image_NFeatures_t;

class Features : public perf::TestBaseWithParam<Image_NFeatures_t>
{
protected:
    void detectAndCompute();
};

//! Growth of the time with the size of the image and with the number of features.
typedef Features Scaling;

#define FEATURES_PARAMS                                                                        \
    testing::Combine(testing::Values("leuven", "bikes", "bark", "trees", "ubc", "640x512.png", \
                                     "1920x1080.png", "scene_640x480", "scene_1920x1080"),     \
                     testing::Values(500, 1000, 2000))

#define SCALING_PARAMS                                                                                      \
    testing::Combine(testing::Values("scene_320x240", "scene_640x480", "scene_1280x720", "scene_1920x1080", \
                                     "scene_3840x2160"),                                                    \
                     testing::Values(250, 500, 1000, 2000, 4000, 8000))

Ptr<Feature2D> createDetector(int nfeatures)
{
    if (isOfOpenCV())
        return ORB::create(nfeatures);
    return aqorb::AdaptiveQuadtreeORB::create(nfeatures);
}

void Features::detectAndCompute()
{
    const Mat image = loadImage(get<0>(GetParam()));
    Ptr<Feature2D> detector = createDetector(get<1>(GetParam()));
    std::vector<KeyPoint> keypoints;
    Mat descriptors;
    detector->detectAndCompute(image, noArray(), keypoints, descriptors);  // fills caches and allocates

    TEST_CYCLE() detector->detectAndCompute(image, noArray(), keypoints, descriptors);

    EXPECT_GT(keypoints.size(), 20u);
    EXPECT_EQ((int)keypoints.size(), descriptors.rows);
    SANITY_CHECK_NOTHING();
}

PERF_TEST_P(Features, detectAndCompute, FEATURES_PARAMS)
{
    detectAndCompute();
}

PERF_TEST_P(Scaling, detectAndCompute, SCALING_PARAMS)
{
    detectAndCompute();
}

PERF_TEST_P(Features, detect, FEATURES_PARAMS)
{
    const Mat image = loadImage(get<0>(GetParam()));
    Ptr<Feature2D> detector = createDetector(get<1>(GetParam()));
    std::vector<KeyPoint> keypoints;
    detector->detect(image, keypoints);

    TEST_CYCLE() detector->detect(image, keypoints);

    EXPECT_GT(keypoints.size(), 20u);
    SANITY_CHECK_NOTHING();
}

PERF_TEST_P(Features, compute, FEATURES_PARAMS)
{
    const Mat image = loadImage(get<0>(GetParam()));
    // cv::ORB's keypoints for both detectors: they lie inside both borders, so neither detector drops any.
    std::vector<KeyPoint> keypoints;
    ORB::create(get<1>(GetParam()))->detect(image, keypoints);
    const size_t given = keypoints.size();
    Ptr<Feature2D> detector = createDetector(get<1>(GetParam()));
    Mat descriptors;
    detector->compute(image, keypoints, descriptors);

    TEST_CYCLE() detector->compute(image, keypoints, descriptors);

    EXPECT_GT(given, 20u);
    EXPECT_EQ(given, keypoints.size());
    EXPECT_EQ((int)given, descriptors.rows);
    SANITY_CHECK_NOTHING();
}

}  // namespace
}  // namespace opencv_test
