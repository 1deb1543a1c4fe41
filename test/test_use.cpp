// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "test_precomp.hpp"

#include <opencv2/opencv_modules.hpp>

#ifdef HAVE_OPENCV_FLANN
#include <opencv2/flann.hpp>
#endif
#ifdef HAVE_OPENCV_STITCHING
#include <opencv2/stitching.hpp>
#endif

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

#if CV_VERSION_MAJOR < 5  // OpenCV 5 has no such class
TEST(Aqorb_Use, in_bow_img_descriptor_extractor)
{
    const Ptr<Feature2D> detector = AdaptiveQuadtreeORB::create(200);
    const Mat image = makeScene(Size(240, 200));
    Features features = detectAndCompute(*detector, image);
    const Ptr<DescriptorMatcher> matcher = makePtr<BFMatcher>((int)NORM_HAMMING);
    BOWImgDescriptorExtractor bow(detector, matcher);
    bow.setVocabulary(features.descriptors.rowRange(0, 20).clone());
    Mat histogram;
    bow.compute(image, features.keypoints, histogram);
    ASSERT_EQ(20, histogram.cols);
    EXPECT_NEAR(1, sum(histogram)[0], 1e-5);
}
#endif

#ifdef HAVE_OPENCV_FLANN
TEST(Aqorb_Use, with_a_flann_index)
{
    const Ptr<Feature2D> detector = AdaptiveQuadtreeORB::create(300);
    const Features features = detectAndCompute(*detector, makeScene(Size(320, 240)));
    FlannBasedMatcher matcher(makePtr<flann::LshIndexParams>(12, 20, 2));
    std::vector<DMatch> matches;
    matcher.match(features.descriptors, features.descriptors, matches);
    int same = 0;
    for (const DMatch& match : matches)
        same += match.distance == 0;
    EXPECT_GT(same, 270);
}
#endif

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

#ifdef HAVE_OPENCV_STITCHING
TEST(Aqorb_Use, in_a_stitcher)
{
    Mat scene;
    cvtColor(makeScene(Size(900, 400), 4), scene, COLOR_GRAY2BGR);
    std::vector<Mat> parts;
    parts.push_back(scene.colRange(0, 560));
    parts.push_back(scene.colRange(340, 900));
    const Ptr<Stitcher> stitcher = Stitcher::create(Stitcher::SCANS);
    stitcher->setFeaturesFinder(AdaptiveQuadtreeORB::create(1500));
    Mat panorama;
    ASSERT_EQ(Stitcher::OK, stitcher->stitch(parts, panorama));
    EXPECT_NEAR(900, panorama.cols, 40);
    EXPECT_NEAR(400, panorama.rows, 40);
}
#endif

}  // namespace
}  // namespace opencv_test
