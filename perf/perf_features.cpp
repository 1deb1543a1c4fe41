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

typedef perf::TestBaseWithParam<tuple<std::string, int>> Features;

PERF_TEST_P(Features, detectAndCompute,
            testing::Combine(testing::Values("leuven", "bikes", "bark", "trees", "ubc", "640x512.png",
                                             "1920x1080.png", "scene_640x480", "scene_1920x1080"),
                             testing::Values(500, 1000, 2000)))
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

}  // namespace
}  // namespace opencv_test
