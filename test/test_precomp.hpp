// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#ifndef OPENCV_AQORB_TEST_PRECOMP_HPP
#define OPENCV_AQORB_TEST_PRECOMP_HPP

// One set of sources for two test runners: OpenCV's ts inside OpenCV's build, GoogleTest elsewhere. The
// tests keep to the macros that both have, and to C++11.

#ifdef __OPENCV_TESTS

#include "opencv2/ts.hpp"
// Leaves a test that cannot run here; it counts as skipped.
#define AQORB_SKIP(reason) throw cvtest::SkipTestException(reason)
#ifndef INSTANTIATE_TEST_SUITE_P  // the GoogleTest of OpenCV's ts is older
#define INSTANTIATE_TEST_SUITE_P INSTANTIATE_TEST_CASE_P
#endif

#else

#include <gtest/gtest.h>
#include <opencv2/core.hpp>
namespace opencv_test
{
using namespace cv;
}
#define AQORB_SKIP(reason) GTEST_SKIP() << (reason)

#endif

#include "opencv2/aqorb.hpp"
#include "opencv2/imgcodecs.hpp"
#include "opencv2/imgproc.hpp"

#include "scenes.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <functional>
#include <limits>
#include <string>
#include <vector>

namespace opencv_test
{

using aqorb::AdaptiveQuadtreeORB;

typedef std::vector<KeyPoint> KeyPoints;

const float ENDLESS = std::numeric_limits<float>::infinity(),
            NOT_A_NUMBER = std::numeric_limits<float>::quiet_NaN();

//! What detectAndCompute gives for one image.
struct Features
{
    KeyPoints keypoints;
    Mat descriptors;
};

//! Sets the number of OpenCV's threads until it goes out of scope.
class Threads
{
public:
    explicit Threads(int count) : before(getNumThreads()) { setNumThreads(count); }
    ~Threads() { setNumThreads(before); }

private:
    const int before;
};

Features detectAndCompute(Feature2D& detector, InputArray image, InputArray mask = noArray());

//! The message of the exception that a call raises; empty if it raises none.
std::string messageOf(const std::function<void()>& call);
//! Whether a message says what a parameter must be, and after that the value that it got.
::testing::AssertionResult names(const std::string& message, const std::string& name,
                                 const std::string& value);

//! The bytes of the heap in use, of the GNU C library; 0 elsewhere.
long long heapInUse();
//! Whether they are known. Sanitizers, for example, have a heap of their own.
bool isHeapKnown();

//! A scene, blurred, dark or enlarged, noise or dots.
Mat randomImage(RNG& rng, Size size);
//! A mask of random pixels, dots, lines or rectangles that are usable, or of all others.
Mat randomMask(RNG& rng, Size size);

//! A response of one of the kinds 0 to 4: odd ones, some odd, many equal, all equal, or of any magnitude.
float randomResponse(RNG& rng, int kind);

//! Whether all fields of all keypoints have the same bytes.
::testing::AssertionResult sameKeypoints(const KeyPoints& a, const KeyPoints& b);
//! Whether two matrices have the same size, type and bytes; both may be empty.
::testing::AssertionResult sameMat(const Mat& a, const Mat& b);
::testing::AssertionResult sameFeatures(const Features& a, const Features& b);
//! Whether a detector finds these features, and computes the same descriptors for their keypoints.
::testing::AssertionResult finds(Feature2D& detector, const Mat& image, const Mat& mask,
                                 const Features& expected);

/** A copy of which each row begins so many bytes behind a multiple of 64. It is a part of a larger matrix that
 goes on around it with the inverse of what borders are to be taken for, BORDER_REFLECT_101. */
Mat atOffset(const Mat& image, int offset);
//! Whether the elements around a part of a larger matrix all have the value.
bool isAround(const Mat& part, int value);

//! Path of a file of opencv_extra's testdata; empty where OPENCV_TEST_DATA_PATH is not set.
std::string dataFile(const std::string& name);
//! Path of image `index` (1 to 6) of an Oxford set: bikes, leuven, bark, trees, ubc or graf.
std::string oxfordImage(const std::string& set, int index);
//! Grey photographs of all kinds; needs opencv_extra's images.
std::vector<Mat> photographs();

//! Whether the installed cv::ORB blurs as with fused multiply-add on this CPU, as this module does. Else descriptors
//! may differ.
bool orbBlursWithFMA();

}  // namespace opencv_test

//! Expects that a call raises an exception that names a parameter and its value.
#define AQORB_BAD(name, value, ...) EXPECT_TRUE(names(messageOf([&] { __VA_ARGS__; }), name, value))

// Begins a test that needs opencv_extra's images.
#define AQORB_NEEDS_DATA()                                  \
    do                                                      \
    {                                                       \
        if (::opencv_test::dataFile("").empty())            \
            AQORB_SKIP("OPENCV_TEST_DATA_PATH is not set"); \
    } while (false)

#endif
