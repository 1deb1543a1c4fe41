// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "test_precomp.hpp"

#include "quadtree.hpp"
#include "pyramid.hpp"

#include <limits>
#include <numeric>

// Each test repeats a failure that fuzzing has found.

namespace opencv_test
{
namespace
{

TEST(Aqorb_FuzzFinds, a_storage_node_that_is_no_map)
{
    // XML reads an empty map as nothing at all: all keys are missing, which is no error.
    const char* good[] = {
        "<?xml version=\"1.0\"?>\n<opencv_storage>\n<detector>\n</detector>\n</opencv_storage>\n",
        "%YAML:1.0\n---\ndetector:\n   {}\n"};
    for (const char* text : good)
    {
        const Ptr<AdaptiveQuadtreeORB> detector = AdaptiveQuadtreeORB::create(77);
        FileStorage fs(text, FileStorage::READ | FileStorage::MEMORY);
        EXPECT_NO_THROW(detector->read(fs["detector"])) << text;
        EXPECT_EQ(77, detector->getMaxFeatures());
    }
    const char* bad[] = {"%YAML:1.0\n---\ndetector: 5\n", "%YAML:1.0\n---\ndetector: text\n",
                         "%YAML:1.0\n---\ndetector: [ 1, 2 ]\n"};
    for (const char* text : bad)
    {
        const Ptr<AdaptiveQuadtreeORB> detector = AdaptiveQuadtreeORB::create(77);
        FileStorage fs(text, FileStorage::READ | FileStorage::MEMORY);
        try
        {
            detector->read(fs["detector"]);
            ADD_FAILURE() << "accepted: " << text;
        }
        catch (const cv::Exception& e)
        {
            EXPECT_EQ((int)Error::StsParseError, e.code) << text;
            EXPECT_NE(std::string::npos, e.err.find("must be a map of the parameters")) << e.err;
        }
        EXPECT_EQ(77, detector->getMaxFeatures());
    }
}

TEST(Aqorb_FuzzFinds, angles_that_are_not_finite)
{
    // They made the descriptor read outside the image, as they still make that of cv::ORB.
    const Mat image = makeScene(Size(120, 90));
    const float endless = std::numeric_limits<float>::infinity();
    const float angles[] = {endless, -endless, std::numeric_limits<float>::quiet_NaN()};
    for (int WTA_K = 2; WTA_K <= 4; WTA_K++)
    {
        const Ptr<AdaptiveQuadtreeORB> detector = AdaptiveQuadtreeORB::create(500, 1.2f, 8, 16, 0, WTA_K);
        for (float angle : angles)
        {
            KeyPoints keypoints(2, KeyPoint(Point2f(60, 45), 31.f, 10.f));
            keypoints[1].angle = angle;
            Mat descriptors;
            EXPECT_THROW(detector->compute(image, keypoints, descriptors), cv::Exception) << angle;
            EXPECT_EQ(2u, keypoints.size());
        }
        // Any finite angle is accepted, whole turns or not.
        for (float angle : {360.f * 1000, -1e30f})
        {
            KeyPoints keypoints = {KeyPoint(Point2f(60, 45), 31.f, 0.f),
                                   KeyPoint(Point2f(60, 45), 31.f, angle)};
            Mat descriptors;
            EXPECT_NO_THROW(detector->compute(image, keypoints, descriptors));
            ASSERT_EQ(2, descriptors.rows);
            EXPECT_EQ(angle, keypoints[1].angle);
            EXPECT_EQ(angle > 0, sameMat(descriptors.row(0), descriptors.row(1)));
        }
    }
}

TEST(Aqorb_FuzzFinds, quotas_of_more_features_than_a_float_counts)
{
    // 2^31 - 1 is 2^31 as a float, which no int holds.
    const double factors[] = {1.001, 1.2, 2, 1e30};
    for (double factor : factors)
        for (int nlevels = 1; nlevels <= 8; nlevels++)
        {
            const std::vector<int> quotas = aqorb::quadtreeQuotas(INT_MAX, factor, nlevels);
            EXPECT_EQ(INT_MAX, std::accumulate(quotas.begin(), quotas.end(), int64(0)));
            EXPECT_GE(*std::min_element(quotas.begin(), quotas.end()), 0);
        }
}

TEST(Aqorb_FuzzFinds, a_scale_factor_that_is_one_as_a_float)
{
    // Equation (8) is 0 / 0 there.
    for (double factor : {1 + 1e-15, 1 + 1e-8, 1 + 6e-8, 1 + 1e-7, 1 + 1e-6})
    {
        SCOPED_TRACE(factor);
        const std::vector<int> quotas = aqorb::quadtreeQuotas(500, factor, 4);
        EXPECT_EQ(500, std::accumulate(quotas.begin(), quotas.end(), int64(0)));
        EXPECT_GT(*std::min_element(quotas.begin(), quotas.end()), 100);
        const Ptr<AdaptiveQuadtreeORB> detector = AdaptiveQuadtreeORB::create(60, 1.2f, 3);
        detector->setScaleFactor(factor);
        KeyPoints keypoints;
        detector->detect(makeScene(Size(120, 90)), keypoints);
        EXPECT_EQ(60u, keypoints.size());
    }
}

TEST(Aqorb_FuzzFinds, a_direction_that_puts_a_point_between_two_pixels)
{
    // cv::ORB takes sine and cosine of a float, which are not always the floats nearest to the exact values;
    // at this angle the point (14, -23) of the pattern comes to lie on -22.5 or just beyond.
    if (!orbBlursWithFMA())
        AQORB_SKIP("cv::ORB of this OpenCV and CPU blurs without multiply-add");
#if defined(__OPENCV_BUILD) || CV_VERSION_MAJOR >= 5 || CV_VERSION_MINOR >= 14
    // Compiled with OpenCV's own headers only, cv::ORB takes those of a double; the point is part of several tests.
    const int toleratedBits = 8;
#else
    const int toleratedBits = 0;
#endif
    const Mat image = makeNoise(Size(200, 160));
    KeyPoints keypoints;
    for (int i = 0; i < 200; i++)
        keypoints.push_back(KeyPoint(Point2f(40.f + i % 20 * 6, 40.f + i / 20 * 8), 47.f, 295.352722f));
    for (int WTA_K = 2; WTA_K <= 4; WTA_K++)
    {
        SCOPED_TRACE(WTA_K);
        Features ours = {keypoints, Mat()}, theirs = ours;
        AdaptiveQuadtreeORB::create(500, 1.2f, 8, 16, 0, WTA_K, ORB::HARRIS_SCORE, 47)
            ->compute(image, ours.keypoints, ours.descriptors);
        ORB::create(500, 1.2f, 8, 16, 0, WTA_K, ORB::HARRIS_SCORE, 47)
            ->compute(image, theirs.keypoints, theirs.descriptors);
        ASSERT_EQ(200, ours.descriptors.rows);
        ASSERT_EQ(200, theirs.descriptors.rows);
        for (int i = 0; i < 200; i++)
        {
            EXPECT_LE(cv::norm(theirs.descriptors.row(i), ours.descriptors.row(i), NORM_HAMMING),
                      toleratedBits);
        }
    }
}

}  // namespace
}  // namespace opencv_test
