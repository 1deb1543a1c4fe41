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

//! Prints one measure of both detectors.
void report(const std::string& figure, const double (&values)[2])
{
    std::cout << format("[ FIGURE   ] %-52s %8.3f  cv::ORB %8.3f", figure.c_str(), values[0], values[1])
              << std::endl;
}

// Of the 500 features that are asked for, dark images have at least half. cv::ORB finds next to nothing there, though
// there is enough to see.
TEST(Aqorb_Quality, uniform_on_photographs_and_not_blind_in_the_dark)
{
    AQORB_NEEDS_DATA();
    const int IMAGES = 6;
    const Ptr<ORB> detectors[] = {AdaptiveQuadtreeORB::create(500), ORB::create(500)};
    double mean[2] = {0, 0}, occupancy[2] = {0, 0}, inTheDark[2] = {0, 0};
    size_t least = 500;
    for (const std::string set : {"bikes", "leuven", "bark", "trees", "ubc", "graf"})
    {
        double setMeans[2] = {0, 0};
        for (int i = 1; i <= IMAGES; i++)
        {
            SCOPED_TRACE(oxfordImage(set, i));
            const Mat image = imread(oxfordImage(set, i), IMREAD_COLOR), dark = image * 0.12;
            ASSERT_FALSE(image.empty());
            KeyPoints found[2], foundInTheDark[2];
            for (int d = 0; d < 2; d++)
            {
                detectors[d]->detect(image, found[d]);
                detectors[d]->detect(dark, foundInTheDark[d]);
                inTheDark[d] += double(foundInTheDark[d].size()) / (6 * IMAGES);
                setMeans[d] += aqorb::distributionUniformity(found[d], image.size()) / IMAGES;
                if (set != "graf")
                    occupancy[d] += aqorb::distributionOccupancy(found[d], image.size()) / (5 * IMAGES);
            }
            least = std::min(least, foundInTheDark[0].size());
            if (set == "bark" || set == "trees" || set == "ubc")
            {
                EXPECT_EQ(500u, found[0].size());
            }
        }
        if (set == "graf")
            continue;  // the paper measures the other five
        report("uniformity, n = 500, " + set, setMeans);
        EXPECT_LT(setMeans[0], setMeans[1]) << set;
        for (int d = 0; d < 2; d++)
            mean[d] += setMeans[d] / 5;
    }
    report("uniformity, n = 500, mean of five sets", mean);
    report("occupancy, n = 500, mean of five sets", occupancy);
    report("keypoints of 500 in dark images (x 0.12), mean", inTheDark);
    std::cout << "[ FIGURE   ] least: " << least << std::endl;
    EXPECT_LE(mean[0], 155);
    EXPECT_LT(mean[0], mean[1]);
    EXPECT_GT(occupancy[0], occupancy[1]);
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
    operator Ptr<FeatureDetector>() const { return AdaptiveQuadtreeORB::create(); }
    Ptr<FeatureDetector> operator()() const { return AdaptiveQuadtreeORB::create(); }
};

template <typename Case, typename... Values> std::vector<Case> caseOf(const Values&... values)
{
    return std::vector<Case>(dataFile("").empty() ? 0 : 1, Case(values...));
}

// The thresholds are cv::ORB's.
typedef String_FeatureDetector_Float_Float_t DetectorCase;
typedef String_FeatureDetector_DescriptorExtractor_Float_t DescriptorCase;
INSTANTIATE_TEST_CASE_P(Aqorb, DetectorRotationInvariance,
                        testing::ValuesIn(caseOf<DetectorCase>(TSUKUBA, Made(), 0.5f, 0.76f)));
INSTANTIATE_TEST_CASE_P(Aqorb, DetectorScaleInvariance,
                        testing::ValuesIn(caseOf<DetectorCase>(BIKES, Made(), 0.08f, 0.49f)));
INSTANTIATE_TEST_CASE_P(Aqorb, DescriptorRotationInvariance,
                        testing::ValuesIn(caseOf<DescriptorCase>(TSUKUBA, Made(), Made(), 0.99f)));

}  // namespace
}  // namespace opencv_test

#endif
