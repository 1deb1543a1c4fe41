// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "test_precomp.hpp"

#include <opencv2/core/hal/intrin.hpp>

#include <future>
#include <thread>

#if defined(__linux__)
#include <sys/resource.h>
#endif

namespace opencv_test
{
namespace
{

#define AQORB_NEEDS_HEAP()                                   \
    do                                                       \
    {                                                        \
        if (!isHeapKnown())                                  \
            AQORB_SKIP("the heap in use is not known here"); \
    } while (false)

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
    AQORB_NEEDS_HEAP();
    RNG rng(1);
    Mat query(10000, 32, CV_8UC1), train(10000, 32, CV_8UC1);
    rng.fill(query, RNG::UNIFORM, 0, 256);
    rng.fill(train, RNG::UNIFORM, 0, 256);
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

//! Those whose times are compared.
std::vector<Mat> referencePhotographs()
{
    std::vector<Mat> photographs;
    for (const std::string& name :
         {oxfordImage("bikes", 1), oxfordImage("leuven", 1), oxfordImage("bark", 1), oxfordImage("trees", 1),
          oxfordImage("ubc", 1), dataFile("perf/640x512.png"), dataFile("perf/1920x1080.png")})
    {
        photographs.push_back(imread(name, IMREAD_GRAYSCALE));
        EXPECT_FALSE(photographs.back().empty()) << name;
    }
    return photographs;
}

TEST(Aqorb_Memory, the_image_and_the_mask_are_not_kept)
{
    const Ptr<AdaptiveQuadtreeORB> detector = AdaptiveQuadtreeORB::create(100, 1.2f, 4, 8, 1);
    const Mat image = makeScene(Size(160, 120)), mask(image.size(), CV_8UC1, Scalar(1));
    Features features = detectAndCompute(*detector, image, mask);
    EXPECT_EQ(1, image.u->refcount);
    EXPECT_EQ(1, mask.u->refcount);
    detector->compute(image, features.keypoints, features.descriptors);
    EXPECT_EQ(1, image.u->refcount);
    const Mat noPixel(image.size(), CV_16UC1, Scalar(0));
    EXPECT_THROW(detector->detect(noPixel, features.keypoints), cv::Exception);
    EXPECT_THROW(detector->detect(image, features.keypoints, noPixel), cv::Exception);
    EXPECT_EQ(1, image.u->refcount);
    EXPECT_EQ(1, noPixel.u->refcount);
}

//! What a detector keeps between calls.
void expectSmallWorkSpace(const Mat& image)
{
    for (int count = 1; count <= 2; count++)
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
        const double most = (count == 1 ? 5 : 7.5) * (CV_SIMD ? 1 : 1.5);
        EXPECT_LE(double(heapInUse() - before), most * double(image.total()));
    }
}

TEST(Aqorb_Memory, work_space_of_scenes_is_small)
{
    AQORB_NEEDS_HEAP();
    for (const Size& size : {Size(1280, 720), Size(1920, 1080)})
        expectSmallWorkSpace(makeScene(size, 3));
}

TEST(Aqorb_Memory, work_space_of_photographs_is_small)
{
    AQORB_NEEDS_DATA();
    AQORB_NEEDS_HEAP();
    for (const Mat& photograph : referencePhotographs())
        expectSmallWorkSpace(photograph);
}

TEST(Aqorb_Memory, is_freed_on_request)
{
    AQORB_NEEDS_HEAP();
    const Threads oneThread(1);
    const Mat image = makeScene(Size(400, 300), 1);
    Features features = detectAndCompute(*AdaptiveQuadtreeORB::create(500), image);
    const Features expected = {features.keypoints, features.descriptors.clone()};
    const Ptr<AdaptiveQuadtreeORB> detector = AdaptiveQuadtreeORB::create(500);
    const long long before = heapInUse();
    detector->releaseMemory();  // there is none
    for (int i = 0; i < 10; i++)
    {
        detector->detectAndCompute(image, noArray(), features.keypoints, features.descriptors);
        EXPECT_TRUE(sameFeatures(expected, features));
        const long long kept = heapInUse() - before;
        EXPECT_GT(kept, 2 * 400 * 300);
        detector->releaseMemory();
        EXPECT_LE(heapInUse() - before, kept / 10);
    }
}

TEST(Aqorb_Memory, a_collection_needs_one_work_space_for_each_of_its_threads)
{
    AQORB_NEEDS_HEAP();
    // Large, so that what OpenCV keeps for its threads hardly counts.
    const std::vector<Mat> images(40, makeScene(Size(640, 480), 1));
    std::vector<KeyPoints> keypoints(40);
    const Ptr<AdaptiveQuadtreeORB> detector = AdaptiveQuadtreeORB::create(300);
    const auto detect = [&](int threads)
    {
        const Threads scope(threads);
        detector->releaseMemory();
        const long long before = heapInUse();
        detector->detect(images, keypoints);
        keypoints.clear();
        return heapInUse() - before;
    };
    detect(2);
    const long long ofOne = detect(1), ofTwo = detect(2);
    EXPECT_GT(ofOne, 2 * 640 * 480);
    EXPECT_LE(ofTwo, 2 * ofOne + ofOne / 10);
}

TEST(Aqorb_Memory, threads_of_one_call_each_do_not_leave_a_work_space_each)
{
    AQORB_NEEDS_HEAP();
    const Mat image = makeScene(Size(200, 150), 1);
    const int THREADS = 200;
    const Threads one(1);
    Features features = detectAndCompute(*AdaptiveQuadtreeORB::create(300), image);
    const long long before = heapInUse();
    const Ptr<AdaptiveQuadtreeORB> detector = AdaptiveQuadtreeORB::create(300);
    const auto detect = [&]
    { detector->detectAndCompute(image, noArray(), features.keypoints, features.descriptors); };
    detect();
    const long long ofOne = heapInUse() - before;
    std::promise<void> begin;  // all of them begin at once
    const std::shared_future<void> begun(begin.get_future());
    std::vector<std::thread> threads;
    for (int i = 0; i < THREADS; i++)
    {
        threads.push_back(std::thread(
            [&]
            {
                begun.wait();
                detectAndCompute(*detector, image);
            }));
    }
    begin.set_value();
    for (std::thread& thread : threads)
        thread.join();
    // As many work spaces are kept as there are CPUs.
    EXPECT_LE(heapInUse() - before, ofOne * std::max(getNumberOfCPUs(), 1) + ofOne / 2);
}

}  // namespace
}  // namespace opencv_test
