// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "test_precomp.hpp"

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

// The test pairs keypoints in the order of the output, which is by levels: lower thresholds than cv::ORB's 0.5 and 0.76.
INSTANTIATE_TEST_CASE_P(Aqorb, DetectorRotationInvariance,
                        testing::ValuesIn(detectorCase(TSUKUBA, AdaptiveQuadtreeORB::create(), 0.33f,
                                                       0.65f)));
// As for cv::ORB.
INSTANTIATE_TEST_CASE_P(Aqorb, DetectorScaleInvariance,
                        testing::ValuesIn(detectorCase(BIKES, AdaptiveQuadtreeORB::create(), 0.08f, 0.49f)));
INSTANTIATE_TEST_CASE_P(Aqorb, DescriptorRotationInvariance,
                        testing::ValuesIn(descriptorCase(TSUKUBA, 0.99f)));

}  // namespace
}  // namespace opencv_test

#endif
