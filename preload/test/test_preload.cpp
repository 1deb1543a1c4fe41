// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// Run with libaqorb_preload.so preloaded.

#include <gtest/gtest.h>

#include "../../test/scenes.hpp"

#include <opencv2/aqorb.hpp>

#include <cstdlib>
#include <locale>
#include <string>
#include <vector>

namespace
{

using namespace cv;
using aqorb::AdaptiveQuadtreeORB;

//! Sets an environment variable during its lifetime.
class Variable
{
public:
    Variable(const char* name_, const char* value) : name(name_) { setenv(name, value, 1); }
    ~Variable() { unsetenv(name); }

private:
    const char* name;
};

//! OpenCV's own detector, even with the library preloaded.
Ptr<ORB> opencvORB(int nfeatures, int WTA_K = 2, int patchSize = 31)
{
    const Variable disable("AQORB_DISABLE", "1");
    return ORB::create(nfeatures, 1.2f, 8, 31, 0, WTA_K, ORB::HARRIS_SCORE, patchSize);
}

Ptr<AdaptiveQuadtreeORB> ours(const Ptr<ORB>& orb)
{
    const Ptr<AdaptiveQuadtreeORB> result = orb.dynamicCast<AdaptiveQuadtreeORB>();
    if (!result)
        CV_Error(Error::StsError, "cv::ORB::create gave " + orb->getDefaultName());
    return result;
}

std::string messageOf(const char* variable, const char* value)
{
    const Variable set(variable, value);
    try
    {
        ORB::create();
    }
    catch (const Exception& e)
    {
        return e.err;
    }
    return "no exception";
}

//! The name and all properties.
String stateOf(const Ptr<ORB>& orb)
{
    FileStorage file(".yml", FileStorage::WRITE | FileStorage::MEMORY);
    orb->write(file);
    return orb->getDefaultName() + "\n" + file.releaseAndGetString();
}

TEST(Aqorb_Preload, gives_our_detector_with_the_callers_parameters_and_our_own_defaults)
{
    const Ptr<ORB> expected = AdaptiveQuadtreeORB::create(321, 1.3f, 5, 24, 1, 3, ORB::FAST_SCORE, 25, 11);
    EXPECT_EQ(stateOf(expected), stateOf(ORB::create(321, 1.3f, 5, 24, 1, 3, ORB::FAST_SCORE, 25, 11)));
}

TEST(Aqorb_Preload, sets_properties_from_the_environment)
{
    const Variable edge("AQORB_EDGE_THRESHOLD", "16"), adaptive("AQORB_ADAPTIVE_THRESHOLD", "0"),
        ratio("AQORB_MIN_THRESHOLD_RATIO", "2.5"), selection("AQORB_SELECTION_TYPE", " quadtree"),
        weight("AQORB_STRENGTH_WEIGHT", "0.3"), radius("AQORB_RANK_RADIUS", "2.5"),
        octave("AQORB_OCTAVE_SUPPRESSION", " 0.25 "), subPixel("AQORB_SUB_PIXEL", "0");
    const Ptr<AdaptiveQuadtreeORB> expected = AdaptiveQuadtreeORB::create(100, 1.2f, 8, 16);
    expected->setAdaptiveThreshold(false);
    expected->setMinThresholdRatio(2.5);
    expected->setSelectionType(AdaptiveQuadtreeORB::QUADTREE_SELECTION);
    expected->setStrengthWeight(0.3);
    expected->setRankRadius(2.5);
    expected->setOctaveSuppression(0.25);
    expected->setSubPixel(false);
    EXPECT_EQ(stateOf(expected), stateOf(ORB::create(100, 1.2f, 8, 40)));

    const Variable otherSelection("AQORB_SELECTION_TYPE", "ranked");
    EXPECT_EQ(AdaptiveQuadtreeORB::RANKED_SELECTION, ours(ORB::create())->getSelectionType());
}

struct DecimalComma : std::numpunct<char>
{
    char do_decimal_point() const override { return ','; }
};

TEST(Aqorb_Preload, reads_numbers_in_any_locale)
{
    const std::locale before = std::locale::global(std::locale(std::locale::classic(), new DecimalComma));
    const Variable octave("AQORB_OCTAVE_SUPPRESSION", "0.25");
    EXPECT_EQ(0.25, ours(ORB::create())->getOctaveSuppression());
    std::locale::global(before);
}

TEST(Aqorb_Preload, takes_an_empty_variable_for_none)
{
    const Variable edge("AQORB_EDGE_THRESHOLD", ""), disable("AQORB_DISABLE", "");
    EXPECT_EQ(31, ours(ORB::create())->getEdgeThreshold());
}

TEST(Aqorb_Preload, names_the_variable_of_a_bad_value)
{
    const char* const cases[][3] = {
        {"AQORB_EDGE_THRESHOLD", "sixteen", " must be a whole number, got \"sixteen\""},
        {"AQORB_EDGE_THRESHOLD", "16.5", " must be a whole number, got \"16.5\""},
        {"AQORB_EDGE_THRESHOLD", "99999999999", " must be a whole number, got \"99999999999\""},
        {"AQORB_MIN_THRESHOLD_RATIO", "nan", " must be a number, got \"nan\""},
        {"AQORB_SUB_PIXEL", "yes", " must be 0 or 1, got \"yes\""},
        {"AQORB_SELECTION_TYPE", "1", " must be ranked or quadtree, got \"1\""},
        {"AQORB_SELECTION_TYPE", "quadtree ranked", " must be ranked or quadtree, got \"quadtree ranked\""},
        {"AQORB_STRENGTH_WEIGHT", "1001", ": strengthWeight must be from 0 to 1000, got 1001"},
        {"AQORB_RANK_RADIUS", "-1", ": rankRadius must be from 0 to 16, got -1"},
        {"AQORB_DISABLE", "2", " must be 0 or 1, got \"2\""}};
    for (const auto& each : cases)
        EXPECT_EQ(std::string(each[0]) + each[2], messageOf(each[0], each[1]));
}

TEST(Aqorb_Preload, gives_opencv_detector_where_disabled)
{
    const Ptr<ORB> orb = opencvORB(123);
    EXPECT_EQ("Feature2D.ORB", orb->getDefaultName());
    EXPECT_EQ(123, orb->getMaxFeatures());

    const Variable disable("AQORB_DISABLE", "0");
    EXPECT_NO_THROW(ours(ORB::create()));
}

TEST(Aqorb_Preload, notices_once_and_on_request_only)
{
    const auto output = []
    {
        testing::internal::CaptureStderr();
        ORB::create();
        return testing::internal::GetCapturedStderr();
    };
    EXPECT_EQ("", output());
    const Variable verbose("AQORB_VERBOSE", "1");
    {
        const Variable disable("AQORB_DISABLE", "1");
        EXPECT_EQ("", output());
    }
    const Variable known("AQORB_SUB_PIXEL", "0"), misspelt("AQORB_SUBPIXEL", "0");
    const std::string notice = output();
    EXPECT_EQ(0u, notice.find("aqorb: cv::ORB::create gives AdaptiveQuadtreeORB (edgeThreshold 31)\n"));
    EXPECT_NE(std::string::npos, notice.find("\naqorb: AQORB_SUBPIXEL is no variable of this library\n"));
    EXPECT_EQ(std::string::npos, notice.find("AQORB_SUB_PIXEL"));
    EXPECT_EQ(std::string::npos, notice.find("AQORB_VERBOSE"));
    EXPECT_EQ("", output());
}

// A library that called cv::ORB for these descriptors would call itself forever.
TEST(Aqorb_Preload, computes_descriptors_of_every_kind_itself)
{
    const Mat image = opencv_test::makeScene(Size(640, 480));
    for (int WTA_K : {2, 3, 4})
    {
        for (int patchSize : {31, 41})
        {
            SCOPED_TRACE(testing::Message() << "WTA_K " << WTA_K << ", patchSize " << patchSize);
            const Ptr<ORB> orb = ORB::create(300, 1.2f, 8, 31, 0, WTA_K, ORB::HARRIS_SCORE, patchSize);
            ASSERT_NO_THROW(ours(orb));
            std::vector<KeyPoint> keypoints;
            Mat descriptors, expected;
            orb->detectAndCompute(image, noArray(), keypoints, descriptors);
            EXPECT_EQ(300u, keypoints.size());
            opencvORB(300, WTA_K, patchSize)->compute(image, keypoints, expected);
            ASSERT_EQ(expected.size(), descriptors.size());
            // Without fused multiply-add cv::ORB's blur differs in a pixel here and there.
            EXPECT_LE(norm(expected, descriptors, NORM_HAMMING), checkHardwareSupport(CV_CPU_FMA3) ? 0 : 30);
        }
    }
}

}  // namespace
