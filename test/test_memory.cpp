// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "test_precomp.hpp"

#include "allocations.hpp"
#include "pool.hpp"

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

// The other tests expect no allocation, and would hold as well if none was counted.
TEST(Aqorb_Memory, allocations_are_counted_and_fail_on_request)
{
    const AllocationCounter allocations(3);
    const Mat matrix(10, 10, CV_8UC1);
    EXPECT_EQ(1, allocations.ofMatrices());
    EXPECT_EQ(0, allocations.ofNew());
    ::operator delete(::operator new(10));
    EXPECT_EQ(1, allocations.ofNew());
    EXPECT_THROW(Mat(10, 10, CV_8UC1), cv::Exception);
    EXPECT_NO_THROW(Mat(10, 10, CV_8UC1));
}

TEST(Aqorb_Memory, bytes_are_counted)
{
    AQORB_NEEDS_BYTES();
    const int MOST = 1000;  // of what the C library adds
    // No vectors, because clang leaves out the memory of those that nobody uses.
    void* const first = ::operator new(10000);
    Mat before(100, 100, CV_8UC1);
    AllocationCounter allocations;
    {
        void* const second = ::operator new(50000);
        const Mat matrix(100, 1000, CV_8UC1);
        EXPECT_NEAR(double(allocations.bytes()), 150000, MOST);
        ::operator delete(second);
    }
    EXPECT_EQ(allocations.bytes(), 0);
    EXPECT_NEAR(double(allocations.peakBytes()), 150000, MOST);
    allocations.beginPeak();
    EXPECT_EQ(allocations.peakBytes(), 0);
    ::operator delete(first);
    EXPECT_NEAR(double(allocations.bytes()), -10000, MOST);
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

//! Otherwise cv::resize makes the pyramid, and it allocates.
bool pyramidHasKernel()
{
    const bool is64Bit = sizeof(void*) == 8;  // 32-bit x86 has the baseline only
    return CV_NEON || (is64Bit && checkHardwareSupport(CPU_SSE4_1));
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

//! Calls a function until the buffers have grown to their final sizes, and expects no allocation of later calls.
template <typename Call> void expectNothingAllocatedAnew(int before, const Call& call)
{
    const Threads oneThread(1);
    for (int i = 0; i < before; i++)
        call();
    const AllocationCounter allocations;
    for (int i = 0; i < 3; i++)
        call();
    if (pyramidHasKernel())
    {
        EXPECT_EQ(0, allocations.ofNew());
    }
    EXPECT_EQ(0, allocations.ofMatrices());
}

void expectNothingAllocatedAnew(const Mat& image, int nfeatures)
{
    for (const auto type : {AdaptiveQuadtreeORB::RANKED_SELECTION, AdaptiveQuadtreeORB::BALANCED_SELECTION})
    {
        SCOPED_TRACE(format("%d x %d, n = %d, type %d", image.cols, image.rows, nfeatures, type));
        const Ptr<AdaptiveQuadtreeORB> detector = AdaptiveQuadtreeORB::create(nfeatures);
        detector->setSelectionType(type);
        Features features;
        expectNothingAllocatedAnew(
            1,
            [&]
            {
                detector->detectAndCompute(image, noArray(), features.keypoints, features.descriptors);
                detector->detectAndCompute(image, noArray(), features.keypoints, features.descriptors, true);
            });
    }
}

// From few features to more than there are corners. In between, corners are chosen that represent no leaf.
TEST(Aqorb_Memory, any_number_of_features_allocates_nothing_anew)
{
    const Mat scene = makeScene(Size(320, 240), 3);
    for (int nfeatures = 125; nfeatures <= 8000; nfeatures *= 2)
        expectNothingAllocatedAnew(scene, nfeatures);
}

TEST(Aqorb_Memory, photographs_allocate_nothing_anew)
{
    AQORB_NEEDS_DATA();
    for (const Mat& photograph : referencePhotographs())
        for (int nfeatures : {500, 1000, 2000})
            expectNothingAllocatedAnew(photograph, nfeatures);
}

// What a call needs once both kinds of frames have been seen does not depend on which came before.
TEST(Aqorb_Memory, alternating_frames_allocate_nothing_anew)
{
    struct Frame
    {
        Mat image, mask;
        Features features;
    };
    std::vector<Frame> frames(6);
    const Size sizes[] = {Size(320, 240), Size(200, 310), Size(640, 200), Size(64, 64)};
    for (int i = 0; i < 6; i++)
        frames[i].image = makeScene(sizes[i % 4], i + 1);
    frames[1].mask = makeNoise(sizes[1], 1) > 9;
    frames[2].mask = makeNoise(sizes[2], 2) > 9;
    cvtColor(frames[2].image, frames[2].image, COLOR_GRAY2BGR);
    cvtColor(frames[4].image, frames[4].image, COLOR_GRAY2BGRA);
    for (const auto type : {AdaptiveQuadtreeORB::RANKED_SELECTION, AdaptiveQuadtreeORB::BALANCED_SELECTION})
    {
        const Ptr<AdaptiveQuadtreeORB> detector = AdaptiveQuadtreeORB::create(300);
        detector->setSelectionType(type);
        const auto detectAll = [&]
        {
            for (Frame& frame : frames)
                detector->detectAndCompute(frame.image, frame.mask, frame.features.keypoints,
                                           frame.features.descriptors);
        };
        expectNothingAllocatedAnew(10, detectAll);
    }
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

const int KEPT_CALLS = 64;  // as the documentation of releaseMemory says

// One large frame, and then small ones only.
TEST(Aqorb_Memory, of_a_large_frame_is_freed_after_many_small_ones)
{
    AQORB_NEEDS_BYTES();
    const Threads oneThread(1);
    const Mat large = makeScene(Size(900, 700), 1), half = makeScene(Size(700, 450), 2),
              small = makeScene(Size(160, 120), 3);
    Features features;
    const auto detect = [&](AdaptiveQuadtreeORB& detector, const Mat& image)
    { detector.detectAndCompute(image, noArray(), features.keypoints, features.descriptors); };
    detect(*AdaptiveQuadtreeORB::create(500), large);  // for the outputs
    const Features expected = detectAndCompute(*AdaptiveQuadtreeORB::create(500), small);
    detect(*AdaptiveQuadtreeORB::create(500), small);

    AllocationCounter allocations;
    const Ptr<AdaptiveQuadtreeORB> detector = AdaptiveQuadtreeORB::create(500);
    for (int i = 0; i < 5; i++)
        detect(*detector, small);
    const long long ofSmall = allocations.bytes();
    for (int round = 0; round < 2; round++)
    {
        detect(*detector, large);
        const long long ofLarge = allocations.bytes();
        EXPECT_GT(ofLarge, 5 * ofSmall);
        for (int i = 1; i < KEPT_CALLS; i++)
            detect(*detector, small);
        EXPECT_NEAR(double(allocations.bytes()), double(ofLarge), double(ofSmall)) << "it is of use";
        // A frame of half the size needs much of it, so that the count begins anew.
        detect(*detector, half);
        for (int i = 1; i < KEPT_CALLS; i++)
            detect(*detector, small);
        EXPECT_NEAR(double(allocations.bytes()), double(ofLarge), double(ofSmall)) << "it is of use";
        for (int i = 0; i < 2; i++)
            detect(*detector, small);
        EXPECT_LE(allocations.bytes(), ofSmall + ofSmall / 4);
        EXPECT_TRUE(sameFeatures(expected, features));
    }
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

//! Something that counts how many of it there are.
struct Counted
{
    Counted() { alive()++; }
    ~Counted() { alive()--; }
    static int& alive()
    {
        static int count = 0;
        return count;
    }
};

// As many as there are CPUs can be in use at the same time again.
TEST(Aqorb_Memory, of_many_threads_at_once_is_not_kept)
{
    typedef aqorb::Pool<Counted> Pool;
    const int CPUS = std::max(getNumberOfCPUs(), 1);
    {
        Pool pool;
        for (int round = 0; round < 3; round++)
        {
            {
                std::vector<std::unique_ptr<Pool::Lease>> leases;
                for (int i = 0; i < 200; i++)
                    leases.emplace_back(new Pool::Lease(pool, 100));
                EXPECT_EQ(Counted::alive(), 200);
            }
            EXPECT_EQ(Counted::alive(), CPUS);
            for (int i = 0; i < KEPT_CALLS + CPUS; i++)
                Pool::Lease(pool, 100);
            EXPECT_EQ(Counted::alive(), 1) << "one is enough for one thread";
        }
        pool.clear();
        EXPECT_EQ(Counted::alive(), 0);
        {
            const Pool::Lease first(pool, 100), second(pool, 100);
            pool.clear();  // It does not take away what is lent.
            EXPECT_EQ(Counted::alive(), 2);
        }
        EXPECT_EQ(Counted::alive(), std::min(CPUS, 2));
    }
    EXPECT_EQ(Counted::alive(), 0);
}

TEST(Aqorb_Memory, a_pool_that_is_cleared_again_and_again_does_not_grow)
{
    AQORB_NEEDS_BYTES();
    const AllocationCounter allocations;
    aqorb::Pool<Counted> pool;
    for (int i = 0; i < 20000; i++)
    {
        const aqorb::Pool<Counted>::Lease lease(pool, 100);
        pool.clear();
    }
    EXPECT_LE(allocations.bytes(), 10000);
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
    for (int i = 0; i < KEPT_CALLS + getNumberOfCPUs(); i++)
        detect();
    EXPECT_LE(allocations.bytes(), ofOne + ofOne / 2);
}

}  // namespace
}  // namespace opencv_test
