// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#ifndef OPENCV_AQORB_DESCRIPTOR_HPP
#define OPENCV_AQORB_DESCRIPTOR_HPP

#include "aligned.hpp"
#include "blur.hpp"
#include "types.hpp"

namespace cv
{
namespace aqorb
{

//! The points that rBRIEF compares, WTA_K for each test, in the order of the tests, as cv::ORB draws them.
std::vector<Point> descriptorPattern(int patchSize, int WTA_K);

//! The 256 tests of a descriptor with WTA_K 2. A bit is 1 where point 0 is darker than point 1.
struct PairTests
{
    enum
    {
        COUNT = 256
    };
    float x[2][COUNT], y[2][COUNT];  //!< [point of the pair][test]
};

const int DESCRIPTOR_BYTES = 32;

//! A pattern, prepared for any number of descriptors.
struct DescriptorTests
{
    DescriptorTests(const std::vector<Point>& pattern, int WTA_K);

    std::vector<Point> pattern;
    int WTA_K;
    int reach;  //!< how far from the keypoint the descriptor may read
    std::vector<int>
        halfHeights;  //!< of the disc that it may read, by the horizontal distance from the keypoint
    AlignedVector<PairTests>
        pairs;  //!< one, for the kernel; empty where WTA_K is not 2 or the reach is too far
    //! How much margin the blurred rows must have.
    int margin() const { return blurMargin(pairs.empty() ? 0 : reach); }
};

/** The 32-byte descriptors at pixels of a level, equal to those of cv::ORB.
 @param image the level
 @param blurred its approximateBlur, at least the discs around the points, as far as tests.margin outside of the level
 @param points where descriptors are taken, and in which direction
 @param count number of points
 @param tests the pattern
 @param descriptors gets one descriptor a row
 @param step bytes from one row to the next */
void computeDescriptors(const Mat& image, const BlurredRows& blurred, const FeaturePoint* points,
                        size_t count, const DescriptorTests& tests, uchar* descriptors, size_t step);

}  // namespace aqorb
}  // namespace cv

#endif
