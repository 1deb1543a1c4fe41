// This file is part of the aqorb project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.

#include "test_precomp.hpp"

#include <thread>

namespace opencv_test
{
namespace
{

// Sets the number of OpenCV's threads back in the end.
class Threads
{
public:
    explicit Threads(int count) : before(getNumThreads()) { setNumThreads(count); }
    ~Threads() { setNumThreads(before); }

private:
    int before;
};

TEST(AQORB_Determinism, Threads_1_to_8_give_the_same_bytes)
{
    const Ptr<AdaptiveQuadtreeORB> detector = AdaptiveQuadtreeORB::create(700);
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

TEST(AQORB_Determinism, Concurrency_one_object_serves_many_threads)
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

TEST(AQORB_Determinism, repeats_give_the_same_bytes)
{
    // the second and later calls use the memory of the earlier ones
    const Ptr<AdaptiveQuadtreeORB> detector = AdaptiveQuadtreeORB::create(300);
    std::vector<Mat> images;
    images.push_back(makeScene(Size(300, 200), 1));
    images.push_back(makeScene(Size(300, 200), 2));
    images.push_back(makeNoise(Size(90, 333)));
    images.push_back(Mat(200, 300, CV_8UC1, Scalar(7)));
    images.push_back(makeScene(Size(64, 50), 3));
    for (int repeat = 0; repeat < 3; repeat++)
    {
        for (const Mat& image : images)
        {
            const Features fresh = detectAndCompute(*AdaptiveQuadtreeORB::create(300), image);
            EXPECT_TRUE(sameFeatures(fresh, detectAndCompute(*detector, image)));
        }
    }
}

TEST(AQORB_Determinism, every_CPU_path_gives_the_same_bytes)
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

TEST(AQORB_Determinism, a_region_equals_its_clone)
{
    const Mat whole = makeScene(Size(400, 300), 5);
    const Rect regions[] = {Rect(31, 17, 200, 180), Rect(0, 0, 150, 300), Rect(250, 100, 150, 200)};
    for (const Rect& region : regions)
    {
        for (int border = 0; border <= 16; border += 8)
        {
            const Ptr<AdaptiveQuadtreeORB> detector = AdaptiveQuadtreeORB::create(300, 1.2f, 8, border);
            EXPECT_TRUE(sameFeatures(detectAndCompute(*detector, whole(region).clone()),
                                     detectAndCompute(*detector, whole(region))));
        }
    }
}

TEST(AQORB_Determinism, what_lies_around_a_region_does_not_matter)
{
    // Image, mask and output are parts of larger matrices; what is around them changes, they do not.
    const Size size(200, 150);
    const Rect region(Point(29, 23), size);
    const Ptr<AdaptiveQuadtreeORB> detector = AdaptiveQuadtreeORB::create(200, 1.2f, 8, 3, 1);
    Mat image, mask = makeScene(size, 8) > 120;  // holes with many edges
    cvtColor(makeScene(size, 7), image, COLOR_GRAY2BGR);
    const Features expected = detectAndCompute(*detector, image, mask);
    ASSERT_EQ(200u, expected.keypoints.size());
    for (int around = 0; around <= 255; around += 51)
    {
        SCOPED_TRACE(around);
        Mat wholeImage(260, 310, CV_8UC3, Scalar::all(around)), wholeMask(260, 310, CV_8UC1, Scalar(around));
        image.copyTo(wholeImage(region));
        mask.copyTo(wholeMask(region));
        EXPECT_FALSE(wholeImage(region).isContinuous());
        EXPECT_TRUE(
            sameFeatures(expected, detectAndCompute(*detector, wholeImage(region), wholeMask(region))));
        Features computed = {expected.keypoints, Mat()};
        detector->compute(wholeImage(region), computed.keypoints, computed.descriptors);
        EXPECT_TRUE(sameFeatures(expected, computed));
    }
}

TEST(AQORB_Determinism, UMat_equals_Mat)
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

    // UMat's own memory, colour, a region; into compute, too
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

TEST(AQORB_Determinism, colour_equals_its_grey_image)
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
