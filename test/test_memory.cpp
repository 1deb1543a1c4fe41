// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "reference.hpp"

#include <opencv2/core/hal/intrin.hpp>

#include <atomic>
#include <thread>

#if defined(__linux__)
#include <sys/resource.h>
#endif

// The memory of inputs and outputs, and the work space that an object keeps from call to call.

namespace opencv_test
{
namespace
{

#if defined(__linux__)
//! The most memory that the program has had, in bytes.
long long peakMemory()
{
    rusage usage;
    getrusage(RUSAGE_SELF, &usage);
    return usage.ru_maxrss * 1024LL;
}

// cv::BFMatcher needs 400 MB for the distances alone.
TEST(Aqorb_Memory, matching_needs_no_matrix_of_distances)
{
    if (!isHeapKnown())
        AQORB_SKIP("the heap in use is not known here");
    const Mat query = makeNoise(Size(32, 10000), 1), train = makeNoise(Size(32, 10000), 2);
    std::vector<DMatch> matches;
    std::vector<std::vector<DMatch>> lists;
    const long long before = peakMemory();
    aqorb::HammingMatcher(NORM_HAMMING, true).match(query, train, matches);
    aqorb::HammingMatcher().knnMatch(query, train, lists, 2);
    aqorb::HammingMatcher().knnMatch(query, train, lists, 5);
    aqorb::HammingMatcher().radiusMatch(query, train, lists, 80);
    EXPECT_LT(peakMemory() - before, 100000000);
}
#endif

TEST(Aqorb_Memory, work_space_is_small)
{
    if (!isHeapKnown())
        AQORB_SKIP("the heap in use is not known here");
    std::vector<Mat> images = dataFile("").empty() ? std::vector<Mat>() : photographs();
    for (const Size& size : {Size(1280, 720), Size(1920, 1080)})
        images.push_back(makeScene(size, 3));
    for (const Mat& image : images)
        for (int count = 1; count <= 2 && image.total() > 200000; count++)  // else keypoints need the most
        {
            SCOPED_TRACE(format("%d x %d, %d threads", image.cols, image.rows, count));
            const Threads threads(count);
            // Outputs that need not grow. And OpenCV, which allocates memory for threads, does it now.
            Features features = detectAndCompute(*AdaptiveQuadtreeORB::create(1000), image);
            const long long before = heapInUse();
            const Ptr<AdaptiveQuadtreeORB> detector = AdaptiveQuadtreeORB::create(1000);
            for (int i = 0; i < 10; i++)  // which threads take which part is chance
                detector->detectAndCompute(image, noArray(), features.keypoints, features.descriptors);
            // Without vectors there is a block of the scan for each pixel, and their lists are longer.
            const double limit = (count == 1 ? 5 : 7.5) * (CV_SIMD ? 1 : 1.5);
            EXPECT_LE(double(heapInUse() - before), limit * double(image.total()));
        }
}

TEST(Aqorb_Memory, is_one_work_space_for_each_thread_and_freed_on_request)
{
    if (!isHeapKnown())
        AQORB_SKIP("the heap in use is not known here");
    // Large, so that the memory of OpenCV for its threads hardly counts.
    const std::vector<Mat> images(40, makeScene(Size(640, 480), 1));
    std::vector<KeyPoints> keypoints(40);
    const Ptr<AdaptiveQuadtreeORB> detector = AdaptiveQuadtreeORB::create(300);
    const auto workSpace = [&](int threads)
    {
        const Threads scope(threads);
        keypoints.clear();
        const long long before = heapInUse();
        detector->detect(images, keypoints);
        keypoints.clear();
        const long long after = heapInUse();
        detector->releaseMemory();
        EXPECT_LE(heapInUse() - before, (after - before) / 10);
        return after - before;
    };
    detector->releaseMemory();  // there is none
    {
        const Threads two(2);  // for which OpenCV allocates memory once
        detector->detect(images, keypoints);
    }
    detector->releaseMemory();
    const long long single = workSpace(1), twofold = workSpace(2);
    EXPECT_GT(single, 2 * 640 * 480);
    EXPECT_LE(twofold, 2 * single + single / 10);
}

TEST(Aqorb_Memory, inputs_are_neither_written_to_nor_kept_and_outputs_are_the_callers)
{
    const Mat image = makeScene(Size(180, 140)), mask = makeNoise(image.size()) > 10;
    const Mat imageBefore = image.clone(), maskBefore = mask.clone();
    const Mat noPixel(image.size(), CV_16UC1, Scalar(0));
    for (int firstLevel = 0; firstLevel < 3; firstLevel++)
    {
        const Ptr<AdaptiveQuadtreeORB> detector = AdaptiveQuadtreeORB::create(200, 1.2f, 5, 8, firstLevel);
        for (int round = 0; round < 2; round++)
        {
            const Features kept = detectAndCompute(*detector, image, mask);
            Features features = {kept.keypoints, kept.descriptors.clone()};
            // The levels of another image of the same size go where those of this one went.
            detectAndCompute(*detector, makeNoise(image.size(), 3));
            EXPECT_TRUE(sameFeatures(features, kept));
            detector->compute(image, features.keypoints, features.descriptors);
            EXPECT_THROW(detector->detect(noPixel, features.keypoints), cv::Exception);
            EXPECT_THROW(detector->detect(image, features.keypoints, noPixel), cv::Exception);
            EXPECT_TRUE(sameMat(imageBefore, image));
            EXPECT_TRUE(sameMat(maskBefore, mask));
        }
        for (const Mat& input : {std::cref(image), std::cref(mask), std::cref(noPixel)})
            EXPECT_EQ(1, input.u->refcount);
    }
}

TEST(Aqorb_Memory, outputs_may_hold_anything_and_may_be_left_out)
{
    const Ptr<AdaptiveQuadtreeORB> detector = AdaptiveQuadtreeORB::create(100);
    const Mat image = makeScene(Size(200, 150));
    const Features expected = detectAndCompute(*detector, image);
    ASSERT_EQ(100, expected.descriptors.rows);
    Mat large(104, 40, CV_8UC1, Scalar(77));
    const Rect part(5, 2, 32, 100);  // whose rows are not contiguous
    for (const Mat& output : {Mat(), Mat(100, 32, CV_32FC1, Scalar(3)), Mat(7, 9, CV_8UC3, Scalar::all(3)),
                              Mat(100, 32, CV_8UC1, Scalar(3)), large(part)})
    {
        Features features = {KeyPoints(333), output};
        detector->detectAndCompute(image, noArray(), features.keypoints, features.descriptors);
        EXPECT_TRUE(sameFeatures(expected, features));
    }
    EXPECT_TRUE(sameMat(expected.descriptors, large(part)));
    EXPECT_TRUE(isAround(large(part), 77));

    KeyPoints keypoints;
    detector->detectAndCompute(image, noArray(), keypoints, noArray());
    EXPECT_TRUE(sameKeypoints(expected.keypoints, keypoints));
    // Without outputs there is nothing to do, so the keypoints are not even looked at. cv::ORB does the same.
    keypoints.assign(3, KeyPoint(Point2f(-5, 1e9f), 31.f, 0.f, 0.f, -4));
    const KeyPoints given = keypoints;
    detector->detectAndCompute(image, noArray(), keypoints, noArray(), true);
    EXPECT_TRUE(sameKeypoints(given, keypoints));
    // Without keypoints there are no descriptors.
    Features none = {KeyPoints(), Mat(3, 32, CV_8UC1)};
    detector->compute(image, none.keypoints, none.descriptors);
    EXPECT_TRUE(sameFeatures(Features(), none));
}

template <typename Matrix> Matrix copyOf(InputArray source)
{
    Matrix copy;
    source.copyTo(copy);
    return copy;
}

//! The features of an image with and without its mask, and the descriptors computed for the former.
std::vector<Features> allFeatures(Feature2D& detector, InputArray image, InputArray mask)
{
    const Features masked = detectAndCompute(detector, image, mask);
    Features computed = {masked.keypoints, Mat()};
    // With firstLevel > 0 it may drop a keypoint near the border, as cv::ORB does.
    detector.compute(image, computed.keypoints, computed.descriptors);
    return {masked, detectAndCompute(detector, image), computed};
}

void expectSame(const std::vector<Features>& expected, const std::vector<Features>& found)
{
    for (size_t i = 0; i < expected.size(); i++)
        EXPECT_TRUE(sameFeatures(expected[i], found[i])) << i;
}

// The content of the larger matrices around image and mask changes. Without a border, and with the narrow one, the
// detector reads pixels beyond the sides of the image.
TEST(Aqorb_Memory, mats_umats_and_regions_have_the_same_features)
{
    const Size size(200, 150);
    const Rect region(Point(29, 23), size);
    Mat image, mask = makeScene(size, 8) > 120;  // holes with many edges
    cvtColor(makeScene(size, 7), image, COLOR_GRAY2BGR);
    for (int border : {0, 3, 16})
        for (int firstLevel = 0; firstLevel <= 1; firstLevel++)
        {
            const Ptr<AdaptiveQuadtreeORB> detector =
                AdaptiveQuadtreeORB::create(200, 1.2f, 8, border, firstLevel);
            const std::vector<Features> expected = allFeatures(*detector, image, mask);
            ASSERT_EQ(200u, expected[0].keypoints.size());
            EXPECT_GE(expected[2].keypoints.size(), 190u);
            for (int around = 0; around <= 255; around += 51)
            {
                SCOPED_TRACE(format("border %d, first level %d, around %d", border, firstLevel, around));
                Mat largeImage(260, 310, CV_8UC3, Scalar::all(around));
                Mat largeMask(260, 310, CV_8UC1, Scalar(around));
                image.copyTo(largeImage(region));
                mask.copyTo(largeMask(region));
                expectSame(expected, allFeatures(*detector, largeImage(region), largeMask(region)));
                expectSame(expected, allFeatures(*detector, copyOf<UMat>(largeImage)(region),
                                                 copyOf<UMat>(largeMask)(region)));
            }
        }
}

//! The descriptors take the memory of the image, or that of the mask.
template <typename Matrix> void expectOverwritten(Feature2D& detector, const Mat& image)
{
    const Features expected = detectAndCompute(detector, image);
    Matrix given = copyOf<Matrix>(image), computed = given.clone(), mask(image.size(), CV_8UC1, Scalar(1));
    std::vector<Features> found(4);
    detector.detectAndCompute(given, noArray(), found[0].keypoints, given);
    found[0].descriptors = copyOf<Mat>(given);
    detector.detectAndCompute(image, mask, found[1].keypoints, mask);
    found[1].descriptors = copyOf<Mat>(mask);
    found[2].keypoints = expected.keypoints;
    detector.compute(computed, found[2].keypoints, computed);
    found[2].descriptors = copyOf<Mat>(computed);
    // The image has no reference to the memory, which the output owns and may give up. The address sanitizer finds a
    // later access for certain.
    found[3].descriptors = image.clone();
    const Mat unowned(image.size(), CV_8UC1, found[3].descriptors.data);
    detector.detectAndCompute(unowned, noArray(), found[3].keypoints, found[3].descriptors);
    expectSame(std::vector<Features>(4, expected), found);
}

TEST(Aqorb_Memory, outputs_may_lie_in_the_memory_of_inputs)
{
    // The shape of the noise is that of its descriptors. The others have another shape, so that the output lets go of
    // the input while it is in use.
    const Mat noise = makeNoise(Size(32, 600)), scene = makeScene(Size(160, 120), 3),
              flat(scene.size(), CV_8UC1, Scalar(7));
    const Ptr<AdaptiveQuadtreeORB> detector = AdaptiveQuadtreeORB::create(600, 1.2f, 3, 4);
    detector->setFastThreshold(5);
    ASSERT_EQ(noise.size(), detectAndCompute(*detector, noise).descriptors.size());
    for (int count = 1; count <= 2; count++)
        for (const Mat& image : {noise, scene, flat})
        {
            const Threads threads(count);
            expectOverwritten<Mat>(*detector, image);
            expectOverwritten<UMat>(*detector, image);
        }

    // Positions are looked up in the mask while descriptors are computed.
    Mat holes = makeNoise(noise.size(), 3) > 40;
    detector->setMaxFeatures(500);
    const Features expected = detectAndCompute(*detector, noise, holes);
    ASSERT_EQ(500, expected.descriptors.rows);
    Features found = {KeyPoints(), holes.rowRange(100, 600)};
    detector->detectAndCompute(noise, holes, found.keypoints, found.descriptors);
    EXPECT_TRUE(sameFeatures(expected, found));
}

TEST(Aqorb_Memory, the_pyramid_may_go_into_the_vector_that_holds_the_image)
{
    const Mat scene = makeScene(Size(160, 120), 3);
    for (int firstLevel : {0, 1, 3})
        for (int place = 0; place < 6; place++)  // also beyond the levels
        {
            SCOPED_TRACE(format("first level %d, place %d", firstLevel, place));
            const auto detector = AdaptiveQuadtreeORB::create(500, 1.2f, 4, 16, firstLevel);
            std::vector<Mat> expected, levels(6), owners(6);
            std::vector<UMat> ulevels(6);
            levels[place] = scene.clone();
            owners[place] = scene.clone();
            ulevels[place] = copyOf<UMat>(scene);
            detector->buildPyramid(scene, expected);
            detector->buildPyramid(levels[place], levels);
            detector->buildPyramid(Mat(scene.size(), CV_8UC1, owners[place].data), owners);
            detector->buildPyramid(ulevels[place], ulevels);
            ASSERT_TRUE(levels.size() == 4 && owners.size() == 4 && ulevels.size() == 4);
            for (int i = 0; i < 4; i++)
                EXPECT_TRUE(sameMat(expected[i], levels[i]) && sameMat(expected[i], owners[i]) &&
                            sameMat(expected[i], copyOf<Mat>(ulevels[i])));
        }
}

//! Whether a call fails: before the image is read, before the mask is, or while the work space is in use.
bool fails(Feature2D& detector, const Mat& image, int kind)
{
    Features features = {KeyPoints(1, KeyPoint(Point2f(9, 9), 31.f, 0.f, 0.f, 1 << 20)), Mat()};
    const std::function<void()> calls[] = {
        [&] { detector.detect(Mat(10, 10, CV_32FC1, Scalar(0)), features.keypoints); },
        [&] { detector.detect(image, features.keypoints, Mat(7, 7, CV_8UC1, Scalar(1))); },
        [&] { detector.compute(image, features.keypoints, features.descriptors); }};
    return !messageOf(calls[kind]).empty();
}

TEST(Aqorb_Memory, an_object_finds_what_a_new_one_finds)
{
    RNG rng(20);
    const Ptr<AdaptiveQuadtreeORB> used = AdaptiveQuadtreeORB::create();
    reference::Settings settings, tooLarge;
    tooLarge.nlevels = 60;
    tooLarge.firstLevel = 59;
    tooLarge.scaleFactor = 1e6;  // a level of more pixels than can be
    for (int round = 0; round < 80; round++)
    {
        SCOPED_TRACE(round);
        if (round % 3 != 1)  // Every third time only the image changes.
            settings = reference::randomSettings(rng);
        const Size size(rng.uniform(30, 200), rng.uniform(30, 200));
        Mat image = round % 5 ? makeScene(size, round + 1) : makeNoise(size, round + 1), mask;
        if (round % 16 == 7)
            image.setTo(7);  // There is nothing to find.
        if (round % 4 == 0)
            resize(makeNoise(size / 8 + Size(1, 1), round + 9) > 60, mask, size, 0, 0, INTER_NEAREST);
        if (round % 3 == 2)
            tooLarge.set(*used);
        EXPECT_TRUE(fails(*used, image, round % 3));
        settings.set(*used);
        expectSame(allFeatures(*settings.create(), image, mask), allFeatures(*used, image, mask));
    }
}

// The long run: frames of changing sizes through one object from several threads, and calls that fail. Each output must
// be that of a new object, and memory must not grow. AQORB_SOAK_FRAMES makes the run longer.
TEST(Aqorb_Soak, threads_share_an_object_that_does_not_grow)
{
    const char* const variable = std::getenv("AQORB_SOAK_FRAMES");
    const int ROUNDS = 20, WARM_UP = 4, THREADS = 4, IMAGES = 60,
              PER_THREAD = (variable ? std::max(std::atoi(variable), 200) : 2000) / ROUNDS / THREADS;
    Mat images[IMAGES], masks[IMAGES];
    Features expected[IMAGES];
    for (int i = 0; i < IMAGES; i++)
    {
        RNG rng(i + 1);
        const Size size(rng.uniform(20, 200), rng.uniform(20, 160));
        images[i] = i % 4 ? makeScene(size, i + 1) : makeNoise(size, i + 1);
        if (i % 3 == 0)
            masks[i] = makeScene(size, i + 2) > 100;
        if (i % 7 == 0)
            cvtColor(images[i], images[i], COLOR_GRAY2BGR);
        expected[i] = detectAndCompute(*AdaptiveQuadtreeORB::create(200), images[i], masks[i]);
    }
    const Ptr<AdaptiveQuadtreeORB> detector = AdaptiveQuadtreeORB::create(200);
    std::atomic<int> wrong(0);
    // The most in use between rounds. A round may need one more work space than ever.
    long long before = 0, after = 0;  // bytes
    for (int round = 0; round < ROUNDS; round++)
    {
        const auto work = [&](int thread)
        {
            RNG rng(1 + round * THREADS + thread);
            for (int i = 0; i < PER_THREAD; i++)
            {
                const int k = rng.uniform(0, IMAGES);
                wrong += !finds(*detector, images[k], masks[k], expected[k]);
                if (i % 10 == 0)
                    wrong += !fails(*detector, images[k], rng.uniform(0, 3));
            }
        };
        std::vector<std::thread> workers;
        for (int i = 0; i < THREADS; i++)
            workers.push_back(std::thread(work, i));
        for (std::thread& worker : workers)
            worker.join();
        long long& peak = round < WARM_UP ? before : after;
        peak = std::max(peak, heapInUse());
    }
    EXPECT_EQ(0, wrong);
    EXPECT_LE(after, before + 2000000);  // both 0 where the heap in use is not known
}

}  // namespace
}  // namespace opencv_test
