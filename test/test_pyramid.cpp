// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "reference.hpp"

#include "detector/quadtree.hpp"

#include "detector/pyramid.hpp"
#include "detector/selection.hpp"

#include <climits>
#include <numeric>

namespace opencv_test
{
namespace
{

using namespace aqorb;

TEST(Aqorb_Pyramid, quotas_of_the_paper)
{
    // 500 features on 8 levels: equation (8) gives 108.6 for the first and 30.3 for the last.
    const std::vector<int> quotas = quadtreeQuotas(500, 1.2f, 8);
    // cv::ORB's last level takes what rounding leaves, here 31.
    const int expected[] = {109, 90, 75, 63, 52, 44, 36, 31};
    EXPECT_EQ(quotas, std::vector<int>(expected, expected + 8));
    EXPECT_EQ(quadtreeQuotas(500, 1.f, 1), std::vector<int>(1, 500));
    // cv::ORB's rounding asks for 8 features where 7 are wanted: the finest level that has one gives it up.
    EXPECT_EQ(quadtreeQuotas(7, 1.2f, 8), reference::quotas(7, 1.2f, 8));
}

TEST(Aqorb_Pyramid, quotas_of_the_ranked_selection_add_up_and_equal_reference)
{
    RNG rng(15);
    for (int nlevels = 1; nlevels <= 12; nlevels++)
        for (int n = 0; n <= 5000; n += n < 60 ? 1 : 617)
        {
            SCOPED_TRACE(format("levels %d, features %d", nlevels, n));
            std::vector<Size> sizes;
            std::vector<float> scales;
            const bool equal = rng.uniform(0, 4) == 0;
            for (int i = 0; i < nlevels; i++)
            {
                sizes.push_back(equal ? Size(9, 9) : Size(rng.uniform(1, 2000), rng.uniform(1, 2000)));
                scales.push_back(equal ? 1.f : rng.uniform(0.1f, 10.f));
            }
            const std::vector<int> quotas = rankedQuotas(n, sizes, scales);
            ASSERT_EQ(quotas, reference::rankedQuotas(n, sizes, scales));
            ASSERT_GE(*std::min_element(quotas.begin(), quotas.end()), 0);
            ASSERT_EQ(std::accumulate(quotas.begin(), quotas.end(), 0), n);
        }
    EXPECT_TRUE(rankedQuotas(500, std::vector<Size>(), std::vector<float>()).empty());
    // 1.5 * 64 against 3 * 16^1.25
    const std::vector<int> quotas = rankedQuotas(INT_MAX, {Size(8, 8), Size(3, 1)}, {1.f, 16.f});
    EXPECT_NEAR(quotas[0], quotas[1], 200);
    EXPECT_EQ(int64(quotas[0]) + quotas[1], INT_MAX);
}

TEST(Aqorb_Pyramid, resize_equals_opencv_for_every_width_and_alignment)
{
    const double factors[] = {0.5, 0.9, 1.1, 1.2, 1.5, 2, 2.7, 5, 17};
    for (int width = 1; width <= MAX_WIDTH; width++)
    {
        SCOPED_TRACE(format("width %d", width));
        const Mat noise =
            width % 2 ? makeNoise(Size(width, 9), width) : makeNoise(Size(width, 9), width) > 127;
        Mat expected[9];
        for (int i = 0; i < 9; i++)
            cv::resize(noise, expected[i], Size(cvCeil(width / factors[i]), cvRound(9 / factors[i])), 0, 0,
                       INTER_LINEAR_EXACT);
        atEveryOffset(noise,
                      [&](const Mat& image, int offset)
                      {
                          const Mat& level = expected[(width + offset) % 9];
                          Mat resized =
                              atOffset(Mat::zeros(level.size(), CV_8UC1), (7 * offset + width) % 64);
                          const uchar* before = resized.data;
                          Ptr<ResizeTables> tables;
                          resizeExact(image, resized, tables);
                          EXPECT_TRUE(sameMat(resized, level));
                          EXPECT_EQ(resized.data, before);
                          EXPECT_TRUE(isAround(resized, 255));
                      });
    }
}

TEST(Aqorb_Pyramid, quotas_add_up_for_extreme_numbers_of_features_and_scale_factors)
{
    // 2^31 - 1 is 2^31 as a float, which no int holds. Equation (8) is 0 / 0 for factors that are 1 as a float.
    for (double factor : {1 + 1e-15, 1 + 1e-8, 1 + 6e-8, 1 + 1e-7, 1 + 1e-6, 1.001, 1.2, 2., 1e30})
        for (int nlevels = 1; nlevels <= 8; nlevels++)
            for (int n : {500, INT_MAX})
            {
                SCOPED_TRACE(format("%d features, factor %.17g, %d levels", n, factor, nlevels));
                const std::vector<int> quotas = quadtreeQuotas(n, factor, nlevels);
                EXPECT_EQ(n, std::accumulate(quotas.begin(), quotas.end(), int64(0)));
                EXPECT_GE(*std::min_element(quotas.begin(), quotas.end()), factor < 1.1 ? 50 : 0);
            }
    const Ptr<AdaptiveQuadtreeORB> detector = AdaptiveQuadtreeORB::create(60, 1.2f, 3);
    detector->setScaleFactor(1 + 1e-8);
    EXPECT_EQ(60u, detectAndCompute(*detector, makeScene(Size(120, 90))).keypoints.size());
}

TEST(Aqorb_Pyramid, goes_to_umats_and_into_memory_of_its_own)
{
    const Ptr<AdaptiveQuadtreeORB> detector = AdaptiveQuadtreeORB::create();
    const Mat image = makeScene(Size(200, 150));
    std::vector<Mat> expected, levels;
    std::vector<UMat> ulevels(2);
    detector->buildPyramid(image, expected);
    detector->buildPyramid(image.getUMat(ACCESS_READ), ulevels);
    ASSERT_TRUE(expected.size() == 8 && ulevels.size() == 8);
    for (size_t i = 0; i < ulevels.size(); i++)
        EXPECT_TRUE(sameMat(expected[i], ulevels[i].getMat(ACCESS_READ)));

    detector->buildPyramid(image, levels);
    const Mat before = levels[0];
    levels[0].setTo(0);
    detector->buildPyramid(image, levels);
    EXPECT_TRUE(sameMat(image, levels[0]) && sameMat(image, expected[0]));
    EXPECT_NE(before.data, levels[0].data);

    EXPECT_THROW(detector->buildPyramid(Mat(9, 9, CV_32FC1, Scalar(0)), levels), cv::Exception);
    EXPECT_EQ(8u, levels.size());
    detector->setFirstLevel(8);
    EXPECT_THROW(detector->buildPyramid(image, levels), cv::Exception);
}

TEST(Aqorb_Pyramid, equals_reference_and_comes_with_the_features_in_one_call)
{
    for (int seed = 1; seed <= 40; seed++)
    {
        SCOPED_TRACE(seed);
        RNG rng(seed);
        const reference::Settings settings = reference::randomSettings(rng);
        const Ptr<AdaptiveQuadtreeORB> detector = settings.create();
        const Size size = seed % 8 ? Size(rng.uniform(1, 200), rng.uniform(1, 200)) : Size();
        const Mat image = size.empty() ? Mat() : makeScene(size, seed);
        const Mat mask = seed % 2 ? Mat(size, CV_8UC1, Scalar(0)) : Mat();
        if (!mask.empty())
            mask.colRange(0, (size.width + 1) / 2).setTo(1);
        std::vector<Mat> expected, built(3), levels(1, image);  // the input may be among the outputs
        if (!image.empty())
            expected = reference::pyramid(image, settings.nlevels, settings.firstLevel, settings.scaleFactor);
        if (!image.empty() && seed % 3 == 0)
            cvtColor(image, levels[0], COLOR_GRAY2BGR);
        detector->buildPyramid(levels[0], built);
        Features features;
        detector->detectAndComputeWithPyramid(levels[0], mask, features.keypoints, features.descriptors,
                                              levels);
        EXPECT_TRUE(sameFeatures(detectAndCompute(*detector, image, mask), features));
        ASSERT_TRUE(expected.size() == levels.size() && expected.size() == built.size());
        for (size_t i = 0; i < levels.size(); i++)
            EXPECT_TRUE(sameMat(expected[i], levels[i]) && sameMat(expected[i], built[i])) << "level " << i;
    }
}

}  // namespace
}  // namespace opencv_test
