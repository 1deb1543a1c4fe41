// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "reference.hpp"

#include "harris_orientation.hpp"

namespace opencv_test
{
namespace
{

using namespace aqorb;

float harrisResponse(const Mat& image, int x, int y)
{
    const Corner corner = {x, y, 1};
    CornerResponse found;
    harrisResponses(image, &corner, 1, &found);
    return found.response;
}

void expectAsReference(const Mat& image, const std::vector<Corner>& corners)
{
    std::vector<CornerResponse> found(corners.size());
    harrisResponses(image, corners.data(), corners.size(), found.data());
    for (size_t i = 0; i < corners.size(); i++)
    {
        const Corner& c = corners[i];
        ASSERT_EQ(found[i].x, c.x);
        ASSERT_EQ(found[i].y, c.y);
        // The response is the same float, not one nearby.
        ASSERT_EQ(found[i].response, reference::harrisResponse(image, c.x, c.y)) << c.x << " " << c.y;
        ASSERT_EQ(harrisResponse(image, c.x, c.y), found[i].response) << c.x << " " << c.y;
    }
}

std::vector<Corner> allPixels(Size size)
{
    std::vector<Corner> corners;
    for (int y = 0; y < size.height; y++)
        for (int x = 0; x < size.width; x++)
        {
            corners.push_back({x, y, 1});
        }
    return corners;
}

TEST(Aqorb_Harris, equals_reference_at_every_pixel)
{
    const Size sizes[] = {Size(70, 40), Size(31, 9), Size(16, 7), Size(7, 7), Size(3, 2), Size(1, 1)};
    for (const Size& size : sizes)
    {
        SCOPED_TRACE(format("%d x %d", size.width, size.height));
        const Mat noise = makeNoise(size);
        const Mat images[] = {noise, noise > 128, makeScene(size), Mat(size, CV_8UC1, Scalar(255))};
        for (const Mat& image : images)
        {
            expectAsReference(image, allPixels(size));
            WithoutOptimization baseline;
            expectAsReference(image, allPixels(size));
        }
    }
}

TEST(Aqorb_Harris, equals_reference_for_every_width_and_alignment)
{
    const int y = 4;
    for (int width = 1; width <= MAX_WIDTH; width++)
    {
        SCOPED_TRACE(format("width %d", width));
        const Size size(width, 9);
        const Mat noise = width % 2 ? makeNoise(size, width) : makeNoise(size, width) > 128;
        std::vector<float> expected;
        for (int x = 0; x < width; x++)
            expected.push_back(reference::harrisResponse(noise, x, y));
        atEveryOffset(noise,
                      [&](const Mat& image, int offset)
                      {
                          std::vector<Corner> corners;
                          for (int x = offset % 5; x < width; x += 5)
                          {
                              corners.push_back({x, y, 1});
                          }
                          std::vector<CornerResponse> found(corners.size());
                          harrisResponses(image, corners.data(), corners.size(), found.data());
                          for (const CornerResponse& corner : found)
                              EXPECT_EQ(corner.response, expected[corner.x]) << corner.x;
                      });
    }
}

TEST(Aqorb_Harris, equals_reference_in_any_order)
{
    // Corners too near the border for the kernel come between others.
    const Mat noise = makeNoise(Size(64, 48));
    std::vector<Corner> corners;
    RNG rng(8);
    for (int i = 0; i < 400; i++)
    {
        corners.push_back({rng.uniform(0, noise.cols), rng.uniform(0, noise.rows), 7});
    }
    expectAsReference(noise, corners);
    expectAsReference(noise, std::vector<Corner>());
}

TEST(Aqorb_Harris, holds_the_largest_derivatives)
{
    // Stripes and steps from 0 to 255 give the largest sums.
    Mat columns(40, 40, CV_8UC1, Scalar(0)), step(40, 40, CV_8UC1, Scalar(0)), quarter;
    for (int x = 0; x < 40; x += 4)
        columns.colRange(x, x + 2).setTo(255);
    step.colRange(20, 40).setTo(255);
    quarter = step.clone();
    quarter.rowRange(0, 20).setTo(0);
    const Mat images[] = {columns, columns.t(), step, step.t(), quarter};
    for (const Mat& image : images)
        expectAsReference(image, allPixels(image.size()));
}

}  // namespace
}  // namespace opencv_test
