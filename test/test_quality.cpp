// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "test_precomp.hpp"

#include "matches.hpp"

#include "opencv2/aqorb/geometry.hpp"

#include <iostream>

// What the detector is for, measured on real images beside cv::ORB: keypoints spread uniformly, more of the
// scene matched, better homographies, dark images. The figures are printed.

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

//! Prints one measure of both detectors.
void report(const std::string& figure, double ours, double orb)
{
    std::cout << format("[ FIGURE   ] %-52s %8.3f  cv::ORB %8.3f", figure.c_str(), ours, orb) << std::endl;
}

TEST(Aqorb_Quality, uniform_on_photographs)
{
    AQORB_NEEDS_DATA();
    const Ptr<ORB> ours = AdaptiveQuadtreeORB::create(500), orb = ORB::create(500);
    double oursSum = 0, orbSum = 0, oursOccupancy = 0, orbOccupancy = 0;
    for (int s = 0; s < SETS_OF_UNIFORMITY; s++)
    {
        double oursSet = 0, orbSet = 0;
        for (int i = 1; i <= IMAGES; i++)
        {
            const Mat image = readColour(SETS[s], i);
            ASSERT_FALSE(image.empty());
            const KeyPoints a = detect(*ours, image), b = detect(*orb, image);
            oursSet += aqorb::distributionUniformity(a, image.size()) / IMAGES;
            orbSet += aqorb::distributionUniformity(b, image.size()) / IMAGES;
            oursOccupancy += aqorb::distributionOccupancy(a, image.size()) / IMAGES / SETS_OF_UNIFORMITY;
            orbOccupancy += aqorb::distributionOccupancy(b, image.size()) / IMAGES / SETS_OF_UNIFORMITY;
        }
        report(std::string("uniformity, n = 500, ") + SETS[s], oursSet, orbSet);
        EXPECT_LT(oursSet, orbSet) << SETS[s];
        oursSum += oursSet;
        orbSum += orbSet;
    }
    const double oursMean = oursSum / SETS_OF_UNIFORMITY, orbMean = orbSum / SETS_OF_UNIFORMITY;
    report("uniformity, n = 500, mean of five sets", oursMean, orbMean);
    report("occupancy, n = 500, mean of five sets", oursOccupancy, orbOccupancy);
    EXPECT_LE(oursMean, 155);
    EXPECT_LT(oursMean, orbMean);
    EXPECT_GT(oursOccupancy, orbOccupancy);
}

TEST(Aqorb_Quality, gives_all_features_asked_for)
{
    AQORB_NEEDS_DATA();
    for (const char* set : {"bark", "trees", "ubc"})
    {
        for (int i = 1; i <= IMAGES; i++)
        {
            SCOPED_TRACE(std::string(set) + " " + std::to_string(i));
            const Mat image = readColour(set, i);
            ASSERT_FALSE(image.empty());
            EXPECT_EQ(size_t(500), detect(*AdaptiveQuadtreeORB::create(500), image).size());
        }
    }
}

TEST(Aqorb_Quality, finds_features_in_dark_images)
{
    AQORB_NEEDS_DATA();
    const int nfeatures = 500;
    const Ptr<ORB> ours = AdaptiveQuadtreeORB::create(nfeatures), orb = ORB::create(nfeatures);
    double oursSum = 0, orbSum = 0;
    size_t oursLeast = nfeatures;
    int images = 0;
    for (const char* set : SETS)
    {
        for (int i = 1; i <= IMAGES; i++)
        {
            SCOPED_TRACE(std::string(set) + " " + std::to_string(i));
            Mat dark;
            readColour(set, i).convertTo(dark, CV_8U, 0.12);
            ASSERT_FALSE(dark.empty());
            const KeyPoints a = detect(*ours, dark), b = detect(*orb, dark);
            oursSum += double(a.size());
            orbSum += double(b.size());
            oursLeast = std::min(oursLeast, a.size());
            images++;
            // cv::ORB finds next to nothing in these images, though there is enough to see.
            EXPECT_GE(a.size(), size_t(nfeatures / 2)) << "cv::ORB: " << b.size();
        }
    }
    report("keypoints of 500 in dark images (x 0.12), mean", oursSum / images, orbSum / images);
    std::cout << "[ FIGURE   ] least: " << oursLeast << std::endl;
}

#ifdef AQORB_HAVE_GEOMETRY

//! Area under the curve of the share of errors below a limit, for limits from 0 to `limit`; 1 is perfect.
double areaUnderCurve(const std::vector<double>& errors, double limit)
{
    double sum = 0;
    for (double error : errors)
        sum += std::max(0., 1 - error / limit);
    return sum / double(errors.size());
}

TEST(Aqorb_Quality, matches_more_of_the_scene)
{
    AQORB_NEEDS_DATA();
    const int seeds = 7;
    const Ptr<ORB> detectors[] = {AdaptiveQuadtreeORB::create(1000), ORB::create(1000)};
    int distinct[2] = {0, 0}, pairs = 0;
    std::vector<double> errors[2];
    for (const char* set : SETS)
    {
        int distinctOfSet[2] = {0, 0};
        for (int d = 0; d < 2; d++)
        {
            const Mat first = readColour(set, 1);
            ASSERT_FALSE(first.empty());
            const Features features = detectAndCompute(*detectors[d], first);
            for (int i = 2; i <= IMAGES; i++)
            {
                const Mat homography = oxfordHomography(set, i), image = readColour(set, i);
                ASSERT_FALSE(homography.empty() || image.empty());
                const Matches matches = matchFeatures(features, detectAndCompute(*detectors[d], image));
                distinctOfSet[d] += int(distinctCorrectMatches(matches, homography).size());
                for (int seed = 1; seed <= seeds; seed++)
                    errors[d].push_back(homographyError(matches, homography, first.size(), seed * 7919));
                pairs += d;
            }
            distinct[d] += distinctOfSet[d];
        }
        report(std::string("distinct correct matches, n = 1000, ") + set, distinctOfSet[0] / 5.,
               distinctOfSet[1] / 5.);
    }
    report("distinct correct matches, n = 1000, mean of pairs", double(distinct[0]) / pairs,
           double(distinct[1]) / pairs);
    const double ours = areaUnderCurve(errors[0], 5), orb = areaUnderCurve(errors[1], 5);
    report("homography AUC@5 px, n = 1000, mean of pairs", ours, orb);
    EXPECT_GT(distinct[0], distinct[1]);
    EXPECT_GT(ours, orb);
}

#endif  // AQORB_HAVE_GEOMETRY

}  // namespace
}  // namespace opencv_test
