// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "reference.hpp"

#include "quadtree.hpp"

#include "pyramid.hpp"
#include "selection.hpp"

#include <climits>
#include <numeric>

namespace opencv_test
{
namespace
{

using namespace aqorb;

//! The levels of a pyramid, with memory of their own.
std::vector<Level> buildPyramid(const Mat& image, const Mat& mask, const PyramidRule& rule)
{
    Level input;
    input.image = image;
    input.mask = mask;
    static PyramidSpace space;  // Images of all sizes share it.
    std::vector<Level> levels = makePyramid(input, rule, 2, space);
    for (Level& level : levels)
    {
        level.image = level.image.clone();
        level.mask = level.mask.clone();
    }
    return levels;
}

TEST(Aqorb_Pyramid, quotas_of_the_paper)
{
    // 500 features on 8 levels: equation (8) gives 108.6 for the first and 30.3 for the last.
    const std::vector<int> quotas = quadtreeQuotas(500, 1.2f, 8);
    // cv::ORB's last level takes what rounding leaves, here 31.
    const int expected[] = {109, 90, 75, 63, 52, 44, 36, 31};
    EXPECT_EQ(quotas, std::vector<int>(expected, expected + 8));
    EXPECT_EQ(quadtreeQuotas(500, 1.f, 1), std::vector<int>(1, 500));
}

TEST(Aqorb_Pyramid, quotas_take_rounding_from_the_finest_level)
{
    // cv::ORB's rounding asks for 8 features where 7 are wanted.
    const std::vector<int> quotas = quadtreeQuotas(7, 1.2f, 8);
    const int expected[] = {1, 1, 1, 1, 1, 1, 1, 0};
    EXPECT_EQ(quotas, std::vector<int>(expected, expected + 8));
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

TEST(Aqorb_Pyramid, scales_and_sizes_are_those_of_orb)
{
    EXPECT_EQ(levelScale(0, 0, 1.2f), 1.f);
    EXPECT_EQ(levelScale(1, 0, 1.2f), 1.2f);
    EXPECT_EQ(levelScale(3, 1, 2.f), 4.f);
    EXPECT_EQ(levelScale(0, 2, 2.f), 0.25f);
    EXPECT_EQ(levelScale(7, 0, 1.2f), (float)std::pow((double)1.2f, 7.));
    EXPECT_EQ(levelSize(Size(640, 480), 1.2f), Size(533, 400));
    EXPECT_EQ(levelSize(Size(640, 480), 0.5f), Size(1280, 960));
    EXPECT_EQ(levelSize(Size(5, 1), 2.5f), Size(2, 0));
    EXPECT_THROW(levelSize(Size(640, 480), 1e-5f), cv::Exception);
}

static void expectResizedAsOpenCV(const Mat& source, Size size)
{
    Mat expected, resized;
    cv::resize(source, expected, size, 0, 0, INTER_LINEAR_EXACT);
    resized.create(size, CV_8UC1);
    Ptr<ResizeTables> tables;
    resizeExact(source, resized, tables);
    EXPECT_TRUE(sameMat(resized, expected));
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

TEST(Aqorb_Pyramid, resize_takes_regions)
{
    const Mat noise = makeNoise(Size(200, 150));
    expectResizedAsOpenCV(noise(Rect(13, 7, 151, 101)), Size(126, 84));
}

TEST(Aqorb_Pyramid, a_masked_pixel_masks_all_that_are_made_of_it)
{
    const Mat image = makeScene(Size(97, 75));
    Mat mask(image.size(), CV_8UC1, Scalar(1));
    RNG rng(1);
    for (int i = 0; i < 40; i++)
        mask.at<uchar>(rng.uniform(0, mask.rows), rng.uniform(0, mask.cols)) = 0;
    mask(Rect(20, 20, 15, 5)).setTo(0);
    const float factors[] = {1.1f, 1.2f, 1.5f, 2.f, 2.9f};
    for (float factor : factors)
        for (int firstLevel = 0; firstLevel <= 2; firstLevel++)
        {
            const std::vector<Level> levels = buildPyramid(image, mask, {firstLevel, factor, 5, 5});
            for (int i = 0; i < int(levels.size()); i++)
            {
                SCOPED_TRACE(format("factor %g, first level %d, level %d", factor, firstLevel, i));
                ASSERT_EQ(levels[i].mask.size(), levels[i].image.size());
                Mat expected = mask;
                if (i != firstLevel)
                    expected = reference::resizeMask(i <= firstLevel + 1 ? mask : levels[i - 1].mask,
                                                     levels[i].image.size());
                EXPECT_TRUE(sameMat(levels[i].mask != 0, expected != 0));
            }
        }
}

}  // namespace
}  // namespace opencv_test
