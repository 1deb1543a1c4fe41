// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "test_precomp.hpp"

// Drawn images of which the answer is known.

namespace opencv_test
{
namespace
{

void drawBlob(Mat& image, Point2d center, double sigma, double height)
{
    for (int y = 0; y < image.rows; y++)
        for (int x = 0; x < image.cols; x++)
        {
            const double dx = x - center.x, dy = y - center.y;
            const double value = height * std::exp(-(dx * dx + dy * dy) / (2 * sigma * sigma));
            image.at<uchar>(y, x) = saturate_cast<uchar>(image.at<uchar>(y, x) + value);
        }
}

// How far the only keypoint of a small round blob is off its centre, at worst.
double worstError(bool subPixel)
{
    double worst = 0;
    for (int i = 0; i < 36; i++)
    {
        const Point2d center(60 + (i % 6 - 2.5) / 6., 52 + (i / 6 - 2.5) / 6.);
        Mat image(110, 120, CV_8UC1, Scalar(20));
        drawBlob(image, center, 1, 200);  // The circle of FAST lies outside the blob.
        const Ptr<AdaptiveQuadtreeORB> detector = AdaptiveQuadtreeORB::create(1, 1.2f, 1);
        detector->setSubPixel(subPixel);
        KeyPoints keypoints;
        detector->detect(image, keypoints);
        EXPECT_EQ(1u, keypoints.size());
        if (!keypoints.empty())
            worst = std::max(worst, cv::norm(Point2d(keypoints[0].pt) - center));
    }
    return worst;
}

TEST(Aqorb_Analytic, position_of_a_blob_is_a_small_fraction_of_a_pixel_off)
{
    EXPECT_LT(worstError(true), 0.15);
    EXPECT_GT(worstError(false), 0.5);  // Whole pixels are up to half a diagonal off.
}

TEST(Aqorb_Analytic, a_blob_is_at_the_same_place_on_every_level)
{
    for (int octave = 0; octave < 8; octave++)
    {
        // a blob of the level's size; a map without pixel centres would be off by half a pixel of the level
        const double scale = std::pow(1.2, octave);
        const Point2d center(150.3, 140.8);
        Mat image(290, 300, CV_8UC1, Scalar(20));
        drawBlob(image, center, 1.2 * scale, 200);
        const Ptr<AdaptiveQuadtreeORB> detector = AdaptiveQuadtreeORB::create(200);
        detector->setOctaveSuppression(0);  // This keeps the same blob on several levels.
        KeyPoints keypoints;
        detector->detect(image, keypoints);
        double nearest = 1e9;
        for (const KeyPoint& keypoint : keypoints)
        {
            if (keypoint.octave == octave)
                nearest = std::min(nearest, cv::norm(Point2d(keypoint.pt) - center));
        }
        EXPECT_LT(nearest, 0.3 * scale) << "octave " << octave;
    }
}

}  // namespace
}  // namespace opencv_test
