// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// Descriptors of cv::ORB. The exact blur decides the tests that the approximate blur leaves open.

#ifndef OPENCV_AQORB_DESCRIPTOR_HPP
#define OPENCV_AQORB_DESCRIPTOR_HPP

#include "detector/types.hpp"
#include "detector/blur.hpp"

#include <opencv2/aqorb/features.hpp>

namespace cv
{
namespace aqorb
{

//! Points of rBRIEF's tests, WTA_K for each test, as cv::ORB draws them.
std::vector<Point> descriptorPattern(int patchSize, int WTA_K);

//! The 256 tests of a descriptor with WTA_K 2. A bit is 1 if point 0 is darker than point 1.
struct PairTests
{
    enum
    {
        COUNT = 256
    };
    float x[2 * COUNT], y[2 * COUNT];  //!< the first points of all tests, then the second points
};

//! Pattern, prepared for any number of descriptors.
struct DescriptorTests
{
    DescriptorTests(const std::vector<Point>& pattern, int WTA_K);

    std::vector<Point> pattern;
    int WTA_K;
    int reach;                     //!< largest distance from the keypoint at which a descriptor reads
    std::vector<int> halfHeights;  //!< half height of the disc of radius `reach`, by horizontal distance
    //! One element for the kernel; empty if WTA_K is not 2 or the reach is too far.
    AlignedVector<PairTests> pairs;
    //! Margin that the blurred rows need.
    int margin() const { return blurMargin(pairs.empty() ? 0 : reach); }
};

/** Computes the 32-byte descriptors of cv::ORB at pixels of a level.
 @param image the level
 @param blurred approximateBlur of the level, at least in the discs around the points, with tests.margin() around it
 @param points pixels and directions
 @param count number of points
 @param tests the pattern
 @param descriptors receives one descriptor per row
 @param step bytes from row to row
 @param mayStop stops early when so many tests need exactBlur that blurring all pixels exactly is faster
 @return number of points with a descriptor */
size_t computeDescriptors(const Mat& image, const BlurredRows& blurred, const FeaturePoint* points,
                          size_t count, const DescriptorTests& tests, uchar* descriptors, size_t step,
                          bool mayStop = false);

}  // namespace aqorb
}  // namespace cv

#endif
