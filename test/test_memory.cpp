// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "test_precomp.hpp"

#include "allocations.hpp"
#include "types.hpp"

#include <opencv2/core/hal/intrin.hpp>

#include <condition_variable>
#include <memory>
#include <mutex>
#include <thread>

namespace opencv_test
{
namespace
{

#define AQORB_NEEDS_BYTES()                                                \
    do                                                                     \
    {                                                                      \
        if (!AllocationCounter::countsBytes())                             \
            AQORB_SKIP("the size of a block of memory is not known here"); \
    } while (false)

// The other tests would hold as well if no allocation was counted or failed.
TEST(Aqorb_Memory, allocations_are_counted_and_fail_on_request)
{
    const AllocationCounter allocations(3);
    const Mat matrix(10, 10, CV_8UC1);
    EXPECT_EQ(1, allocations.ofMatrices());
    ::operator delete(::operator new(10));
    EXPECT_THROW(Mat(10, 10, CV_8UC1), cv::Exception);
    EXPECT_NO_THROW(Mat(10, 10, CV_8UC1));
}

// cv::BFMatcher needs 400 MB for the distances alone.
TEST(Aqorb_Memory, matching_needs_no_matrix_of_distances)
{
    AQORB_NEEDS_BYTES();
    const long long MOST = 50000000;
    RNG rng(1);
    Mat query(10000, 32, CV_8UC1), train(10000, 32, CV_8UC1);
    rng.fill(query, RNG::UNIFORM, 0, 256);
    rng.fill(train, RNG::UNIFORM, 0, 256);
    std::vector<DMatch> matches;
    std::vector<std::vector<DMatch>> lists;
    const std::function<void()> works[] = {
        [&] { aqorb::HammingMatcher(NORM_HAMMING, true).match(query, train, matches); },
        [&] { aqorb::HammingMatcher().knnMatch(query, train, lists, 2); },
        [&] { aqorb::HammingMatcher().knnMatch(query, train, lists, 5); },
        [&] { aqorb::HammingMatcher().radiusMatch(query, train, lists, 80); },
    };
    for (const std::function<void()>& work : works)
    {
        const AllocationCounter allocations;
        work();
        EXPECT_GT(allocations.bytes(), 0);
        EXPECT_LT(allocations.peakBytes() - allocations.bytes(), MOST);
        matches = std::vector<DMatch>();
        lists = std::vector<std::vector<DMatch>>();
    }
}

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

TEST(Aqorb_Memory, packed_octaves_fail_before_any_level_is_allocated)
{
    const Mat image = makeScene(Size(200, 150));
    const Ptr<AdaptiveQuadtreeORB> detector = AdaptiveQuadtreeORB::create();
    const int octaves[] = {-1, 255, 1 << 8 | 1, 0x01000200 + 255, INT_MAX, INT_MIN};
    for (int octave : octaves)
    {
        KeyPoints keypoints(3, KeyPoint(Point2f(100, 70), 31.f));
        keypoints[1].octave = octave;
        Mat descriptors;
        const AllocationCounter allocations;
        EXPECT_THROW(detector->compute(image, keypoints, descriptors), cv::Exception) << octave;
        EXPECT_EQ(0, allocations.ofMatrices()) << octave;
    }
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

//! What a detector allocates beside its outputs, in bytes for each of the image.
struct WorkSpace
{
    double first, later;  //!< at most, during its first call and during later ones
    double kept;          //!< between calls
};

WorkSpace workSpaceOf(const Mat& image, int threads_, int nfeatures = 1000)
{
    const Threads threads(threads_);
    // Outputs that need not grow. And OpenCV, which allocates memory for threads, does it now.
    Features features = detectAndCompute(*AdaptiveQuadtreeORB::create(nfeatures), image);
    AllocationCounter allocations;
    const Ptr<AdaptiveQuadtreeORB> detector = AdaptiveQuadtreeORB::create(nfeatures);
    const auto detect = [&]
    { detector->detectAndCompute(image, noArray(), features.keypoints, features.descriptors); };
    WorkSpace workSpace;
    detect();
    const double bytes = double(image.total());
    workSpace.first = allocations.peakBytes() / bytes;
    allocations.beginPeak();
    for (int i = 0; i < 10; i++)  // which threads take which part is chance
        detect();
    workSpace.later = allocations.peakBytes() / bytes;
    workSpace.kept = allocations.bytes() / bytes;
    return workSpace;
}

void expectSmallWorkSpace(const Mat& image)
{
    for (int threads = 1; threads <= 2; threads++)
    {
        SCOPED_TRACE(format("%d x %d, %d threads", image.cols, image.rows, threads));
        // Without vectors there is a block of the scan for each pixel, and their lists are longer.
        const double MOST = (threads == 1 ? 5 : 7.5) * (CV_SIMD ? 1 : 1.5);
        const WorkSpace workSpace = workSpaceOf(image, threads);
        EXPECT_LE(workSpace.first, MOST);
        EXPECT_LE(workSpace.later, MOST);
        EXPECT_LE(workSpace.kept, MOST);
    }
}

TEST(Aqorb_Memory, work_space_of_scenes_is_small)
{
    AQORB_NEEDS_BYTES();
    for (const Size& size : {Size(1280, 720), Size(1920, 1080)})
        expectSmallWorkSpace(makeScene(size, 3));
}

TEST(Aqorb_Memory, work_space_of_photographs_is_small)
{
    AQORB_NEEDS_DATA();
    AQORB_NEEDS_BYTES();
    for (const Mat& photograph : referencePhotographs())
        expectSmallWorkSpace(photograph);
}

TEST(Aqorb_Memory, is_freed_on_request)
{
    AQORB_NEEDS_BYTES();
    const Threads oneThread(1);
    const Mat image = makeScene(Size(400, 300), 1);
    Features features = detectAndCompute(*AdaptiveQuadtreeORB::create(500), image);
    const Features expected = {features.keypoints, features.descriptors.clone()};
    AllocationCounter allocations;
    const Ptr<AdaptiveQuadtreeORB> detector = AdaptiveQuadtreeORB::create(500);
    const long long before = allocations.bytes();
    detector->releaseMemory();  // there is none
    long long kept = 0;
    for (int i = 0; i < 1000; i++)
    {
        if (i < 3 || i == 999)
        {
            detector->detectAndCompute(image, noArray(), features.keypoints, features.descriptors);
            EXPECT_TRUE(sameFeatures(expected, features));
            kept = allocations.bytes() - before;
            EXPECT_GT(kept, 2 * 400 * 300);
        }
        else
        {
            detector->detect(image.rowRange(0, 40), features.keypoints);
        }
        detector->releaseMemory();
        EXPECT_LE(allocations.bytes() - before, kept / 100);
    }
}

TEST(Aqorb_Memory, a_collection_needs_one_work_space_for_each_of_its_threads)
{
    AQORB_NEEDS_BYTES();
    const std::vector<Mat> images(40, makeScene(Size(200, 150), 1));
    std::vector<KeyPoints> keypoints(40);
    const Ptr<AdaptiveQuadtreeORB> detector = AdaptiveQuadtreeORB::create(300);
    const AllocationCounter allocations;
    const auto detect = [&](int threads)
    {
        const Threads scope(threads);
        detector->releaseMemory();
        const long long before = allocations.bytes();
        detector->detect(images, keypoints);
        keypoints.clear();
        return allocations.bytes() - before;
    };
    detect(2);
    const long long ofOne = detect(1), ofTwo = detect(2);
    EXPECT_GT(ofOne, 2 * 200 * 150);
    EXPECT_LE(ofTwo, 2 * ofOne + ofOne / 10);
}

TEST(Aqorb_Memory, threads_of_one_call_each_do_not_leave_a_work_space_each)
{
    AQORB_NEEDS_BYTES();
    const Mat image = makeScene(Size(200, 150), 1);
    const int THREADS = 200;
    const Threads one(1);
    Features features = detectAndCompute(*AdaptiveQuadtreeORB::create(300), image);
    AllocationCounter allocations;
    const Ptr<AdaptiveQuadtreeORB> detector = AdaptiveQuadtreeORB::create(300);
    const auto detect = [&]
    { detector->detectAndCompute(image, noArray(), features.keypoints, features.descriptors); };
    detect();
    const long long ofOne = allocations.bytes();
    {
        // All of them begin at once.
        std::mutex mutex;
        std::condition_variable begun;
        bool hasBegun = false;
        std::vector<std::thread> threads;
        for (int i = 0; i < THREADS; i++)
        {
            threads.push_back(std::thread(
                [&]
                {
                    {
                        std::unique_lock<std::mutex> lock(mutex);
                        begun.wait(lock, [&] { return hasBegun; });
                    }
                    detectAndCompute(*detector, image);
                }));
        }
        {
            const std::lock_guard<std::mutex> lock(mutex);
            hasBegun = true;
        }
        begun.notify_all();
        for (std::thread& thread : threads)
            thread.join();
    }
    // As many work spaces are kept as there are CPUs.
    EXPECT_LE(allocations.bytes(), ofOne * std::max(getNumberOfCPUs(), 1) + ofOne / 2);
}

}  // namespace
}  // namespace opencv_test
