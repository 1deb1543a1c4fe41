// This file is part of the aqorb project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.

#include "test_precomp.hpp"

#include <limits>

namespace opencv_test
{
namespace
{

// The message of the exception that a call raises; empty if it raises none.
template <typename Call> std::string messageOf(Call call)
{
    try
    {
        call();
    }
    catch (const cv::Exception& e)
    {
        return e.err;
    }
    return std::string();
}

::testing::AssertionResult names(const std::string& message, const std::string& name,
                                 const std::string& value)
{
    // The value must be in the part that says what was given, not in what is accepted.
    const std::string given = message.substr(0, message.find(';'));
    if (given.find(name) != std::string::npos && given.find(value) != std::string::npos &&
        message.find("accepted", given.size()) != std::string::npos)
        return ::testing::AssertionSuccess();
    return ::testing::AssertionFailure()
           << "'" << message << "' does not name " << name << ", " << value << " and what is accepted";
}

const float NOT_A_NUMBER = std::numeric_limits<float>::quiet_NaN();
const float ENDLESS = std::numeric_limits<float>::infinity();

TEST(Aqorb_Errors, bad_parameters_of_create)
{
#define AQORB_BAD(name, value, call) \
    EXPECT_TRUE(names(messageOf([] { AdaptiveQuadtreeORB::call; }), name, value))
    AQORB_BAD("nfeatures", "-1", create(-1));
    AQORB_BAD("scaleFactor", "0", create(500, 0.f));
    AQORB_BAD("scaleFactor", "-2", create(500, -2.f));
    AQORB_BAD("scaleFactor", "nan", create(500, NOT_A_NUMBER));
    AQORB_BAD("scaleFactor", "inf", create(500, ENDLESS));
    AQORB_BAD("nlevels", "0", create(500, 1.2f, 0));
    AQORB_BAD("nlevels", "2147483647", create(500, 1.2f, INT_MAX));
    AQORB_BAD("edgeThreshold", "-3", create(500, 1.2f, 8, -3));
    AQORB_BAD("firstLevel", "-1", create(500, 1.2f, 8, 16, -1));
    AQORB_BAD("WTA_K", "1", create(500, 1.2f, 8, 16, 0, 1));
    AQORB_BAD("WTA_K", "5", create(500, 1.2f, 8, 16, 0, 5));
    AQORB_BAD("scoreType", "7", create(500, 1.2f, 8, 16, 0, 2, static_cast<ORB::ScoreType>(7)));
    AQORB_BAD("patchSize", "1", create(500, 1.2f, 8, 16, 0, 2, ORB::HARRIS_SCORE, 1));
    AQORB_BAD("patchSize", "16385", create(500, 1.2f, 8, 16, 0, 2, ORB::HARRIS_SCORE, 16385));
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
    AQORB_BAD("cellSize", "7", setCellSize(7));
    AQORB_BAD("maxDepth", "-2", setMaxDepth(-2));
    AQORB_BAD("maxDepth", "16", setMaxDepth(16));
    AQORB_BAD("octaveSuppression", "-0.5", setOctaveSuppression(-0.5));
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
    EXPECT_NO_THROW(detector->setCellSize(8));
    EXPECT_NO_THROW(detector->setCellSize(INT_MAX));
    EXPECT_NO_THROW(detector->setMaxDepth(-1));
    EXPECT_NO_THROW(detector->setMaxDepth(0));
    EXPECT_NO_THROW(detector->setMaxDepth(15));
    EXPECT_NO_THROW(detector->setOctaveSuppression(0));
}

TEST(Aqorb_Errors, parameters_that_do_not_go_together)
{
    const Mat image = makeScene(Size(200, 150));
    KeyPoints keypoints;
    Ptr<AdaptiveQuadtreeORB> detector = AdaptiveQuadtreeORB::create(500, 1.f, 2);
    EXPECT_TRUE(names(messageOf([&] { detector->detect(image, keypoints); }), "scaleFactor", "1"));
    detector = AdaptiveQuadtreeORB::create(500, 1.2f, 4, 16, 4);
    EXPECT_TRUE(names(messageOf([&] { detector->detect(image, keypoints); }), "firstLevel", "4"));
    detector->setNLevels(5);  // the order of setters does not matter
    EXPECT_NO_THROW(detector->detect(image, keypoints));
    detector = AdaptiveQuadtreeORB::create(500, 3.f, 60, 16, 50);
    EXPECT_TRUE(names(messageOf([&] { detector->detect(image, keypoints); }), "firstLevel", "pixels"));
}

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
    EXPECT_EQ(3u, keypoints.size());  // a call that fails leaves its outputs
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

TEST(Aqorb_Errors, a_cell_larger_than_the_image_is_one_cell)
{
    // However large it is: its far side must not be computed beyond what an int holds.
    const Mat image = makeScene(Size(120, 90));
    const Ptr<AdaptiveQuadtreeORB> detector = AdaptiveQuadtreeORB::create(50);
    detector->setCellSize(120);
    const Features expected = detectAndCompute(*detector, image);
    EXPECT_EQ(50u, expected.keypoints.size());
    const int sizes[] = {121, 1 << 20, INT_MAX - 100, INT_MAX};
    for (int size : sizes)
    {
        detector->setCellSize(size);
        Features found;
        EXPECT_NO_THROW(found = detectAndCompute(*detector, image)) << size;
        EXPECT_TRUE(sameFeatures(expected, found)) << size;
    }
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
