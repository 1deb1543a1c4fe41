// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "test_precomp.hpp"

#include <thread>

namespace opencv_test
{
namespace
{

void expectSameOfAllThreads(const Ptr<AdaptiveQuadtreeORB>& detector)
{
    const Mat image = makeScene(Size(320, 240));
    Features expected, more;
    {
        Threads one(1);
        expected = detectAndCompute(*detector, image);
        detector->setMaxFeatures(10000);
        more = detectAndCompute(*detector, image);
    }
    for (int count = 2; count <= 8; count++)
    {
        SCOPED_TRACE(count);
        Threads threads(count);
        detector->setMaxFeatures(700);
        EXPECT_TRUE(sameFeatures(expected, detectAndCompute(*detector, image)));
        detector->setMaxFeatures(10000);
        EXPECT_TRUE(sameFeatures(more, detectAndCompute(*detector, image)));
    }
}

TEST(Aqorb_Determinism, threads_1_to_8_give_the_same_bytes)
{
    const double weights[] = {0, 0.15, 1000}, radii[] = {0, 1, 4};
    for (double weight : weights)
    {
        for (double radius : radii)
        {
            SCOPED_TRACE(format("weight %g, radius %g", weight, radius));
            const Ptr<AdaptiveQuadtreeORB> detector = AdaptiveQuadtreeORB::create(700);
            detector->setStrengthWeight(weight);
            detector->setRankRadius(radius);
            expectSameOfAllThreads(detector);
        }
    }
    SCOPED_TRACE("balanced");
    const Ptr<AdaptiveQuadtreeORB> detector = AdaptiveQuadtreeORB::create(700);
    detector->setSelectionType(AdaptiveQuadtreeORB::BALANCED_SELECTION);
    expectSameOfAllThreads(detector);
}

TEST(Aqorb_Determinism, concurrency_one_object_serves_many_threads)
{
    const int THREADS = 8, ROUNDS = 6;
    const Ptr<AdaptiveQuadtreeORB> detector = AdaptiveQuadtreeORB::create(200);
    std::vector<Mat> images;
    std::vector<Features> expected;
    for (int i = 0; i < THREADS; i++)
    {
        images.push_back(makeScene(Size(120 + 23 * i, 190 - 11 * i), i + 1));
        expected.push_back(detectAndCompute(*detector, images[i]));
    }
    std::vector<int> wrong(THREADS, 0);
    std::vector<std::thread> threads;
    for (int i = 0; i < THREADS; i++)
    {
        threads.push_back(std::thread(
            [&, i]
            {
                for (int round = 0; round < ROUNDS; round++)
                {
                    const int j = (i + round) % THREADS;
                    wrong[i] += !sameFeatures(expected[j], detectAndCompute(*detector, images[j]));
                    Features computed = {expected[j].keypoints, Mat()};
                    detector->compute(images[j], computed.keypoints, computed.descriptors);
                    wrong[i] += !sameFeatures(expected[j], computed);
                }
            }));
    }
    for (std::thread& thread : threads)
        thread.join();
    EXPECT_EQ(std::vector<int>(THREADS, 0), wrong);
}

TEST(Aqorb_Determinism, every_cpu_path_gives_the_same_bytes)
{
    for (int seed = 1; seed <= 4; seed++)
    {
        const Mat image = makeScene(Size(321, 243), seed);
        const Ptr<AdaptiveQuadtreeORB> detector = AdaptiveQuadtreeORB::create(400);
        const Features expected = detectAndCompute(*detector, image);
        const bool before = useOptimized();
        setUseOptimized(false);
        EXPECT_TRUE(sameFeatures(expected, detectAndCompute(*detector, image)));
        setUseOptimized(before);
    }
}

TEST(Aqorb_Determinism, what_lies_around_a_region_does_not_matter)
{
    // Image and mask are parts of larger matrices. What is around them changes, they do not. Without a border,
    // and with the narrow one, the detector reads pixels beyond the sides of the image.
    const Size size(200, 150);
    const Rect region(Point(29, 23), size);
    Mat image, mask = makeScene(size, 8) > 120;  // holes with many edges
    cvtColor(makeScene(size, 7), image, COLOR_GRAY2BGR);
    for (int border : {0, 3, 16})
    {
        for (int firstLevel = 0; firstLevel <= 1; firstLevel++)
        {
            const Ptr<AdaptiveQuadtreeORB> detector =
                AdaptiveQuadtreeORB::create(200, 1.2f, 8, border, firstLevel);
            const Features expected = detectAndCompute(*detector, image, mask);
            const Features unmasked = detectAndCompute(*detector, image);
            // With firstLevel > 0 compute may drop a keypoint near the border, as that of cv::ORB does.
            Features expectedOfCompute = {expected.keypoints, Mat()};
            detector->compute(image, expectedOfCompute.keypoints, expectedOfCompute.descriptors);
            EXPECT_GE(expectedOfCompute.keypoints.size(), 190u);
            ASSERT_EQ(200u, expected.keypoints.size());
            for (int around = 0; around <= 255; around += 51)
            {
                SCOPED_TRACE(format("border %d, first level %d, around %d", border, firstLevel, around));
                Mat wholeImage(260, 310, CV_8UC3, Scalar::all(around));
                Mat wholeMask(260, 310, CV_8UC1, Scalar(around));
                image.copyTo(wholeImage(region));
                mask.copyTo(wholeMask(region));
                EXPECT_FALSE(wholeImage(region).isContinuous());
                EXPECT_TRUE(sameFeatures(expected,
                                         detectAndCompute(*detector, wholeImage(region), wholeMask(region))));
                EXPECT_TRUE(sameFeatures(unmasked, detectAndCompute(*detector, wholeImage(region))));
                Features computed = {expected.keypoints, Mat()};
                detector->compute(wholeImage(region), computed.keypoints, computed.descriptors);
                EXPECT_TRUE(sameFeatures(expectedOfCompute, computed));
            }
        }
    }
}

TEST(Aqorb_Determinism, umat_equals_mat)
{
    const Mat image = makeScene(Size(300, 200));
    const Mat mask = image < 180;
    const Ptr<AdaptiveQuadtreeORB> detector = AdaptiveQuadtreeORB::create(300);
    const Features expected = detectAndCompute(*detector, image, mask);
    KeyPoints keypoints;
    UMat descriptors;
    detector->detectAndCompute(image.getUMat(ACCESS_READ), mask.getUMat(ACCESS_READ), keypoints, descriptors);
    const Features found = {keypoints, descriptors.getMat(ACCESS_READ).clone()};
    EXPECT_TRUE(sameFeatures(expected, found));

    // The same with the UMat's own memory, in colour, and as a region of a larger one.
    UMat whole;
    Mat color;
    cv::copyMakeBorder(image, color, 5, 6, 7, 8, BORDER_REFLECT);
    cvtColor(color, color, COLOR_GRAY2BGR);
    color.copyTo(whole);
    const UMat part = whole(Rect(Point(7, 5), image.size()));
    detector->detectAndCompute(part, mask, keypoints, descriptors);
    const Features ofPart = {keypoints, descriptors.getMat(ACCESS_READ).clone()};
    EXPECT_TRUE(sameFeatures(expected, ofPart));
    detector->compute(part, keypoints, descriptors);
    const Features computed = {keypoints, descriptors.getMat(ACCESS_READ).clone()};
    EXPECT_TRUE(sameFeatures(expected, computed));
    detector->detectAndCompute(UMat(), noArray(), keypoints, descriptors);
    EXPECT_TRUE(keypoints.empty());
    EXPECT_TRUE(descriptors.empty());
}

TEST(Aqorb_Determinism, colour_equals_its_grey_image)
{
    const Size size(300, 200);
    std::vector<Mat> channels;
    for (int i = 0; i < 4; i++)
        channels.push_back(makeScene(size, i + 1));
    const Ptr<AdaptiveQuadtreeORB> detector = AdaptiveQuadtreeORB::create(300);
    for (int count = 3; count <= 4; count++)
    {
        Mat color, gray;
        merge(&channels[0], count, color);
        cvtColor(color, gray, count == 3 ? COLOR_BGR2GRAY : COLOR_BGRA2GRAY);
        EXPECT_TRUE(sameFeatures(detectAndCompute(*detector, gray), detectAndCompute(*detector, color)));
    }
}

}  // namespace
}  // namespace opencv_test
