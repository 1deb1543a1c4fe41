// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "test_precomp.hpp"

#include <array>
#include <fstream>
#include <limits>

#if defined(__linux__)
#include <sys/resource.h>
#include <unistd.h>
#endif

namespace opencv_test
{
namespace
{

::testing::AssertionResult names(const std::string& message, const std::string& name,
                                 const std::string& value)
{
    // As in "nfeatures must be at least 0, got -1".
    const size_t must = message.find(" must "), got = message.find(", got ");
    if (must != std::string::npos && got != std::string::npos && message.find(name) < got &&
        message.find(value, got) != std::string::npos)
        return ::testing::AssertionSuccess();
    return ::testing::AssertionFailure()
           << "'" << message << "' does not say what " << name << " must be, and that it is " << value;
}

const float NOT_A_NUMBER = std::numeric_limits<float>::quiet_NaN();
const float ENDLESS = std::numeric_limits<float>::infinity();

TEST(Aqorb_Errors, are_said_as_a_person_would)
{
    EXPECT_EQ("nfeatures must be at least 0, got -1", messageOf([] { AdaptiveQuadtreeORB::create(-1); }));
    const Ptr<AdaptiveQuadtreeORB> detector = AdaptiveQuadtreeORB::create();
    EXPECT_EQ("nlevels must be from 1 to 65536, got 0", messageOf([&] { detector->setNLevels(0); }));
    EXPECT_EQ("scaleFactor must be finite and above 0, got inf",
              messageOf([&] { detector->setScaleFactor(ENDLESS); }));
    EXPECT_EQ("scoreType must be HARRIS_SCORE (0) or FAST_SCORE (1), got 2",
              messageOf([&] { detector->setScoreType(static_cast<ORB::ScoreType>(2)); }));
    EXPECT_EQ("octaveSuppression must be finite and at least 0, or -1, got -0.5",
              messageOf([&] { detector->setOctaveSuppression(-0.5); }));
}

TEST(Aqorb_Errors, bad_parameters_of_create)
{
#define AQORB_BAD(name, value, call) \
    EXPECT_TRUE(names(messageOf([] { AdaptiveQuadtreeORB::call; }), name, value))
    AQORB_BAD("nfeatures", "-1", create(-1));
    AQORB_BAD("scaleFactor", "0", create(500, 0.f));
    AQORB_BAD("scaleFactor", "nan", create(500, NOT_A_NUMBER));
    AQORB_BAD("nlevels", "2147483647", create(500, 1.2f, INT_MAX));
    AQORB_BAD("edgeThreshold", "-3", create(500, 1.2f, 8, -3));
    AQORB_BAD("firstLevel", "-1", create(500, 1.2f, 8, 16, -1));
    AQORB_BAD("WTA_K", "5", create(500, 1.2f, 8, 16, 0, 5));
    AQORB_BAD("scoreType", "7", create(500, 1.2f, 8, 16, 0, 2, static_cast<ORB::ScoreType>(7)));
    AQORB_BAD("patchSize", "2147483647", create(500, 1.2f, 8, 16, 0, 2, ORB::HARRIS_SCORE, INT_MAX));
#undef AQORB_BAD
}

TEST(Aqorb_Errors, bad_values_of_setters_leave_the_object_unchanged)
{
    const Ptr<AdaptiveQuadtreeORB> detector = AdaptiveQuadtreeORB::create();
    const Mat image = makeScene(Size(200, 150));
    const Features before = detectAndCompute(*detector, image);
#define AQORB_BAD(name, value, call) EXPECT_TRUE(names(messageOf([&] { detector->call; }), name, value))
    AQORB_BAD("nfeatures", "-1", setMaxFeatures(-1));
    AQORB_BAD("scaleFactor", "-1.5", setScaleFactor(-1.5));
    AQORB_BAD("scaleFactor", "0", setScaleFactor(0));
    AQORB_BAD("scaleFactor", "nan", setScaleFactor(NOT_A_NUMBER));
    AQORB_BAD("scaleFactor", "inf", setScaleFactor(ENDLESS));
    AQORB_BAD("nlevels", "-8", setNLevels(-8));
    AQORB_BAD("nlevels", "65537", setNLevels(65537));
    AQORB_BAD("edgeThreshold", "-1", setEdgeThreshold(-1));
    AQORB_BAD("firstLevel", "-1", setFirstLevel(-1));
    AQORB_BAD("WTA_K", "0", setWTA_K(0));
    AQORB_BAD("WTA_K", "5", setWTA_K(5));
    AQORB_BAD("scoreType", "2", setScoreType(static_cast<ORB::ScoreType>(2)));
    AQORB_BAD("scoreType", "-1", setScoreType(static_cast<ORB::ScoreType>(-1)));
    AQORB_BAD("patchSize", "0", setPatchSize(0));
    AQORB_BAD("patchSize", "16385", setPatchSize(16385));
    AQORB_BAD("minThresholdRatio", "0.5", setMinThresholdRatio(0.5));
    AQORB_BAD("minThresholdRatio", "nan", setMinThresholdRatio(NOT_A_NUMBER));
    AQORB_BAD("selectionType", "2", setSelectionType(static_cast<AdaptiveQuadtreeORB::SelectionType>(2)));
    AQORB_BAD("selectionType", "-1", setSelectionType(static_cast<AdaptiveQuadtreeORB::SelectionType>(-1)));
    AQORB_BAD("strengthWeight", "-0.125", setStrengthWeight(-0.125));
    AQORB_BAD("strengthWeight", "1000.5", setStrengthWeight(1000.5));
    AQORB_BAD("strengthWeight", "inf", setStrengthWeight(ENDLESS));
    AQORB_BAD("strengthWeight", "nan", setStrengthWeight(NOT_A_NUMBER));
    AQORB_BAD("rankRadius", "-0.125", setRankRadius(-0.125));
    AQORB_BAD("rankRadius", "16.5", setRankRadius(16.5));
    AQORB_BAD("rankRadius", "inf", setRankRadius(ENDLESS));
    AQORB_BAD("rankRadius", "nan", setRankRadius(NOT_A_NUMBER));
    AQORB_BAD("octaveSuppression", "-0.5", setOctaveSuppression(-0.5));
    AQORB_BAD("octaveSuppression", "-2", setOctaveSuppression(-2));
    AQORB_BAD("octaveSuppression", "inf", setOctaveSuppression(ENDLESS));
    AQORB_BAD("octaveSuppression", "nan", setOctaveSuppression(NOT_A_NUMBER));
#undef AQORB_BAD
    EXPECT_TRUE(sameFeatures(before, detectAndCompute(*detector, image)));
}

TEST(Aqorb_Errors, the_ends_of_what_is_accepted_are_accepted)
{
    const Ptr<AdaptiveQuadtreeORB> detector = AdaptiveQuadtreeORB::create();
    EXPECT_NO_THROW(detector->setMaxFeatures(0));
    EXPECT_NO_THROW(detector->setMaxFeatures(INT_MAX));
    EXPECT_NO_THROW(detector->setNLevels(1));
    EXPECT_NO_THROW(detector->setNLevels(65536));
    EXPECT_NO_THROW(detector->setEdgeThreshold(0));
    EXPECT_NO_THROW(detector->setEdgeThreshold(INT_MAX));
    EXPECT_NO_THROW(detector->setPatchSize(2));
    EXPECT_NO_THROW(detector->setPatchSize(16384));
    EXPECT_NO_THROW(detector->setFastThreshold(INT_MIN));
    EXPECT_NO_THROW(detector->setFastThreshold(INT_MAX));
    EXPECT_NO_THROW(detector->setMinThresholdRatio(1));
    EXPECT_NO_THROW(detector->setSelectionType(AdaptiveQuadtreeORB::RANKED_SELECTION));
    EXPECT_NO_THROW(detector->setSelectionType(AdaptiveQuadtreeORB::QUADTREE_SELECTION));
    EXPECT_NO_THROW(detector->setStrengthWeight(0));
    EXPECT_NO_THROW(detector->setStrengthWeight(1000));
    EXPECT_NO_THROW(detector->setRankRadius(0));
    EXPECT_NO_THROW(detector->setRankRadius(16));
    EXPECT_NO_THROW(detector->setOctaveSuppression(-1));
    EXPECT_NO_THROW(detector->setOctaveSuppression(0));
}

TEST(Aqorb_Errors, parameters_that_do_not_go_together)
{
    const Mat image = makeScene(Size(200, 150));
    KeyPoints keypoints;
    EXPECT_EQ("scaleFactor must be above 1 with more than one level, got 0.5",
              messageOf([] { AdaptiveQuadtreeORB::create(500, 0.5f); }));
    EXPECT_EQ("firstLevel must be below nlevels, which is 4, got 4",
              messageOf([] { AdaptiveQuadtreeORB::create(500, 1.2f, 4, 16, 4); }));
    Ptr<AdaptiveQuadtreeORB> detector = AdaptiveQuadtreeORB::create(500, 1.f, 1);
    detector->setNLevels(2);
    EXPECT_TRUE(names(messageOf([&] { detector->detect(image, keypoints); }), "scaleFactor", "1"));
    detector = AdaptiveQuadtreeORB::create(500, 1.2f, 4);
    detector->setFirstLevel(4);
    EXPECT_TRUE(names(messageOf([&] { detector->detect(image, keypoints); }), "firstLevel", "4"));
    detector->setNLevels(5);  // The order of the setters does not matter.
    EXPECT_NO_THROW(detector->detect(image, keypoints));
    detector = AdaptiveQuadtreeORB::create(500, 3.f, 60, 16, 50);
    EXPECT_TRUE(names(messageOf([&] { detector->detect(image, keypoints); }), "firstLevel", "200 x 150"));
}

// The first one's finest level has more pixels than an int can count.
TEST(Aqorb_Errors, levels_that_need_too_much_memory)
{
    struct
    {
        Size size;
        double scaleFactor;
        int nlevels, firstLevel;
    } const cases[] = {{Size(257, 256), 2, 9, 8}, {Size(64, 64), 16, 7, 3}, {Size(100, 1), 8, 7, 4}};
    for (const auto& c : cases)
    {
        SCOPED_TRACE(c.scaleFactor);
        const Mat image = makeScene(c.size), mask(c.size, CV_8UC1, Scalar(1));
        const auto detector = AdaptiveQuadtreeORB::create(500, 1.2f, c.nlevels, 0, c.firstLevel);
        detector->setScaleFactor(c.scaleFactor);
        KeyPoints keypoints(1, KeyPoint(Point2f(20, 0), 31.f));
        std::vector<Mat> levels;
        Mat descriptors;
        const std::function<void()> calls[] = {
            [&] { detector->detect(image, keypoints); },
            [&] { detector->detect(image, keypoints, mask); },
            [&] { detector->compute(image, keypoints, descriptors); },
            [&] { detector->buildPyramid(image, levels); },
        };
        for (const auto& call : calls)
        {
            const std::string message = messageOf(call);
            EXPECT_TRUE(names(message, "scaleFactor and firstLevel", "pixels")) << message;
        }
    }
}

#if defined(__linux__)
TEST(Aqorb_Errors, levels_for_which_memory_runs_out)
{
    if (!isHeapKnown())
        AQORB_SKIP("a sanitizer needs more memory than this test leaves");
    const Threads oneThread(1);  // OpenCV's own wait for ever if memory runs out while a loop begins
    const Mat image = makeScene(Size(200, 150));
    Mat mask(image.size(), CV_8UC1, Scalar(1));
    mask.at<uchar>(0, 0) = 0;  // a mask without a zero takes no memory
    const auto detector = AdaptiveQuadtreeORB::create(500, 64, 2, 16, 1);  // a level of 120 MB
    rlimit before;
    getrlimit(RLIMIT_AS, &before);
    for (int megabytes : {60, 180})  // for the pixels or for the mask of the level there are too few
    {
        long pages = 0;
        std::ifstream("/proc/self/statm") >> pages;
        rlimit few = before;
        few.rlim_cur = rlim_t(pages) * rlim_t(sysconf(_SC_PAGESIZE)) + rlim_t(megabytes) * 1000000;
        KeyPoints keypoints;
        setrlimit(RLIMIT_AS, &few);
        getrlimit(RLIMIT_AS, &few);
        if (few.rlim_cur == before.rlim_cur)
            AQORB_SKIP("this emulator does not limit memory");
        const std::string message = messageOf([&] { detector->detect(image, keypoints, mask); });
        setrlimit(RLIMIT_AS, &before);
        EXPECT_TRUE(names(message, "scaleFactor and firstLevel", "pixels")) << megabytes << message;
    }
}
#endif

TEST(Aqorb_Errors, bad_images_and_masks)
{
    const Ptr<AdaptiveQuadtreeORB> detector = AdaptiveQuadtreeORB::create();
    // OpenCV's issue 21539 is about 16-bit images.
    const int types[] = {CV_16UC1, CV_16SC1, CV_16UC3, CV_32FC1, CV_32FC3,
                         CV_64FC1, CV_64FC3, CV_8SC1,  CV_8UC2,  CV_8UC(5)};
    KeyPoints keypoints(3);
    for (int type : types)
    {
        const Mat image(100, 100, type);
        EXPECT_TRUE(
            names(messageOf([&] { detector->detect(image, keypoints); }), "image", typeToString(type)));
        EXPECT_TRUE(
            names(messageOf([&] { aqorb::adaptiveFastThreshold(image); }), "image", typeToString(type)));
    }
    const Mat image = makeScene(Size(100, 80));
    const Mat masks[] = {Mat(80, 99, CV_8UC1, Scalar(1)), Mat(100, 80, CV_8UC1, Scalar(1)),
                         Mat(80, 100, CV_8UC3, Scalar::all(1)), Mat(80, 100, CV_32FC1, Scalar(1))};
    for (const Mat& mask : masks)
    {
        const std::string size = format("%d x %d", mask.cols, mask.rows);
        EXPECT_TRUE(names(messageOf([&] { detector->detect(image, keypoints, mask); }), "mask", size));
        EXPECT_TRUE(names(messageOf([&] { aqorb::adaptiveFastThreshold(image, mask); }), "mask", size));
    }
    EXPECT_EQ(3u, keypoints.size());  // A call that fails leaves its outputs unchanged.
}

TEST(Aqorb_Errors, sequences_of_images_and_masks)
{
    const Ptr<AdaptiveQuadtreeORB> detector = AdaptiveQuadtreeORB::create();
    const Mat image = makeScene(Size(100, 80));
    const std::vector<Mat> images(3, image);
    const std::vector<UMat> uimages(3, image.getUMat(ACCESS_READ));
    const std::vector<std::vector<uchar>> rows(3, std::vector<uchar>(100));
    KeyPoints keypoints(3);
    Mat descriptors = Mat::ones(3, 32, CV_8UC1);
    std::vector<Mat> levels;
    const _InputArray sequences[] = {images, uimages, rows};
    for (const _InputArray& s : sequences)
    {
        EXPECT_TRUE(
            names(messageOf([&] { detector->detectAndCompute(s, noArray(), keypoints, descriptors); }),
                  "image", "3"));
        EXPECT_TRUE(names(messageOf([&] { detector->buildPyramid(s, levels); }), "image", "3"));
        EXPECT_TRUE(names(messageOf([&] { aqorb::adaptiveFastThreshold(s); }), "image", "3"));
        EXPECT_TRUE(names(messageOf([&] { detector->detectAndCompute(image, s, keypoints, descriptors); }),
                          "mask", "3"));
        EXPECT_TRUE(names(messageOf([&] { aqorb::adaptiveFastThreshold(image, s); }), "mask", "3"));
    }
    EXPECT_EQ(3u, keypoints.size());
    EXPECT_EQ(3, descriptors.rows);
}

TEST(Aqorb_Errors, images_too_large_for_a_pyramid)
{
    const int side = 1 << 20;
    const Size sizes[] = {Size(side, 2), Size(2, side), Size(side + 9, 1)};
    for (const Size& size : sizes)
    {
        const Mat image(size, CV_8UC1, Scalar(9));
        const std::string text = format("%d x %d", size.width, size.height);
        for (int firstLevel = 0; firstLevel <= 1; firstLevel++)
        {
            const Ptr<AdaptiveQuadtreeORB> detector =
                AdaptiveQuadtreeORB::create(500, 1.2f, 8, 0, firstLevel);
            KeyPoints keypoints(1, KeyPoint(Point2f(0, 0), 31, 0, 0, 2));
            Mat descriptors;
            std::vector<Mat> levels;
            EXPECT_TRUE(names(messageOf([&] { detector->detect(image, keypoints); }), "image", text));
            EXPECT_TRUE(
                names(messageOf([&] { detector->compute(image, keypoints, descriptors); }), "image", text));
            EXPECT_TRUE(names(messageOf([&] { detector->buildPyramid(image, levels); }), "image", text));
            EXPECT_EQ(1u, keypoints.size());
        }
    }
    // The largest image is accepted, but not with a level before it.
    const Mat largest(2, side - 1, CV_8UC1, Scalar(9));
    KeyPoints keypoints;
    EXPECT_NO_THROW(AdaptiveQuadtreeORB::create(500, 1.2f, 8)->detect(largest, keypoints));
    EXPECT_TRUE(names(
        messageOf([&] { AdaptiveQuadtreeORB::create(500, 1.2f, 8, 16, 1)->detect(largest, keypoints); }),
        "firstLevel", "1048575 x 2"));
}

TEST(Aqorb_Errors, outputs_that_do_not_fit_lose_nothing)
{
    const Ptr<AdaptiveQuadtreeORB> detector = AdaptiveQuadtreeORB::create(20);
    const Mat scene = makeScene(Size(100, 80));
    const Mat images[] = {Mat(), Mat::zeros(80, 100, CV_8UC1), scene};
    for (const Mat& image : images)
    {
        Matx<uchar, 5, 32> fixed = Matx<uchar, 5, 32>::all(7);
        const Mat constant = Mat::ones(4, 32, CV_8UC1);
        std::vector<Mat> several(2, constant);
        std::vector<float> floats(3);
        for (int useProvided = 0; useProvided <= 1; useProvided++)
        {
            KeyPoints keypoints(3, KeyPoint(Point2f(50, 40), 31, 0));
            const auto call = [&](OutputArray output)
            {
                return messageOf(
                    [&]
                    { detector->detectAndCompute(image, noArray(), keypoints, output, useProvided != 0); });
            };
            EXPECT_TRUE(names(call(fixed), "descriptors", "32 x 5"));
            EXPECT_TRUE(names(call(constant), "descriptors", "32 x 4"));
            EXPECT_TRUE(names(call(several), "descriptors", "sequence"));
            EXPECT_TRUE(names(call(floats), "descriptors", "CV_32FC1"));
            EXPECT_EQ(3u, keypoints.size());
            EXPECT_EQ(3u, floats.size());
            EXPECT_EQ(2u, several.size());
            EXPECT_EQ(5 * 32, cv::countNonZero(Mat(fixed) == 7));
        }
    }
    std::vector<uchar> bytes(3);
    KeyPoints kept(3);
    EXPECT_TRUE(names(messageOf([&] { detector->detectAndCompute(scene, noArray(), kept, bytes); }),
                      "descriptors", "std::vector"));
    EXPECT_EQ(3u, bytes.size());
    EXPECT_EQ(3u, kept.size());
    // a fixed size that fits
    Matx<uchar, 20, 32> fixed;
    KeyPoints keypoints;
    EXPECT_NO_THROW(detector->detectAndCompute(scene, noArray(), keypoints, fixed));
    EXPECT_TRUE(sameFeatures(detectAndCompute(*detector, scene), Features{keypoints, Mat(fixed)}));
    const Mat nothing;
    EXPECT_NO_THROW(detector->detectAndCompute(Mat(), noArray(), keypoints, nothing));
    EXPECT_TRUE(keypoints.empty());

    Mat level = Mat::ones(4, 4, CV_8UC1);
    EXPECT_EQ("levels must be a vector of Mat or UMat",
              messageOf([&] { detector->buildPyramid(scene, level); }));
    EXPECT_EQ(4, level.rows);
    // vectors and arrays of matrices that the levels cannot be put into
    std::vector<Mat_<float>> floats(2, Mat_<float>(4, 4, 7.f));
    std::array<Mat, 3> three;
    const std::vector<Mat> constant(2, level);
    const Mat inputs[] = {Mat(), scene};
    for (const Mat& image : inputs)
    {
        EXPECT_TRUE(names(messageOf([&] { detector->buildPyramid(image, floats); }), "levels", "CV_32FC1"));
        EXPECT_TRUE(names(messageOf([&] { detector->buildPyramid(image, three); }), "levels", "3 images"));
        EXPECT_TRUE(names(messageOf([&] { detector->buildPyramid(image, constant); }), "levels", "2 images"));
    }
    ASSERT_EQ(2u, floats.size());
    EXPECT_EQ(CV_32FC1, floats[0].type());
    EXPECT_EQ(16, cv::countNonZero(floats[0] == 7.f));
    EXPECT_TRUE(three[0].empty());
    EXPECT_EQ(level.data, constant[0].data);
    std::vector<Mat_<uchar>> grey;
    std::array<Mat, 8> eight;
    EXPECT_NO_THROW(detector->buildPyramid(scene, grey));
    EXPECT_NO_THROW(detector->buildPyramid(scene, eight));
    ASSERT_EQ(eight.size(), grey.size());
    EXPECT_TRUE(sameMat(grey[7], eight[7]));
}

TEST(Aqorb_Errors, bad_octaves_of_provided_keypoints)
{
    const Ptr<AdaptiveQuadtreeORB> detector = AdaptiveQuadtreeORB::create();
    const Mat image = makeScene(Size(200, 150));
    Mat descriptors;
    KeyPoints keypoints(1, KeyPoint(Point2f(100, 70), 31, 0, 1, -1));
    EXPECT_TRUE(names(messageOf([&] { detector->compute(image, keypoints, descriptors); }), "octave", "-1"));
    // SIFT packs layer and scale into the octave: levels of no pixels
    keypoints[0].octave = 0x01000200 + 255;
    EXPECT_TRUE(
        names(messageOf([&] { detector->compute(image, keypoints, descriptors); }), "octave", "16777983"));
    // one untrusted keypoint that would ask for thousands of levels
    detector->setScaleFactor(1.0001);
    keypoints[0].octave = 63;
    EXPECT_NO_THROW(detector->compute(image, keypoints, descriptors));
    EXPECT_EQ(1u, keypoints.size());
    keypoints[0].octave = 64;
    EXPECT_TRUE(names(messageOf([&] { detector->compute(image, keypoints, descriptors); }), "octave", "64"));
    detector->setNLevels(65);
    EXPECT_NO_THROW(detector->compute(image, keypoints, descriptors));
    keypoints[0].octave = 1;
    detector->setScaleFactor(1);
    detector->setNLevels(1);
    EXPECT_TRUE(
        names(messageOf([&] { detector->compute(image, keypoints, descriptors); }), "scaleFactor", "1"));
}

TEST(Aqorb_Errors, bad_arguments_of_the_functions)
{
    KeyPoints keypoints(5, KeyPoint(Point2f(1, 1), 1));
    EXPECT_TRUE(names(messageOf([&] { aqorb::distributionUniformity(keypoints, Size(0, 5)); }), "imageSize",
                      "0 x 5"));
    EXPECT_TRUE(names(messageOf([&] { aqorb::distributionUniformity(keypoints, Size(1, -1)); }), "imageSize",
                      "1 x -1"));
    EXPECT_TRUE(names(messageOf([&] { aqorb::distributionOccupancy(keypoints, Size(0, 120)); }), "imageSize",
                      "0 x 120"));
    EXPECT_TRUE(names(messageOf([&] { aqorb::distributionOccupancy(keypoints, Size(5, -1)); }), "imageSize",
                      "5 x -1"));
    EXPECT_TRUE(names(messageOf([&] { aqorb::distributionOccupancy(keypoints, Size(5, 5), Size(0, 1)); }),
                      "grid", "0 x 1"));
    EXPECT_TRUE(
        names(messageOf([&] { aqorb::distributionOccupancy(keypoints, Size(5, 5), Size(1 << 20, 1 << 20)); }),
              "grid", "1048576"));
    EXPECT_TRUE(
        names(messageOf([&] { aqorb::distributionOccupancy(keypoints, Size(5, 5), Size(5000, 5000)); }),
              "grid", "5000"));
    EXPECT_TRUE(names(messageOf([&] { aqorb::retainUniform(keypoints, Size(), 5); }), "imageSize", "0 x 0"));
    EXPECT_TRUE(
        names(messageOf([&] { aqorb::retainUniform(keypoints, Size(10, -1), 5); }), "imageSize", "10 x -1"));
    EXPECT_TRUE(names(messageOf([&] { aqorb::retainUniform(keypoints, Size(5, 5), -5); }), "npoints", "-5"));
    EXPECT_TRUE(sameKeypoints(KeyPoints(5, KeyPoint(Point2f(1, 1), 1)), keypoints));
}

TEST(Aqorb_Errors, points_that_are_nowhere_are_dropped)
{
    const Mat image = makeScene(Size(200, 150));
    for (int border = 0; border <= 16; border += 16)
    {
        KeyPoints keypoints;
        const float far[] = {NOT_A_NUMBER, ENDLESS, -ENDLESS, 1e30f, -1e30f, 200.6f, -0.6f};
        for (float x : far)
        {
            keypoints.push_back(KeyPoint(Point2f(x, 70), 31, 0));
            keypoints.push_back(KeyPoint(Point2f(70, x), 31, 0, 0, 3));
        }
        keypoints.push_back(KeyPoint(Point2f(70, 70), 31, 0));
        Mat descriptors;
        AdaptiveQuadtreeORB::create(500, 1.2f, 8, border)->compute(image, keypoints, descriptors);
        EXPECT_EQ(1u, keypoints.size());
        EXPECT_EQ(1, descriptors.rows);
    }
}

TEST(Aqorb_Errors, extreme_parameters_work)
{
    const Mat image = makeScene(Size(120, 90));
    KeyPoints keypoints(7);
    Mat descriptors(3, 3, CV_8U);
    AdaptiveQuadtreeORB::create(500, 1.2f, 8, INT_MAX)
        ->detectAndCompute(image, noArray(), keypoints, descriptors);
    EXPECT_TRUE(keypoints.empty());
    EXPECT_TRUE(descriptors.empty());
    AdaptiveQuadtreeORB::create(INT_MAX, 1.2f, 60000)
        ->detectAndCompute(image, noArray(), keypoints, descriptors);
    EXPECT_FALSE(keypoints.empty());
    AdaptiveQuadtreeORB::create(20, 1e30f, 8)->detectAndCompute(image, noArray(), keypoints, descriptors);
    EXPECT_EQ(20u, keypoints.size());
    AdaptiveQuadtreeORB::create(2, 1.2f, 8, 16, 0, 4, ORB::HARRIS_SCORE, 3001)
        ->detectAndCompute(image, noArray(), keypoints, descriptors);
    EXPECT_EQ(2u, keypoints.size());
    KeyPoints given(1, KeyPoint(Point2f(50, 50), 31, 12));
    AdaptiveQuadtreeORB::create(2, 1.2f, 8, INT_MAX)->compute(image, given, descriptors);
    EXPECT_TRUE(given.empty());
}

TEST(Aqorb_Errors, fast_threshold_is_limited_as_by_fast)
{
    const Mat image = makeScene(Size(120, 90));
    const int outside[][2] = {{-1, 0}, {INT_MIN, 0}, {256, 255}, {INT_MAX, 255}};
    for (int adaptive = 0; adaptive <= 1; adaptive++)
    {
        const Ptr<AdaptiveQuadtreeORB> detector = AdaptiveQuadtreeORB::create(5000);
        detector->setAdaptiveThreshold(adaptive != 0);
        for (const int* pair : outside)
        {
            detector->setFastThreshold(pair[1]);
            const Features expected = detectAndCompute(*detector, image);
            detector->setFastThreshold(pair[0]);
            EXPECT_EQ(pair[0], detector->getFastThreshold());
            EXPECT_TRUE(sameFeatures(expected, detectAndCompute(*detector, image))) << pair[0];
        }
    }
}

}  // namespace
}  // namespace opencv_test
