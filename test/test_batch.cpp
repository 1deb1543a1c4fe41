// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "backends.hpp"

#include <opencv2/aqorb/slam.hpp>

#include <array>

// Functions for a collection of images give what a call for each image gives.

namespace opencv_test
{
namespace
{

typedef std::vector<KeyPoints> KeyPointLists;

//! Images of all sizes and kinds that a call accepts, with a mask for some of them.
struct Images
{
    explicit Images(int count)
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
            masks.push_back(i % 3 == 1 ? Mat(makeNoise(image.size(), i) > 60) : Mat());
        }
    }
    std::vector<Mat> images, masks;
};

std::vector<Features> oneByOne(Feature2D& detector, const std::vector<Mat>& images,
                               const std::vector<Mat>& masks)
{
    std::vector<Features> all;
    for (size_t i = 0; i < images.size(); i++)
        all.push_back(detectAndCompute(detector, images[i], masks.empty() ? Mat() : masks[i]));
    return all;
}

::testing::AssertionResult areThose(const std::vector<Features>& expected, const KeyPointLists& keypoints,
                                    const std::vector<Mat>& descriptors)
{
    if (keypoints.size() != expected.size() || descriptors.size() != expected.size())
        return ::testing::AssertionFailure() << keypoints.size() << " lists of keypoints and "
                                             << descriptors.size() << " matrices of descriptors";
    for (size_t i = 0; i < expected.size(); i++)
    {
        const Features found = {keypoints[i], descriptors[i]};
        const ::testing::AssertionResult areSame = sameFeatures(expected[i], found);
        if (!areSame)
            return ::testing::AssertionFailure() << "image " << i << ": " << areSame.message();
    }
    return ::testing::AssertionSuccess();
}

//! What all functions for collections give.
void compare(const Ptr<AdaptiveQuadtreeORB>& detector, const std::vector<Mat>& images,
             const std::vector<Mat>& masks, const std::vector<Features>& expected)
{
    KeyPointLists keypoints(3, KeyPoints(5));  // what outputs hold before does not matter
    std::vector<Mat> descriptors(2, Mat(7, 9, CV_32F));
    detector->detectAndComputeBatch(images, masks, keypoints, descriptors);
    EXPECT_TRUE(areThose(expected, keypoints, descriptors));

    const Ptr<Feature2D> feature2D = detector;
    keypoints.assign(1, KeyPoints(5));
    feature2D->detect(images, keypoints, masks);
    EXPECT_TRUE(areThose(expected, keypoints, descriptors));
    const Ptr<ORB> orb = detector;
    descriptors.assign(9, Mat(1, 1, CV_8U));
    orb->compute(images, keypoints, descriptors);
    EXPECT_TRUE(areThose(expected, keypoints, descriptors));

    detector->detectAndComputeBatch(images, masks, keypoints, noArray());
    EXPECT_TRUE(areThose(expected, keypoints, descriptors));
}

TEST(Aqorb_Batch, equals_a_call_for_each_image_with_any_number_of_threads)
{
    const Ptr<AdaptiveQuadtreeORB> detector = AdaptiveQuadtreeORB::create(120);
    for (int count : {0, 1, 2, 7})
    {
        const Images collection(count);
        const std::vector<Features> expected = oneByOne(*detector, collection.images, collection.masks);
        const std::vector<Features> unmasked = oneByOne(*detector, collection.images, std::vector<Mat>());
        for (int number = 1; number <= 4; number++)
        {
            SCOPED_TRACE(format("%d images, %d threads", count, number));
            const Threads threads(number);
            compare(detector, collection.images, collection.masks, expected);
            compare(detector, collection.images, std::vector<Mat>(), unmasked);
        }
    }
}

TEST(Aqorb_Batch, equals_a_call_for_each_image_with_any_backend_of_threads)
{
    const Ptr<AdaptiveQuadtreeORB> detector = AdaptiveQuadtreeORB::create(120);
    const Images collection(7);
    const std::vector<Features> expected = oneByOne(*detector, collection.images, collection.masks);
    for (const std::shared_ptr<Backend>& backend : backends())
    {
        const BackendScope scope(backend);
        for (int number : {2, 4})
        {
            SCOPED_TRACE(number);
            const Threads threads(number);
            compare(detector, collection.images, collection.masks, expected);
        }
    }
}

//! Counts how often cv::parallel_for_ asks for threads, and the most that it asks for.
class Counting : public InTurns
{
public:
    Counting() : calls(0), most(0) {}
    void parallel_for(int stripes, FN_parallel_for_body_cb_t body, void* data) CV_OVERRIDE
    {
        calls++;
        most = std::max(most, stripes);
        InTurns::parallel_for(stripes, body, data);
    }
    int calls, most;
};

TEST(Aqorb_Batch, threads_have_an_image_each_and_share_a_single_one)
{
    const std::shared_ptr<Counting> backend = std::make_shared<Counting>();
    const BackendScope scope(backend);
    const Threads threads(4);
    const Ptr<AdaptiveQuadtreeORB> detector = AdaptiveQuadtreeORB::create(120);
    const std::vector<Mat> images(7, makeScene(Size(120, 100)));
    KeyPointLists keypoints;
    std::vector<Mat> descriptors;
    const int expected[][3] = {{7, 1, 4}, {3, 1, 3}};  // images, calls, stripes
    for (const int* row : expected)
    {
        backend->calls = backend->most = 0;
        detector->detectAndComputeBatch(std::vector<Mat>(images.begin(), images.begin() + row[0]), noArray(),
                                        keypoints, descriptors);
        EXPECT_EQ(row[1], backend->calls) << row[0];
        EXPECT_EQ(row[2], backend->most) << row[0];
    }
    backend->calls = 0;
    {
        const aqorb::SingleThreadScope alone;
        {
            const aqorb::SingleThreadScope inner;
        }
        detector->detectAndComputeBatch(images, noArray(), keypoints, descriptors);
        detectAndCompute(*detector, images[0]);
        EXPECT_EQ(0, backend->calls);
    }
    // The stages of a single image share its work.
    backend->calls = backend->most = 0;
    detector->detectAndComputeBatch(std::vector<Mat>(1, images[0]), noArray(), keypoints, descriptors);
    EXPECT_GT(backend->calls, 1);
    EXPECT_EQ(4, backend->most);
}

TEST(Aqorb_Batch, uses_all_threads_that_are_allowed_but_a_stage_at_most_16)
{
    const std::shared_ptr<Counting> backend = std::make_shared<Counting>();
    const BackendScope scope(backend);
    const Threads threads(40);
    const Ptr<AdaptiveQuadtreeORB> detector = AdaptiveQuadtreeORB::create(50);
    KeyPointLists keypoints;
    for (const int images : {30, 1})
    {
        backend->most = 0;
        detector->detectAndComputeBatch(std::vector<Mat>(images, makeScene(Size(320, 300))), noArray(),
                                        keypoints, noArray());
        EXPECT_EQ(images == 1 ? 16 : 30, backend->most);
    }
}

// cv::cvtColor and cv::resize used to share the work.
TEST(Aqorb_Batch, a_thread_alone_stays_alone_for_colours_and_large_steps_of_the_pyramid)
{
    const std::shared_ptr<Counting> backend = std::make_shared<Counting>();
    const BackendScope scope(backend);
    const Threads threads(4);
    Mat image;
    cvtColor(makeScene(Size(900, 700)), image, COLOR_GRAY2BGR);
    backend->calls = 0;
    const Ptr<AdaptiveQuadtreeORB> detector = AdaptiveQuadtreeORB::create(100, 3.f, 4);
    aqorb::SlamExtractor extractor(100, 3.f, 4, 20, 7);
    KeyPoints keypoints;
    Mat descriptors;
    std::vector<Mat> levels;
    {
        const aqorb::SingleThreadScope alone;
        detector->buildPyramid(image, levels);
        detectAndCompute(*detector, image);
        detector->compute(image, keypoints, descriptors);
    }
    extractor(image, Mat(), keypoints, descriptors);
    EXPECT_EQ(0, backend->calls);
    detectAndCompute(*detector, image);
    EXPECT_GT(backend->calls, 0);
}

TEST(Aqorb_Batch, scopes_of_a_thread_end_in_any_order_and_on_any_thread)
{
    const std::shared_ptr<Counting> backend = std::make_shared<Counting>();
    const BackendScope scope(backend);
    const Threads threads(4);
    const Ptr<AdaptiveQuadtreeORB> detector = AdaptiveQuadtreeORB::create(100);
    const Mat image = makeScene(Size(300, 200));
    const auto isAlone = [&]()
    {
        backend->calls = 0;
        detectAndCompute(*detector, image);
        return backend->calls == 0;
    };
    typedef std::unique_ptr<aqorb::SingleThreadScope> Scope;
    Scope first(new aqorb::SingleThreadScope), second(new aqorb::SingleThreadScope);
    first.reset();
    EXPECT_TRUE(isAlone());
    std::thread([&] { second.reset(); }).join();
    EXPECT_FALSE(isAlone());
    std::thread([&] { first.reset(new aqorb::SingleThreadScope); }).join();
    EXPECT_FALSE(isAlone());
}

TEST(Aqorb_Batch, takes_and_gives_matrices_of_all_kinds)
{
    const Ptr<AdaptiveQuadtreeORB> detector = AdaptiveQuadtreeORB::create(80);
    const Images collection(3);
    const std::vector<Features> expected = oneByOne(*detector, collection.images, collection.masks);
    const Threads threads(2);
    KeyPointLists keypoints;

    std::vector<UMat> images(3), masks(3), descriptors(1, UMat(2, 2, CV_8U));
    for (int i = 0; i < 3; i++)
    {
        collection.images[i].copyTo(images[i]);
        collection.masks[i].copyTo(masks[i]);
    }
    const UMat shared = descriptors[0];
    detector->detectAndComputeBatch(images, masks, keypoints, descriptors);
    std::vector<Mat> copies(3);
    for (int i = 0; i < 3; i++)
        descriptors[i].copyTo(copies[i]);
    EXPECT_TRUE(areThose(expected, keypoints, copies));
    EXPECT_EQ(Size(2, 2), shared.size());

    std::array<Mat, 3> arrays;
    detector->detectAndComputeBatch(collection.images, collection.masks, keypoints, arrays);
    EXPECT_TRUE(areThose(expected, keypoints, std::vector<Mat>(arrays.begin(), arrays.end())));

    // The images themselves may become the descriptors.
    std::vector<Mat> both = collection.images;
    detector->detectAndComputeBatch(both, collection.masks, keypoints, both);
    EXPECT_TRUE(areThose(expected, keypoints, both));
}

// The message of the exception that a call raises, empty if it raises none. The outputs are to stay what they are.
template <typename Call> std::string messageOfBatch(const Call& call)
{
    KeyPointLists keypoints(7, KeyPoints(2, KeyPoint(1, 2, 3)));
    std::vector<Mat> descriptors(1, Mat(5, 5, CV_8U, Scalar(5)));
    const std::string message = opencv_test::messageOf([&] { call(keypoints, descriptors); });
    EXPECT_EQ(7u, keypoints.size());
    for (const KeyPoints& ofImage : keypoints)
        EXPECT_TRUE(sameKeypoints(KeyPoints(2, KeyPoint(1, 2, 3)), ofImage));
    EXPECT_EQ(1u, descriptors.size());
    EXPECT_TRUE(sameMat(Mat(5, 5, CV_8U, Scalar(5)), descriptors[0]));
    return message;
}

TEST(Aqorb_Batch, an_error_names_the_first_image_with_any_number_of_threads)
{
    const Ptr<AdaptiveQuadtreeORB> detector = AdaptiveQuadtreeORB::create(80);
    Images collection(7);
    collection.masks.assign(7, Mat());
    collection.masks[3] = Mat(9, 9, CV_8U);
    collection.images[5] = Mat(50, 40, CV_32F);
    const std::string ofMask =
                          "images[3]: mask must be CV_8UC1 of the image's size, 171 x 140, got 9 x 9 of type "
                          "CV_8UC1",
                      ofImage =
                          "images[5]: image must be CV_8U with 1 (grey), 3 (BGR) or 4 (BGRA) channels, got 2 "
                          "dimensions of type CV_32FC1";
    const std::vector<std::shared_ptr<Backend>> all = backends();
    for (size_t i = 0; i < all.size(); i++)
    {
        const BackendScope scope(all[i]);
        for (int number = 1; number <= 4; number++)
        {
            SCOPED_TRACE(format("backend %d, %d threads", int(i), number));
            const Threads threads(number);
            const auto batch = [&](InputArrayOfArrays masks)
            {
                return messageOfBatch(
                    [&](KeyPointLists& keypoints, std::vector<Mat>& descriptors)
                    { detector->detectAndComputeBatch(collection.images, masks, keypoints, descriptors); });
            };
            EXPECT_EQ(ofMask, batch(collection.masks));
            EXPECT_EQ(ofImage, batch(noArray()));
            EXPECT_EQ(ofMask,
                      messageOfBatch([&](KeyPointLists& keypoints, std::vector<Mat>&)
                                     { detector->detect(collection.images, keypoints, collection.masks); }));
            EXPECT_EQ(ofImage,
                      messageOfBatch([&](KeyPointLists& keypoints, std::vector<Mat>& descriptors)
                                     { detector->compute(collection.images, keypoints, descriptors); }));
        }
    }
    // The detector is as good as before.
    collection.images.resize(3);
    compare(detector, collection.images, std::vector<Mat>(),
            oneByOne(*detector, collection.images, std::vector<Mat>()));
}

TEST(Aqorb_Batch, bad_collections)
{
    const Ptr<AdaptiveQuadtreeORB> detector = AdaptiveQuadtreeORB::create(80);
    const Images collection(2);
    const std::vector<Mat>& images = collection.images;
    const Mat& image = images[0];
    const std::string vectors = " must be a vector of Mat or UMat";
#define AQORB_SAYS(message, ...)                                                        \
    EXPECT_EQ(message, messageOfBatch(                                                  \
                           [&](KeyPointLists& keypoints, std::vector<Mat>& descriptors) \
                           {                                                            \
                               (void)descriptors;                                       \
                               detector->__VA_ARGS__;                                   \
                           }))
    AQORB_SAYS("images" + vectors, detectAndComputeBatch(image, noArray(), keypoints, descriptors));
    AQORB_SAYS("masks" + vectors, detectAndComputeBatch(images, image, keypoints, descriptors));
    Mat single;
    AQORB_SAYS("descriptors" + vectors, detectAndComputeBatch(images, noArray(), keypoints, single));
    AQORB_SAYS("masks must be one for each image or none, got 3 for 2 images",
               detectAndComputeBatch(images, std::vector<Mat>(3), keypoints, descriptors));
    AQORB_SAYS("masks must be one for each image or none, got 1 for 2 images",
               detect(images, keypoints, std::vector<Mat>(1)));
    AQORB_SAYS("keypoints must be one vector for each image, got 7 for 2 images",
               compute(images, keypoints, descriptors));
    std::array<Mat, 3> three;
    AQORB_SAYS("descriptors must have a variable size or that of 2 images, got 3 images",
               detectAndComputeBatch(images, noArray(), keypoints, three));
    std::vector<Mat_<float>> floats;
    AQORB_SAYS("descriptors must be of type CV_8UC1, got CV_32FC1",
               detectAndComputeBatch(images, noArray(), keypoints, floats));
#undef AQORB_SAYS
}

TEST(Aqorb_Batch, compute_keeps_keypoints_of_empty_images_as_a_single_call_does)
{
    const Ptr<AdaptiveQuadtreeORB> detector = AdaptiveQuadtreeORB::create(80);
    std::vector<Mat> images(2), descriptors(2, Mat(3, 3, CV_8U));
    images[1] = makeScene(Size(90, 80));
    KeyPointLists keypoints(2, KeyPoints(3, KeyPoint(45, 40, 31, 0)));
    keypoints[1][2].pt.x = 1000;
    KeyPoints single = keypoints[0];
    Mat ofSingle(3, 3, CV_8U);
    detector->compute(Mat(), single, ofSingle);
    detector->compute(images, keypoints, descriptors);
    EXPECT_TRUE(sameKeypoints(single, keypoints[0]));
    EXPECT_TRUE(sameMat(ofSingle, descriptors[0]));
    EXPECT_EQ(2u, keypoints[1].size());
    EXPECT_EQ(2, descriptors[1].rows);

    KeyPointLists before = keypoints;
    detector->compute(images, keypoints, noArray());  // does nothing, as cv::ORB
    EXPECT_TRUE(sameKeypoints(before[1], keypoints[1]));
}

TEST(Aqorb_Batch, several_threads_may_use_one_detector)
{
    const Ptr<AdaptiveQuadtreeORB> detector = AdaptiveQuadtreeORB::create(120);
    const Images collection(7);
    const std::vector<Features> expected = oneByOne(*detector, collection.images, collection.masks);
    std::vector<std::thread> callers;
    std::atomic<int> right(0);
    for (int i = 0; i < 3; i++)
        callers.push_back(std::thread(
            [&]
            {
                for (int round = 0; round < 5; round++)
                {
                    KeyPointLists keypoints;
                    std::vector<Mat> descriptors;
                    detector->detectAndComputeBatch(collection.images, collection.masks, keypoints,
                                                    descriptors);
                    right += bool(areThose(expected, keypoints, descriptors));
                }
            }));
    for (std::thread& caller : callers)
        caller.join();
    EXPECT_EQ(15, right);
}

}  // namespace
}  // namespace opencv_test
