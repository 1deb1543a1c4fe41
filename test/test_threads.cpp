// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "backends.hpp"
#include "reference.hpp"

#include <opencv2/aqorb/slam.hpp>

#include <array>

// However many threads OpenCV or the caller has, and for one image or a collection, the bytes are the same.

namespace opencv_test
{
namespace
{

typedef std::vector<KeyPoints> KeyPointLists;

TEST(Aqorb_Threads, threads_1_to_16_of_any_backend_give_the_same_bytes)
{
    const Mat scene = makeScene(Size(300, 420), 2), mask = makeNoise(scene.size(), 3) > 5;
    Mat colored, upper = makeScene(Size(160, 400), 7);
    cvtColor(makeScene(Size(160, 120), 4), colored, COLOR_GRAY2BGR);
    upper.rowRange(60, 400).setTo(90);  // some bands have too few corners, and others none
    const struct
    {
        Mat image, mask;
        int nfeatures;
        AdaptiveQuadtreeORB::SelectionType selection;
    } cases[] = {{scene, Mat(), 500, AdaptiveQuadtreeORB::RANKED_SELECTION},
                 {scene, mask, 300, AdaptiveQuadtreeORB::RANKED_SELECTION},
                 {colored, Mat(), 5000, AdaptiveQuadtreeORB::RANKED_SELECTION},  // more than there are
                 {scene, Mat(), 400, AdaptiveQuadtreeORB::QUADTREE_SELECTION},
                 {upper, Mat(), 80, AdaptiveQuadtreeORB::RANKED_SELECTION},
                 {upper, Mat(), 240, AdaptiveQuadtreeORB::RANKED_SELECTION},
                 {upper, Mat(), 640, AdaptiveQuadtreeORB::RANKED_SELECTION}};
    for (const auto& c : cases)
    {
        reference::Settings settings;
        settings.nfeatures = c.nfeatures;
        settings.selectionType = c.selection;
        const Features expected = reference::detectAndCompute(c.image, c.mask, settings);
        ASSERT_GE(expected.keypoints.size(), 80u);
        const Ptr<AdaptiveQuadtreeORB> detector = settings.create();
        for (const std::shared_ptr<Backend>& backend : backends())
        {
            const BackendScope scope(backend);
            for (int count = 0; count <= 16; count += !backend || count < 3 ? 1 : 4)
            {
                const Threads threads(count);
                EXPECT_TRUE(finds(*detector, c.image, c.mask, expected))
                    << c.nfeatures << " features, " << count << " threads";
            }
        }
    }
}

//! Images of all sizes and kinds that a call accepts, with a mask for some of them, and the features that a call for
//! each of them finds.
struct Collection
{
    Collection(Feature2D& detector, int count, bool hasMasks)
    {
        for (int i = 0; i < count; i++)
        {
            Mat image = makeScene(Size(60 + 37 * i, 200 - 20 * i), i + 1);
            if (i % 4 != 0)
                cvtColor(image, image, i % 4 == 1 ? COLOR_GRAY2BGR : COLOR_GRAY2BGRA);
            if (i == 6)
                image.release();
            if (i == 5)
                image.setTo(9);  // there is nothing to find
            images.push_back(image);
            if (hasMasks)
                masks.push_back(i % 3 == 1 ? Mat(makeNoise(image.size(), i) > 60) : Mat());
            features.push_back(detectAndCompute(detector, image, hasMasks ? masks[i] : Mat()));
        }
    }

    ::testing::AssertionResult has(const KeyPointLists& keypoints, const std::vector<Mat>& descriptors) const
    {
        if (keypoints.size() != features.size() || descriptors.size() != features.size())
            return ::testing::AssertionFailure() << keypoints.size() << " lists of keypoints and "
                                                 << descriptors.size() << " matrices of descriptors";
        for (size_t i = 0; i < features.size(); i++)
        {
            const auto areSame = sameFeatures(features[i], Features{keypoints[i], descriptors[i]});
            if (!areSame)
                return ::testing::AssertionFailure() << "image " << i << ": " << areSame.message();
        }
        return ::testing::AssertionSuccess();
    }

    std::vector<Mat> images, masks;
    std::vector<Features> features;
};

//! Whether all functions for collections find the features of one.
::testing::AssertionResult finds(AdaptiveQuadtreeORB& detector, const Collection& collection)
{
    // The previous content of the outputs does not matter.
    KeyPointLists found(3, KeyPoints(5)), detected(1, KeyPoints(5)), keypoints;
    std::vector<Mat> descriptors(2, Mat(7, 9, CV_32F)), computed(9, Mat(1, 1, CV_8U));
    detector.detectAndComputeBatch(collection.images, collection.masks, found, descriptors);
    static_cast<Feature2D&>(detector).detect(collection.images, detected, collection.masks);
    static_cast<ORB&>(detector).compute(collection.images, detected, computed);
    detector.detectAndComputeBatch(collection.images, collection.masks, keypoints, noArray());
    for (const auto& result : {collection.has(found, descriptors), collection.has(detected, computed),
                               collection.has(keypoints, computed)})
    {
        if (!result)
            return result;
    }
    return ::testing::AssertionSuccess();
}

TEST(Aqorb_Threads, threads_of_any_backend_treat_a_collection_like_single_images)
{
    const Ptr<AdaptiveQuadtreeORB> detector = AdaptiveQuadtreeORB::create(120);
    for (int size : {0, 1, 2, 7})
        for (bool hasMasks : {false, true})
        {
            const Collection collection(*detector, size, hasMasks);
            for (const std::shared_ptr<Backend>& backend : backends())
            {
                const BackendScope scope(backend);
                for (int count = 1; count <= 4; count++)
                {
                    const Threads threads(count);
                    EXPECT_TRUE(finds(*detector, collection)) << size << " images, " << count << " threads";
                }
            }
        }
}

TEST(Aqorb_Threads, threads_of_the_caller_give_the_same_bytes)
{
    const int CALLERS = 12;
    const Ptr<AdaptiveQuadtreeORB> detector = AdaptiveQuadtreeORB::create(300);
    const Mat image = makeScene(Size(300, 420), 2);
    const Features expected = detectAndCompute(*detector, image);
    const Collection collection(*detector, 4, true);
    for (const std::shared_ptr<Backend>& backend : backends())
    {
        const BackendScope scope(backend);
        const Threads threads(4);
        std::vector<int> failed(CALLERS, 1);
        const auto callSome = [&](const Range& range)
        {
            for (int i = range.start; i < range.end; i++)
                failed[i] = !finds(*detector, image, Mat(), expected) || !finds(*detector, collection);
        };
        // Two threads, of which one has OpenCV's threads, whose loops call the detector.
        std::vector<std::thread> callers;
        for (int i = 0; i < CALLERS; i += CALLERS / 2)
            callers.push_back(
                std::thread([&, i] { parallel_for_(Range(i, i + CALLERS / 2), callSome, CALLERS / 2); }));
        for (std::thread& caller : callers)
            caller.join();
        EXPECT_EQ(std::vector<int>(CALLERS, 0), failed);
    }
}

TEST(Aqorb_Threads, threads_have_an_image_each_and_up_to_16_share_a_single_one)
{
    const struct
    {
        int threads, images, stripes;
    } cases[] = {{4, 7, 4}, {4, 3, 3}, {40, 30, 30}, {4, 1, 4}, {40, 1, 16}};
    const Ptr<AdaptiveQuadtreeORB> detector = AdaptiveQuadtreeORB::create(50);
    KeyPointLists keypoints;
    for (const auto& c : cases)
    {
        const std::shared_ptr<Counting> backend = std::make_shared<Counting>();
        const BackendScope scope(backend);
        const Threads threads(c.threads);
        detector->detectAndComputeBatch(std::vector<Mat>(c.images, makeScene(Size(320, 300))), noArray(),
                                        keypoints, noArray());
        EXPECT_EQ(c.images > 1, backend->calls == 1) << backend->calls;
        EXPECT_EQ(c.stripes, backend->maxStripes) << c.images << " images, " << c.threads << " threads";
    }
}

// The functions of OpenCV that convert colours and shrink an image by more than a half share their work, too.
TEST(Aqorb_Threads, threads_stay_alone_until_their_last_scope_ends_on_any_thread)
{
    Mat image;
    cvtColor(makeScene(Size(900, 700)), image, COLOR_GRAY2BGR);
    const std::vector<Mat> images(3, image);
    Features features;
    const std::shared_ptr<Counting> backend = std::make_shared<Counting>();
    const BackendScope scope(backend);
    const Threads threads(4);
    const Ptr<AdaptiveQuadtreeORB> detector = AdaptiveQuadtreeORB::create(100, 3.f, 4);
    aqorb::SlamExtractor extractor(100, 3.f, 4, 20, 7);
    extractor(image, Mat(), features.keypoints, features.descriptors);
    EXPECT_EQ(0, backend->calls);
    const auto countCalls = [&]
    {
        KeyPointLists lists;
        std::vector<Mat> levels;
        backend->calls = 0;
        detector->buildPyramid(image, levels);
        detectAndCompute(*detector, image);
        detector->compute(image, features.keypoints, features.descriptors);
        detector->detectAndComputeBatch(images, noArray(), lists, noArray());
        std::vector<KeyPoint> large = detectAndCompute(*detector, image).keypoints, grown1, grown2;
        std::vector<DMatch> matches;
        std::vector<Point2f> points1, points2;
        std::vector<float> deviations;
        for (int i = 0; i < int(large.size()); i++)
        {
            large[i].size = 200;  // patches of smaller levels
            matches.push_back(DMatch(i, i, 0));
        }
        aqorb::growMatches(image, large, image, large, matches, grown1, grown2, points1, points2, deviations);
        return backend->calls;
    };
    typedef std::unique_ptr<aqorb::SingleThreadScope> Scope;
    Scope first(new aqorb::SingleThreadScope), second(new aqorb::SingleThreadScope);
    EXPECT_EQ(0, countCalls());
    first.reset();
    EXPECT_EQ(0, countCalls());
    std::thread([&] { second.reset(); }).join();
    EXPECT_GT(countCalls(), 3);
    std::thread([&] { first.reset(new aqorb::SingleThreadScope); }).join();
    EXPECT_GT(countCalls(), 3);
}

TEST(Aqorb_Threads, collections_are_matrices_of_all_kinds)
{
    const Ptr<AdaptiveQuadtreeORB> detector = AdaptiveQuadtreeORB::create(80);
    const Collection collection(*detector, 3, true);
    KeyPointLists keypoints;

    std::vector<UMat> images(3), masks(3), descriptors(1, UMat(2, 2, CV_8U));
    std::vector<Mat> copies(3);
    for (int i = 0; i < 3; i++)
    {
        collection.images[i].copyTo(images[i]);
        collection.masks[i].copyTo(masks[i]);
    }
    const UMat shared = descriptors[0];
    detector->detectAndComputeBatch(images, masks, keypoints, descriptors);
    for (int i = 0; i < 3; i++)
        descriptors[i].copyTo(copies[i]);
    EXPECT_TRUE(collection.has(keypoints, copies));
    EXPECT_EQ(Size(2, 2), shared.size());

    std::array<Mat, 3> arrays;
    detector->detectAndComputeBatch(collection.images, collection.masks, keypoints, arrays);
    EXPECT_TRUE(collection.has(keypoints, std::vector<Mat>(arrays.begin(), arrays.end())));

    // The images themselves may become the descriptors.
    copies = collection.images;
    detector->detectAndComputeBatch(copies, collection.masks, keypoints, copies);
    EXPECT_TRUE(collection.has(keypoints, copies));
}

TEST(Aqorb_Threads, threads_report_the_error_of_the_first_image)
{
    const Ptr<AdaptiveQuadtreeORB> detector = AdaptiveQuadtreeORB::create(80);
    const Collection good(*detector, 3, false);
    std::vector<Mat> images = Collection(*detector, 7, false).images, masks(7);
    masks[3] = Mat(9, 9, CV_8U);
    images[5] = Mat(50, 40, CV_32F);
    const KeyPoints before(2, KeyPoint(1, 2, 3));
    KeyPointLists keypoints(7, before);
    std::vector<Mat> descriptors(1, Mat(5, 5, CV_8U, Scalar(5)));
    const std::string maskError =
        "images[3]: mask must be CV_8UC1 of the image's size, 171 x 140, got 9 x 9 of type CV_8UC1";
    const std::string imageError = "images[5]: image must be CV_8U with 1 (grey), 3 (BGR) or 4 (BGRA) "
                                   "channels, got 2 dimensions of type CV_32FC1";
    for (const std::shared_ptr<Backend>& backend : backends())
    {
        const BackendScope scope(backend);
        for (int count = 1; count <= 4; count++)
        {
            SCOPED_TRACE(count);
            const Threads threads(count);
            const auto batchError = [&](InputArrayOfArrays m) {
                return messageOf([&] { detector->detectAndComputeBatch(images, m, keypoints, descriptors); });
            };
            EXPECT_EQ(maskError, batchError(masks));
            EXPECT_EQ(imageError, batchError(noArray()));
            EXPECT_EQ(maskError, messageOf([&] { detector->detect(images, keypoints, masks); }));
            EXPECT_EQ(imageError, messageOf([&] { detector->compute(images, keypoints, descriptors); }));
        }
    }
    ASSERT_TRUE(keypoints.size() == 7 && descriptors.size() == 1);
    for (const KeyPoints& list : keypoints)
        EXPECT_TRUE(sameKeypoints(before, list));
    EXPECT_TRUE(sameMat(Mat(5, 5, CV_8U, Scalar(5)), descriptors[0]));
    EXPECT_TRUE(finds(*detector, good));  // The detector is as good as before.
}

TEST(Aqorb_Threads, compute_keeps_keypoints_of_empty_images_in_a_collection)
{
    std::vector<Mat> images = {Mat(), makeScene(Size(90, 80))}, descriptors(2, Mat(3, 3, CV_8U));
    KeyPointLists keypoints(2, KeyPoints(3, KeyPoint(45, 40, 31, 0)));
    AdaptiveQuadtreeORB::create(80)->compute(images, keypoints, descriptors);
    EXPECT_EQ(3u, keypoints[0].size());
    EXPECT_TRUE(descriptors[0].empty());
    EXPECT_EQ(3u, keypoints[1].size());
    EXPECT_EQ(Size(32, 3), descriptors[1].size());
}

}  // namespace
}  // namespace opencv_test
