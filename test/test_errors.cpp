// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "test_precomp.hpp"

#include "detector/parameters.hpp"

#include <array>

namespace opencv_test
{
namespace
{

TEST(Aqorb_Errors, are_said_as_a_person_would)
{
    EXPECT_EQ("nfeatures must be at least 0, got -1", messageOf([] { AdaptiveQuadtreeORB::create(-1); }));
    const Ptr<AdaptiveQuadtreeORB> detector = AdaptiveQuadtreeORB::create();
    EXPECT_EQ("nlevels must be from 1 to 65536, got 0", messageOf([&] { detector->setNLevels(0); }));
    EXPECT_EQ("scoreType must be HARRIS_SCORE (0) or FAST_SCORE (1), got 2",
              messageOf([&] { detector->setScoreType(static_cast<ORB::ScoreType>(2)); }));
    EXPECT_EQ("octaveSuppression must be finite and at least 0, or -1, got -0.5",
              messageOf([&] { detector->setOctaveSuppression(-0.5); }));
}

TEST(Aqorb_Errors, bad_parameters_of_create)
{
    const auto scoreType = static_cast<ORB::ScoreType>(7);
    AQORB_BAD("nfeatures", "-1", AdaptiveQuadtreeORB::create(-1));
    AQORB_BAD("scaleFactor", "0", AdaptiveQuadtreeORB::create(500, 0.f));
    AQORB_BAD("scaleFactor", "nan", AdaptiveQuadtreeORB::create(500, NOT_A_NUMBER));
    AQORB_BAD("nlevels", "2147483647", AdaptiveQuadtreeORB::create(500, 1.2f, INT_MAX));
    AQORB_BAD("edgeThreshold", "-3", AdaptiveQuadtreeORB::create(500, 1.2f, 8, -3));
    AQORB_BAD("firstLevel", "-1", AdaptiveQuadtreeORB::create(500, 1.2f, 8, 16, -1));
    AQORB_BAD("WTA_K", "5", AdaptiveQuadtreeORB::create(500, 1.2f, 8, 16, 0, 5));
    AQORB_BAD("scoreType", "7", AdaptiveQuadtreeORB::create(500, 1.2f, 8, 16, 0, 2, scoreType));
    AQORB_BAD("patchSize", "2147483647",
              AdaptiveQuadtreeORB::create(500, 1.2f, 8, 16, 0, 2, ORB::HARRIS_SCORE, INT_MAX));
}

//! Expects that all functions refuse an image and leave the keypoints as they are.
void expectRefused(AdaptiveQuadtreeORB& detector, const Mat& image, const std::string& name,
                   const std::string& value)
{
    KeyPoints keypoints(1, KeyPoint(Point2f(20, 0), 31, 0, 0, 2));
    std::vector<Mat> levels;
    Mat descriptors;
    AQORB_BAD(name, value, detector.detect(image, keypoints, Mat(image.size(), CV_8UC1, Scalar(1))));
    AQORB_BAD(name, value, detector.compute(image, keypoints, descriptors));
    AQORB_BAD(name, value, detector.buildPyramid(image, levels));
    EXPECT_EQ(1u, keypoints.size());
}

//! A parameter by its row of the table.
struct Parameter
{
    std::string name;
    aqorb::ValidRange range, type;  // of the parameter, and of the numbers of its type
    void (*set)(AdaptiveQuadtreeORB& detector, double value);
};

template <typename T> aqorb::ValidRange typeRange()
{
    typedef std::numeric_limits<aqorb::Stored<T>> Limits;
    return aqorb::between(double(Limits::lowest()), double(Limits::max()));
}

// A parameter's range is that of messages and of the documentation.
TEST(Aqorb_Errors, setters_take_the_ends_of_the_range_and_values_beyond_leave_the_object_unchanged)
{
    using namespace aqorb;
    const Parameter parameters[] = {
#define AQORB_PARAMETER(property, type, name, key, byDefault, range, ...) \
    {#name, range, typeRange<type>(),                                     \
     [](AdaptiveQuadtreeORB& d, double value) { d.set##property(type(value)); }},
        AQORB_PARAMETERS(AQORB_PARAMETER)
#undef AQORB_PARAMETER
    };
    const Mat image = makeScene(Size(200, 150));
    for (const Parameter& parameter : parameters)
    {
        const Ptr<AdaptiveQuadtreeORB> detector = AdaptiveQuadtreeORB::create();
        const Features before = detectAndCompute(*detector, image);
        const double min = std::max(parameter.range.min, parameter.type.min),
                     max = std::min(parameter.range.max, parameter.type.max);
        const bool isReal = parameter.type.max > INT_MAX;
        std::vector<double> bad;
        if (min > parameter.type.min)
            bad.push_back(min - (isReal ? 0.5 : 1));
        if (max < parameter.type.max)
            bad.push_back(max + (isReal ? 0.5 : 1));
        if (isReal)
            bad.insert(bad.end(), {NOT_A_NUMBER, ENDLESS, -ENDLESS});
        for (double value : bad)
            AQORB_BAD(parameter.name, format("%.10g", value), parameter.set(*detector, value));
        EXPECT_TRUE(sameFeatures(before, detectAndCompute(*detector, image)));
        for (double value : {min, max, parameter.range.acceptsMinusOne ? -1 : min})
            EXPECT_NO_THROW(parameter.set(*detector, value)) << parameter.name << " " << value;
    }
}

TEST(Aqorb_Errors, parameters_that_do_not_go_together)
{
    const Mat image = makeScene(Size(200, 150));
    KeyPoints keypoints;
    EXPECT_EQ("scaleFactor must be above 1 with more than one level, got 0.5",
              messageOf([] { AdaptiveQuadtreeORB::create(500, 0.5f); }));
    EXPECT_EQ("firstLevel must be below nlevels, which is 4, got 4",
              messageOf([] { AdaptiveQuadtreeORB::create(500, 1.2f, 4, 16, 4); }));
    Ptr<AdaptiveQuadtreeORB> detector = AdaptiveQuadtreeORB::create(500, 0.5f, 1);
    EXPECT_NO_THROW(detector->detect(image, keypoints));
    detector->setNLevels(2);
    AQORB_BAD("scaleFactor", "0.5", detector->detect(image, keypoints));
    detector->setScaleFactor(1.2);  // The order of the setters does not matter.
    detector->setFirstLevel(4);
    AQORB_BAD("firstLevel", "4", detector->detect(image, keypoints));
    detector->setNLevels(5);
    EXPECT_NO_THROW(detector->detect(image, keypoints));
    detector = AdaptiveQuadtreeORB::create(500, 3.f, 60, 16, 50);
    AQORB_BAD("firstLevel", "200 x 150", detector->detect(image, keypoints));
}

// The first one's finest level has more pixels than an int can count.
TEST(Aqorb_Errors, levels_that_need_too_much_memory)
{
    const struct
    {
        Size size;
        double scaleFactor;
        int nlevels, firstLevel;
    } cases[] = {{Size(257, 256), 2, 9, 8}, {Size(64, 64), 16, 7, 3}, {Size(100, 1), 8, 7, 4}};
    for (const auto& c : cases)
    {
        SCOPED_TRACE(c.scaleFactor);
        const auto detector = AdaptiveQuadtreeORB::create(500, 1.2f, c.nlevels, 0, c.firstLevel);
        detector->setScaleFactor(c.scaleFactor);
        expectRefused(*detector, makeScene(c.size), "scaleFactor and firstLevel", "pixels");
    }
}

TEST(Aqorb_Errors, bad_images_and_masks)
{
    const Ptr<AdaptiveQuadtreeORB> detector = AdaptiveQuadtreeORB::create();
    KeyPoints keypoints(3);
    Mat descriptors = Mat::ones(3, 32, CV_8UC1);
    std::vector<Mat> levels;
    // OpenCV's issue 21539 is about 16-bit images.
    for (int type :
         {CV_16UC1, CV_16SC1, CV_16UC3, CV_32FC1, CV_32FC3, CV_64FC1, CV_64FC3, CV_8SC1, CV_8UC2, CV_8UC(5)})
    {
        const Mat image(100, 100, type);
        AQORB_BAD("image", typeToString(type), detector->detect(image, keypoints));
        AQORB_BAD("image", typeToString(type), aqorb::adaptiveFastThreshold(image));
    }
    const Mat image = makeScene(Size(100, 80));
    for (const Mat& mask : {Mat(80, 99, CV_8UC1, Scalar(1)), Mat(100, 80, CV_8UC1, Scalar(1)),
                            Mat(80, 100, CV_8UC3, Scalar::all(1)), Mat(80, 100, CV_32FC1, Scalar(1))})
    {
        const std::string size = format("%d x %d", mask.cols, mask.rows);
        AQORB_BAD("mask", size, detector->detect(image, keypoints, mask));
        AQORB_BAD("mask", size, aqorb::adaptiveFastThreshold(image, mask));
    }
    const std::vector<Mat> images(3, image);
    const std::vector<UMat> uimages(3, image.getUMat(ACCESS_READ));
    const std::vector<std::vector<uchar>> rows(3, std::vector<uchar>(100));
    const _InputArray sequences[] = {images, uimages, rows};
    for (const _InputArray& s : sequences)
    {
        AQORB_BAD("image", "3", detector->detectAndCompute(s, noArray(), keypoints, descriptors));
        AQORB_BAD("image", "3", detector->buildPyramid(s, levels));
        AQORB_BAD("image", "3", aqorb::adaptiveFastThreshold(s));
        AQORB_BAD("mask", "3", detector->detectAndCompute(image, s, keypoints, descriptors));
        AQORB_BAD("mask", "3", aqorb::adaptiveFastThreshold(image, s));
    }
    EXPECT_EQ(3u, keypoints.size());  // A call that fails leaves its outputs unchanged.
    EXPECT_EQ(3, countNonZero(descriptors.col(0)));
}

TEST(Aqorb_Errors, bad_collections)
{
    const Ptr<AdaptiveQuadtreeORB> detector = AdaptiveQuadtreeORB::create(80);
    const std::vector<Mat> images(2, makeScene(Size(90, 80)));
    Mat single = images[0];
    std::array<Mat, 3> three;
    std::vector<Mat_<float>> floats;
    std::vector<KeyPoints> keypoints(7);
    std::vector<Mat> descriptors(1);
    const auto batchError = [&](InputArrayOfArrays input, InputArrayOfArrays masks, OutputArrayOfArrays out)
    { return messageOf([&] { detector->detectAndComputeBatch(input, masks, keypoints, out); }); };
    const std::string vectors = " must be a vector of Mat or UMat";
    EXPECT_EQ("images" + vectors, batchError(single, noArray(), descriptors));
    EXPECT_EQ("masks" + vectors, batchError(images, single, descriptors));
    EXPECT_EQ("descriptors" + vectors, batchError(images, noArray(), single));
    EXPECT_EQ("masks must be one for each image or none, got 3 for 2 images",
              batchError(images, std::vector<Mat>(3), descriptors));
    EXPECT_EQ("descriptors must have a variable size or that of 2 images, got 3 images",
              batchError(images, noArray(), three));
    EXPECT_EQ("descriptors must be of type CV_8UC1, got CV_32FC1", batchError(images, noArray(), floats));
    EXPECT_EQ("masks must be one for each image or none, got 1 for 2 images",
              messageOf([&] { detector->detect(images, keypoints, std::vector<Mat>(1)); }));
    EXPECT_EQ("keypoints must be one vector for each image, got 7 for 2 images",
              messageOf([&] { detector->compute(images, keypoints, descriptors); }));
    EXPECT_TRUE(keypoints.size() == 7 && descriptors.size() == 1 && floats.empty() && three[0].empty());
}

TEST(Aqorb_Errors, images_too_large_for_a_pyramid)
{
    const int side = 1 << 20;
    const Ptr<AdaptiveQuadtreeORB> detector = AdaptiveQuadtreeORB::create(500, 1.2f, 8, 0);
    for (const Size& size : {Size(side, 2), Size(2, side), Size(side + 9, 1)})
        expectRefused(*detector, Mat(size, CV_8UC1, Scalar(9)), "image",
                      format("%d x %d", size.width, size.height));
    // The largest image is accepted, but not with a level before it.
    const Mat largest(2, side - 1, CV_8UC1, Scalar(9));
    KeyPoints keypoints;
    EXPECT_NO_THROW(detector->detect(largest, keypoints));
    detector->setFirstLevel(1);
    AQORB_BAD("firstLevel", "1048575 x 2", detector->detect(largest, keypoints));
}

TEST(Aqorb_Errors, outputs_that_do_not_fit_lose_nothing)
{
    const Ptr<AdaptiveQuadtreeORB> detector = AdaptiveQuadtreeORB::create(20);
    const Mat scene = makeScene(Size(100, 80)), constant = Mat::ones(4, 32, CV_8UC1);
    KeyPoints keypoints(3, KeyPoint(Point2f(50, 40), 31, 0));
    Matx<uchar, 5, 32> fixed = Matx<uchar, 5, 32>::all(7);
    std::vector<Mat> several(2, constant);
    std::vector<float> floats(3);
    std::vector<uchar> bytes(3);
    std::vector<Mat_<float>> floatLevels(2, Mat_<float>(4, 4, 7.f));
    std::array<Mat, 3> three;
    Mat level = Mat::ones(4, 4, CV_8UC1);
    const std::vector<Mat> constants(2, level);
    for (const Mat& image : {Mat(), Mat(Mat::zeros(80, 100, CV_8UC1)), scene})
    {
        for (bool useProvided : {false, true})
        {
            const auto detect = [&](OutputArray output)
            { detector->detectAndCompute(image, noArray(), keypoints, output, useProvided); };
            AQORB_BAD("descriptors", "32 x 5", detect(fixed));
            AQORB_BAD("descriptors", "32 x 4", detect(constant));
            AQORB_BAD("descriptors", "sequence", detect(several));
            AQORB_BAD("descriptors", "CV_32FC1", detect(floats));
        }
        AQORB_BAD("levels", "CV_32FC1", detector->buildPyramid(image, floatLevels));
        AQORB_BAD("levels", "3 images", detector->buildPyramid(image, three));
        AQORB_BAD("levels", "2 images", detector->buildPyramid(image, constants));
    }
    AQORB_BAD("descriptors", "std::vector", detector->detectAndCompute(scene, noArray(), keypoints, bytes));
    EXPECT_EQ("levels must be a vector of Mat or UMat",
              messageOf([&] { detector->buildPyramid(scene, level); }));
    EXPECT_TRUE(keypoints.size() == 3 && floats.size() == 3 && bytes.size() == 3 && several.size() == 2);
    EXPECT_EQ(5 * 32, countNonZero(Mat(fixed) == 7));
    EXPECT_EQ(16, countNonZero(floatLevels.at(1) == 7.f));
    EXPECT_TRUE(level.rows == 4 && three[0].empty() && constants[0].data == level.data);

    // outputs of a fixed size or type that fits
    Matx<uchar, 20, 32> fitting;
    EXPECT_NO_THROW(detector->detectAndCompute(scene, noArray(), keypoints, fitting));
    EXPECT_TRUE(sameFeatures(detectAndCompute(*detector, scene), Features{keypoints, Mat(fitting)}));
    std::array<Mat, 8> eight;
    EXPECT_NO_THROW(detector->buildPyramid(scene, eight));
    EXPECT_FALSE(eight[7].empty());
}

TEST(Aqorb_Errors, bad_octaves_of_provided_keypoints)
{
    const Ptr<AdaptiveQuadtreeORB> detector = AdaptiveQuadtreeORB::create();
    const auto compute = [&](int octave)
    {
        Features given = {KeyPoints(1, KeyPoint(Point2f(100, 70), 31, 0, 1, octave)), Mat()};
        detector->compute(makeScene(Size(200, 150)), given.keypoints, given.descriptors);
        EXPECT_EQ(1, given.descriptors.rows);
    };
    AQORB_BAD("octave", "-1", compute(-1));
    // SIFT packs layer and scale into the octave: levels of no pixels
    AQORB_BAD("octave", "16777983", compute(0x01000200 + 255));
    // one untrusted keypoint that would ask for thousands of levels
    detector->setScaleFactor(1.0001);
    EXPECT_NO_THROW(compute(63));
    AQORB_BAD("octave", "64", compute(64));
    detector->setNLevels(65);
    EXPECT_NO_THROW(compute(64));
    detector->setScaleFactor(1);
    detector->setNLevels(1);
    AQORB_BAD("scaleFactor", "1", compute(1));
}

TEST(Aqorb_Errors, bad_arguments_of_the_functions)
{
    using namespace aqorb;
    KeyPoints keypoints(5, KeyPoint(Point2f(1, 1), 1));
    const Size size(5, 5);
    AQORB_BAD("imageSize", "0 x 5", distributionUniformity(keypoints, Size(0, 5)));
    AQORB_BAD("imageSize", "1 x -1", distributionUniformity(keypoints, Size(1, -1)));
    AQORB_BAD("imageSize", "5 x -1", distributionOccupancy(keypoints, Size(5, -1)));
    AQORB_BAD("grid", "0 x 1", distributionOccupancy(keypoints, size, Size(0, 1)));
    AQORB_BAD("grid", "1048576", distributionOccupancy(keypoints, size, Size(1 << 20, 1 << 20)));
    AQORB_BAD("imageSize", "0 x 0", retainUniform(keypoints, Size(), 5));
    AQORB_BAD("imageSize", "10 x -1", retainUniform(keypoints, Size(10, -1), 5));
    AQORB_BAD("npoints", "-5", retainUniform(keypoints, size, -5));
    EXPECT_TRUE(sameKeypoints(KeyPoints(5, KeyPoint(Point2f(1, 1), 1)), keypoints));
}

TEST(Aqorb_Errors, points_that_are_nowhere_are_dropped)
{
    for (int border = 0; border <= 16; border += 16)
    {
        Features features = {KeyPoints(1, KeyPoint(Point2f(70, 70), 31, 0)), Mat()};
        for (float x : {NOT_A_NUMBER, ENDLESS, -ENDLESS, 1e30f, -1e30f, 200.6f, -0.6f})
        {
            features.keypoints.push_back(KeyPoint(Point2f(x, 70), 31, 0));
            features.keypoints.push_back(KeyPoint(Point2f(70, x), 31, 0, 0, 3));
        }
        AdaptiveQuadtreeORB::create(500, 1.2f, 8, border)
            ->compute(makeScene(Size(200, 150)), features.keypoints, features.descriptors);
        EXPECT_EQ(1u, features.keypoints.size());
        EXPECT_EQ(1, features.descriptors.rows);
    }
}

TEST(Aqorb_Errors, extreme_parameters_work)
{
    const Mat image = makeScene(Size(120, 90));
    const auto count = [&](const Ptr<AdaptiveQuadtreeORB>& detector)
    { return detectAndCompute(*detector, image).keypoints.size(); };
    EXPECT_EQ(0u, count(AdaptiveQuadtreeORB::create(500, 1.2f, 8, INT_MAX)));
    EXPECT_LT(0u, count(AdaptiveQuadtreeORB::create(INT_MAX, 1.2f, 60000)));
    EXPECT_EQ(20u, count(AdaptiveQuadtreeORB::create(20, 1e30f, 8)));
    EXPECT_EQ(2u, count(AdaptiveQuadtreeORB::create(2, 1.2f, 8, 16, 0, 4, ORB::HARRIS_SCORE, 3001)));
    Features given = {KeyPoints(1, KeyPoint(Point2f(50, 50), 31, 12)), Mat()};
    AdaptiveQuadtreeORB::create(2, 1.2f, 8, INT_MAX)->compute(image, given.keypoints, given.descriptors);
    EXPECT_TRUE(given.keypoints.empty());
}

TEST(Aqorb_Errors, angles_that_are_not_finite)
{
    // They made the descriptor read outside the image, as they still make that of cv::ORB.
    const Mat image = makeScene(Size(120, 90));
    for (int WTA_K = 2; WTA_K <= 4; WTA_K++)
    {
        const Ptr<AdaptiveQuadtreeORB> detector = AdaptiveQuadtreeORB::create(500, 1.2f, 8, 16, 0, WTA_K);
        for (float angle : {ENDLESS, -ENDLESS, NOT_A_NUMBER})
        {
            KeyPoints keypoints = {KeyPoint(60, 45, 31, 10), KeyPoint(60, 45, 31, angle)};
            Mat descriptors;
            EXPECT_THROW(detector->compute(image, keypoints, descriptors), cv::Exception) << angle;
            EXPECT_EQ(2u, keypoints.size());
        }
        // Any finite angle is accepted, whole turns or not.
        for (float angle : {360.f * 1000, -1e30f})
        {
            KeyPoints keypoints = {KeyPoint(60, 45, 31, 0), KeyPoint(60, 45, 31, angle)};
            Mat descriptors;
            EXPECT_NO_THROW(detector->compute(image, keypoints, descriptors));
            ASSERT_EQ(2, descriptors.rows);
            EXPECT_EQ(angle, keypoints[1].angle);
            EXPECT_EQ(angle > 0, sameMat(descriptors.row(0), descriptors.row(1)));
        }
    }
}

}  // namespace
}  // namespace opencv_test
