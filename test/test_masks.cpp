// This file is part of the aqorb project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.

#include "reference.hpp"

namespace opencv_test
{
namespace
{

TEST(Aqorb_Masks, an_empty_mask_gives_nothing)
{
    const Mat image = makeScene(Size(320, 240));
    Features stale = {KeyPoints(4), Mat::ones(4, 32, CV_8UC1)};
    AdaptiveQuadtreeORB::create()->detectAndCompute(image, Mat::zeros(image.size(), CV_8UC1), stale.keypoints,
                                                    stale.descriptors);
    EXPECT_TRUE(stale.keypoints.empty());
    EXPECT_TRUE(stale.descriptors.empty());
}

TEST(Aqorb_Masks, no_keypoint_lies_on_a_masked_pixel)
{
    const Mat image = makeScene(Size(320, 240), 2);
    RNG rng(8);
    for (int round = 0; round < 12; round++)
    {
        // holes of all sizes down to a pixel, which coarse levels must not lose
        Mat mask(image.size(), CV_8UC1, Scalar(1));
        for (int i = 0; i < 200; i++)
        {
            const Point hole(rng.uniform(0, mask.cols), rng.uniform(0, mask.rows));
            circle(mask, hole, i < 150 ? 0 : rng.uniform(1, 20), Scalar(0), -1);
        }
        const Ptr<AdaptiveQuadtreeORB> detector =
            AdaptiveQuadtreeORB::create(400, round % 2 ? 1.2f : 1.7f, 6, 5, round % 3);
        detector->setSubPixel(round < 8);
        KeyPoints keypoints;
        detector->detect(image, keypoints, mask);
        EXPECT_GT(keypoints.size(), 50u);
        for (const KeyPoint& keypoint : keypoints)
            EXPECT_NE(0, mask.at<uchar>(cvRound(keypoint.pt.y), cvRound(keypoint.pt.x)));
    }
}

TEST(Aqorb_Masks, positions_off_the_pixels_a_level_is_made_of)
{
    // Without SubPixel, and with large steps of the pyramid, a position may round to a pixel that is not
    // one of those that the level's pixel was made of: the mask must be looked up there, too.
    const Mat image = makeNoise(Size(200, 160), 4);
    Mat mask(image.size(), CV_8UC1, Scalar(1));
    RNG rng(9);
    for (int i = 0; i < 1500; i++)
        mask.at<uchar>(rng.uniform(0, mask.rows), rng.uniform(0, mask.cols)) = 0;
    const float factors[] = {1.2f, 1.5f, 2.f, 2.7f, 4.f};
    for (float factor : factors)
    {
        for (int subPixel = 0; subPixel <= 1; subPixel++)
        {
            reference::Settings settings;
            settings.nfeatures = 4000;
            settings.scaleFactor = factor;
            settings.nlevels = 4;
            settings.edgeThreshold = 3;
            settings.subPixel = subPixel != 0;
            SCOPED_TRACE(format("scaleFactor %g, sub-pixel %d", factor, subPixel));
            const Features features = detectAndCompute(*settings.create(), image, mask);
            EXPECT_GT(features.keypoints.size(), 300u);
            for (const KeyPoint& keypoint : features.keypoints)
                ASSERT_NE(0, mask.at<uchar>(cvRound(keypoint.pt.y), cvRound(keypoint.pt.x)))
                    << "octave " << keypoint.octave;
            EXPECT_TRUE(sameFeatures(features, reference::detectAndCompute(image, mask, settings)));
        }
    }
}

TEST(Aqorb_Masks, masked_corners_do_not_fill_a_cell)
{
    // A strong corner and a weak one in one cell: the weak one shows once the strong one is masked.
    Mat image(120, 120, CV_8UC1, Scalar(100));
    image.at<uchar>(32, 32) = 255;
    image.at<uchar>(42, 42) = 112;
    const Ptr<AdaptiveQuadtreeORB> detector = AdaptiveQuadtreeORB::create(2, 1.2f, 1);
    Mat mask(image.size(), CV_8UC1, Scalar(1));
    mask(Rect(26, 26, 12, 12)).setTo(0);
    detector->setAdaptiveThreshold(false);  // not the mask's effect on equation (7)
    detector->setFastThreshold(30);
    KeyPoints keypoints;
    detector->setMaxFeatures(1);
    detector->detect(image, keypoints);
    ASSERT_EQ(1u, keypoints.size());
    EXPECT_LT(cv::norm(keypoints[0].pt - Point2f(32, 32)), 4);
    detector->setMaxFeatures(500);
    detector->detect(image, keypoints, mask);
    ASSERT_FALSE(keypoints.empty());
    for (const KeyPoint& keypoint : keypoints)
        EXPECT_LT(cv::norm(keypoint.pt - Point2f(42, 42)), 4);
}

}  // namespace
}  // namespace opencv_test
