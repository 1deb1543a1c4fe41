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

void Features::detectAndCompute()
{
    const Mat image = loadImage(get<0>(GetParam()));
    const int nfeatures = get<1>(GetParam());
    const Ptr<ORB> detector =
        isOfOpenCV() ? ORB::create(nfeatures) : Ptr<ORB>(aqorb::AdaptiveQuadtreeORB::create(nfeatures));
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

}  // namespace
}  // namespace opencv_test
