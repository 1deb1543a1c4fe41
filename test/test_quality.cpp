// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "test_precomp.hpp"

#include <iostream>

// What the detector is for, measured on real images beside cv::ORB: keypoints spread uniformly, and dark images. The
// figures are printed. What is matched, scripts/measure.sh claims measures.

namespace opencv_test
{
namespace
{

const char* const SETS[] = {"bikes", "leuven", "bark", "trees", "ubc", "graf"};
const int SETS_OF_UNIFORMITY = 5;  // all but graf
const int IMAGES = 6;

Mat readColour(const std::string& set, int index)
{
    const Mat image = imread(oxfordImage(set, index), IMREAD_COLOR);
    EXPECT_FALSE(image.empty()) << oxfordImage(set, index);
    return image;
}

KeyPoints detect(Feature2D& detector, const Mat& image)
{
    KeyPoints keypoints;
    detector.detect(image, keypoints);
    return keypoints;
}

//! AdaptiveQuadtreeORB and cv::ORB.
std::vector<Ptr<ORB>> bothDetectors(int nfeatures)
{
    return {AdaptiveQuadtreeORB::create(nfeatures), ORB::create(nfeatures)};
}

//! Prints one measure of both detectors.
void report(const std::string& figure, const double (&values)[2])
{
    std::cout << format("[ FIGURE   ] %-52s %8.3f  cv::ORB %8.3f", figure.c_str(), values[0], values[1])
              << std::endl;
}

TEST(Aqorb_Quality, uniform_on_photographs)
{
    AQORB_NEEDS_DATA();
    const std::vector<Ptr<ORB>> detectors = bothDetectors(500);
    double mean[2] = {0, 0}, occupancy[2] = {0, 0};
    for (int s = 0; s < SETS_OF_UNIFORMITY; s++)
    {
        double setMeans[2] = {0, 0};
        for (int i = 1; i <= IMAGES; i++)
        {
            const Mat image = readColour(SETS[s], i);
            ASSERT_FALSE(image.empty());
            for (int d = 0; d < 2; d++)
            {
                const KeyPoints found = detect(*detectors[d], image);
                setMeans[d] += aqorb::distributionUniformity(found, image.size()) / IMAGES;
                occupancy[d] +=
                    aqorb::distributionOccupancy(found, image.size()) / IMAGES / SETS_OF_UNIFORMITY;
            }
        }
        report(std::string("uniformity, n = 500, ") + SETS[s], setMeans);
        EXPECT_LT(setMeans[0], setMeans[1]) << SETS[s];
        for (int d = 0; d < 2; d++)
            mean[d] += setMeans[d] / SETS_OF_UNIFORMITY;
    }
    report("uniformity, n = 500, mean of five sets", mean);
    report("occupancy, n = 500, mean of five sets", occupancy);
    EXPECT_LE(mean[0], 155);
    EXPECT_LT(mean[0], mean[1]);
    EXPECT_GT(occupancy[0], occupancy[1]);
}

// All features that are asked for in ordinary images, and half of them in dark ones, in which cv::ORB finds next to
// nothing, though there is enough to see.
TEST(Aqorb_Quality, finds_features_in_bright_and_in_dark_images)
{
    AQORB_NEEDS_DATA();
    const std::vector<Ptr<ORB>> detectors = bothDetectors(500);
    double mean[2] = {0, 0};
    size_t least = 500;
    for (const std::string set : SETS)
        for (int i = 1; i <= IMAGES; i++)
        {
            SCOPED_TRACE(set + " " + std::to_string(i));
            const Mat image = readColour(set, i);
            ASSERT_FALSE(image.empty());
            if (set == "bark" || set == "trees" || set == "ubc")
            {
                EXPECT_EQ(500u, detect(*detectors[0], image).size());
            }
            Mat dark;
            image.convertTo(dark, CV_8U, 0.12);
            for (int d = 0; d < 2; d++)
            {
                const size_t count = detect(*detectors[d], dark).size();
                mean[d] += double(count) / (6 * IMAGES);
                least = std::min(least, d == 0 ? count : least);
            }
        }
    report("keypoints of 500 in dark images (x 0.12), mean", mean);
    std::cout << "[ FIGURE   ] least: " << least << std::endl;
    EXPECT_GE(least, 250u);
}

}  // namespace
}  // namespace opencv_test

// Where OpenCV's build offers its tests of features that are found again after a scene was turned or shrunk, they run.
// scripts/measure.sh claims measures it on photographs, beside cv::ORB.

#if defined(__OPENCV_TESTS) && defined(AQORB_FEATURES2D_TESTS)

#include "test_invariance_utils.hpp"
#include "test_detectors_invariance.impl.hpp"
#include "test_descriptors_invariance.impl.hpp"

namespace opencv_test
{
namespace
{

// Without OpenCV's images there is nothing to instantiate.

const char* const TSUKUBA = "features2d/tsukuba.png";
const char* const BIKES = "detectors_descriptors_evaluation/images_datasets/bikes/img1.png";

// The tests of OpenCV 4.6 take a detector, those of 4.14 and 5 a function that makes one.
struct Made
{
    Ptr<AdaptiveQuadtreeORB> detector;

    operator Ptr<FeatureDetector>() const { return detector; }
    Ptr<FeatureDetector> operator()() const { return detector; }
};

std::vector<String_FeatureDetector_Float_Float_t>
detectorCase(const char* image, const Ptr<AdaptiveQuadtreeORB>& detector, float repeated, float inliers)
{
    std::vector<String_FeatureDetector_Float_Float_t> cases;
    if (!dataFile("").empty())
        cases.push_back(String_FeatureDetector_Float_Float_t(image, Made{detector}, repeated, inliers));
    return cases;
}

std::vector<String_FeatureDetector_DescriptorExtractor_Float_t> descriptorCase(const char* image,
                                                                               float inliers)
{
    std::vector<String_FeatureDetector_DescriptorExtractor_Float_t> cases;
    if (!dataFile("").empty())
        cases.push_back(String_FeatureDetector_DescriptorExtractor_Float_t(
            image, Made{AdaptiveQuadtreeORB::create()}, Made{AdaptiveQuadtreeORB::create()}, inliers));
    return cases;
}

// The thresholds are cv::ORB's.
INSTANTIATE_TEST_CASE_P(Aqorb, DetectorRotationInvariance,
                        testing::ValuesIn(detectorCase(TSUKUBA, AdaptiveQuadtreeORB::create(), 0.5f, 0.76f)));
INSTANTIATE_TEST_CASE_P(Aqorb, DetectorScaleInvariance,
                        testing::ValuesIn(detectorCase(BIKES, AdaptiveQuadtreeORB::create(), 0.08f, 0.49f)));
INSTANTIATE_TEST_CASE_P(Aqorb, DescriptorRotationInvariance,
                        testing::ValuesIn(descriptorCase(TSUKUBA, 0.99f)));

}  // namespace
}  // namespace opencv_test

#endif
