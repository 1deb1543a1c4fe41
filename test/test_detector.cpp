// This file is part of the aqorb project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.

#include "plain_reference.hpp"

namespace opencv_test
{
namespace
{

// The detector against the plain reference, byte for byte.
void expectReference(AdaptiveQuadtreeORB& detector, const Mat& image, const Mat& mask = Mat())
{
    const Features expected = referenceFeatures(image, mask, ReferenceParameters(detector));
    EXPECT_TRUE(sameFeatures(detectAndCompute(detector, image, mask), expected));
    setUseOptimized(false);
    EXPECT_TRUE(sameFeatures(detectAndCompute(detector, image, mask), expected)) << "baseline kernels";
    setUseOptimized(true);
}

Mat holedMask(Size size)
{
    Mat mask(size, CV_8UC1, Scalar(1));
    RNG rng(5);
    for (int i = 0; i < 6; i++)
        circle(mask, Point(rng.uniform(0, size.width), rng.uniform(0, size.height)), rng.uniform(2, 14),
               Scalar(0), -1);
    mask.row(size.height / 2).setTo(0);
    return mask;
}

TEST(AQORB_Detector, defaults)
{
    for (int seed = 1; seed <= 3; seed++)
    {
        SCOPED_TRACE(seed);
        const Ptr<AdaptiveQuadtreeORB> detector = AdaptiveQuadtreeORB::create(200);
        expectReference(*detector, makeScene(Size(150 + 7 * seed, 120 + seed), seed));
    }
}

TEST(AQORB_Detector, numbers_of_features)
{
    const Mat image = makeScene(Size(130, 110));
    const int counts[] = {0, 1, 7, 31, 100, 10000};
    for (int count : counts)
    {
        SCOPED_TRACE(count);
        const Ptr<AdaptiveQuadtreeORB> detector = AdaptiveQuadtreeORB::create(count);
        expectReference(*detector, image);
        detector->setScoreType(ORB::FAST_SCORE);
        expectReference(*detector, image);
    }
}

TEST(AQORB_Detector, own_properties)
{
    const Mat image = makeScene(Size(140, 130), 4);
    Ptr<AdaptiveQuadtreeORB> detector;
#define AQORB_TRY(setting)                       \
    detector = AdaptiveQuadtreeORB::create(120); \
    detector->setting;                           \
    {                                            \
        SCOPED_TRACE(#setting);                  \
        expectReference(*detector, image);       \
    }
    AQORB_TRY(setAdaptiveThreshold(false));
    AQORB_TRY(setMinThresholdRatio(1));
    AQORB_TRY(setMinThresholdRatio(10));
    AQORB_TRY(setCellSize(8));
    AQORB_TRY(setCellSize(1000000));
    AQORB_TRY(setMaxDepth(0));
    AQORB_TRY(setMaxDepth(1));
    AQORB_TRY(setMaxDepth(3));
    AQORB_TRY(setMaxDepth(15));
    AQORB_TRY(setOctaveSuppression(0));
    AQORB_TRY(setOctaveSuppression(3));
    AQORB_TRY(setOctaveSuppression(1e6));
    AQORB_TRY(setSubPixel(false));
    AQORB_TRY(setFastThreshold(0));
    AQORB_TRY(setFastThreshold(5));
    AQORB_TRY(setFastThreshold(300));
#undef AQORB_TRY
}

TEST(AQORB_Detector, parameters_of_ORB)
{
    struct Case
    {
        int nfeatures;
        float scaleFactor;
        int nlevels, edgeThreshold, firstLevel, WTA_K;
        ORB::ScoreType scoreType;
        int patchSize, fastThreshold;
    };
    const Case cases[] = {
        {100, 1.2f, 8, 31, 0, 2, ORB::HARRIS_SCORE, 31, 20},
        {100, 1.1f, 4, 0, 0, 2, ORB::FAST_SCORE, 31, 20},
        {100, 1.5f, 3, 3, 1, 3, ORB::HARRIS_SCORE, 31, 10},
        {100, 1.8f, 5, 8, 3, 2, ORB::HARRIS_SCORE, 8, 20},
        {100, 2.5f, 3, 4, 0, 4, ORB::HARRIS_SCORE, 47, 20},
        {100, 1.f, 1, 16, 0, 2, ORB::FAST_SCORE, 2, 40},
        {60, 1.2f, 8, 2, 2, 4, ORB::FAST_SCORE, 61, 15},
        {60, 1.3f, 20, 1, 0, 3, ORB::HARRIS_SCORE, 5, 20},
    };
    for (const Case& c : cases)
    {
        SCOPED_TRACE(format("%g %d %d %d %d %d", c.scaleFactor, c.nlevels, c.edgeThreshold, c.firstLevel,
                            c.WTA_K, c.patchSize));
        const Ptr<AdaptiveQuadtreeORB> detector =
            AdaptiveQuadtreeORB::create(c.nfeatures, c.scaleFactor, c.nlevels, c.edgeThreshold, c.firstLevel,
                                        c.WTA_K, c.scoreType, c.patchSize, c.fastThreshold);
        expectReference(*detector, makeScene(Size(101, 77), 6));
    }
}

TEST(AQORB_Detector, masks)
{
    const Mat image = makeScene(Size(150, 120), 3);
    const Mat mask = holedMask(image.size());
    const Ptr<AdaptiveQuadtreeORB> detector = AdaptiveQuadtreeORB::create(150);
    expectReference(*detector, image, mask);
    detector->setSubPixel(false);
    expectReference(*detector, image, mask);
    detector->setFirstLevel(2);
    expectReference(*detector, image, mask);
    detector->setSubPixel(true);
    detector->setScaleFactor(2.2);
    expectReference(*detector, image, mask);
}

TEST(AQORB_Detector, odd_images)
{
    const Ptr<AdaptiveQuadtreeORB> detector = AdaptiveQuadtreeORB::create(80, 1.2f, 8, 3);
    const Size sizes[] = {Size(7, 7), Size(8, 40), Size(40, 9), Size(33, 33), Size(300, 14), Size(17, 200)};
    for (const Size& size : sizes)
    {
        SCOPED_TRACE(format("%d x %d", size.width, size.height));
        expectReference(*detector, makeNoise(size));
        expectReference(*detector, makeScene(size, 2));
    }
    Mat dark;
    makeScene(Size(140, 120)).convertTo(dark, -1, 0.12);
    expectReference(*detector, dark);
    // every score many times over: only the order of pixels decides
    Mat dots = Mat::zeros(90, 90, CV_8UC1);
    for (int y = 5; y < 90; y += 9)
        for (int x = 5; x < 90; x += 8)
            dots.at<uchar>(y, x) = 200;
    expectReference(*detector, dots);
}

}  // namespace
}  // namespace opencv_test
