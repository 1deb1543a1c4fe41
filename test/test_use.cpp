// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "test_precomp.hpp"

namespace opencv_test
{
namespace
{

TEST(Aqorb_Use, in_affine_feature)
{
    const Ptr<AffineFeature> affine = AffineFeature::create(AdaptiveQuadtreeORB::create(100), 2, 0);
    const Features features = detectAndCompute(*affine, makeScene(Size(200, 160)));
    EXPECT_GT(features.keypoints.size(), 200u);
    EXPECT_EQ((int)features.keypoints.size(), features.descriptors.rows);
}

// Matches of an image with itself turned by 90 degrees: pixels are the same.
void expectMatches(int WTA_K)
{
    const Mat image = makeScene(Size(300, 300), 3);
    Mat turned;
    rotate(image, turned, ROTATE_90_CLOCKWISE);
    const Ptr<ORB> detector = AdaptiveQuadtreeORB::create(400, 1.2f, 8, 16, 0, WTA_K);
    const Features a = detectAndCompute(*detector, image), b = detectAndCompute(*detector, turned);
    std::vector<DMatch> matches;
    BFMatcher(detector->defaultNorm(), true).match(a.descriptors, b.descriptors, matches);
    size_t correct = 0;
    for (const DMatch& match : matches)
    {
        const Point2f p = a.keypoints[match.queryIdx].pt, q = b.keypoints[match.trainIdx].pt;
        correct += cv::norm(Point2f(299 - p.y, p.x) - q) < 2;
    }
    EXPECT_GT(correct, a.keypoints.size() / 2);
}

TEST(Aqorb_Use, with_a_matcher)
{
    for (int WTA_K = 2; WTA_K <= 4; WTA_K++)
    {
        SCOPED_TRACE(WTA_K);
        expectMatches(WTA_K);
    }
}

}  // namespace
}  // namespace opencv_test
