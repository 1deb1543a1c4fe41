// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#ifndef OPENCV_AQORB_TEST_REFERENCE_HPP
#define OPENCV_AQORB_TEST_REFERENCE_HPP

#include "test_precomp.hpp"

#include "types.hpp"

// The algorithm once more, as plainly as it can be written: no vectors, no tables, no clever order.
// What is slow here is so on purpose; only the results are of interest.

namespace opencv_test
{
namespace reference
{

using aqorb::stages::Corner;
using aqorb::stages::LeafPoint;
using aqorb::stages::RankedCorner;
using aqorb::stages::Thresholds;

//! All parameters of AdaptiveQuadtreeORB with its defaults.
struct Settings
{
    int nfeatures = 500;
    float scaleFactor = 1.2f;
    int nlevels = 8;
    int edgeThreshold = 16;
    int firstLevel = 0;
    int WTA_K = 2;
    ORB::ScoreType scoreType = ORB::HARRIS_SCORE;
    int patchSize = 31;
    int fastThreshold = 20;
    bool adaptiveThreshold = true;
    double minThresholdRatio = 4;
    int cellSize = 35;
    int maxDepth = -1;
    AdaptiveQuadtreeORB::SelectionType selectionType = AdaptiveQuadtreeORB::RANKED_SELECTION;
    double strengthWeight = 0.2;
    double rankRadius = 1;
    double octaveSuppression = -1;
    bool subPixel = true;

    //! The distance that octaveSuppression stands for.
    double octaveSuppressionInUse() const;
    Ptr<AdaptiveQuadtreeORB> create() const;
};

//! What detectAndCompute must give.
Features detectAndCompute(const Mat& image, const Mat& mask, const Settings& settings);

//! A pixel by value; those outside are reflected.
int pixel(const Mat& image, int x, int y);

//! Equation (7), unrounded.
double varianceOverMean(const Mat& gray, const Mat& mask);
Thresholds thresholds(double v, bool adaptive, int fastThreshold, double minRatio);

float levelScale(int level, int firstLevel, double scaleFactor);
Size levelSize(Size imageSize, float scale);
std::vector<int> quotas(int nfeatures, double scaleFactor, int nlevels);
//! The levels of cv::ORB's pyramid.
std::vector<Mat> pyramid(const Mat& gray, int nlevels, int firstLevel, double scaleFactor);
//! A level's mask from the one it is made from.
Mat resizeMask(const Mat& mask, Size size);

int cornerScore(const Mat& image, int x, int y);
std::vector<Corner> fastCorners(const Mat& image, const Rect& region, int threshold);

//! Corners of a level by what the rules make of them.
struct Corners
{
    std::vector<Corner> kept, suppressed, weak;
};
Corners findCorners(const Mat& image, const Mat& mask, const Rect& region, Thresholds thresholds,
                    int cellSize, bool suppressNear);

float harrisResponse(const Mat& image, int x, int y);

int quadtreeDepth(int quota);
//! Morton code by single bits.
unsigned leafCode(unsigned column, unsigned row);
//! The whole balanced sequence, from its definition.
std::vector<LeafPoint> balancedSequence(const std::vector<LeafPoint>& points, int depth);

Point2f position(int x, int y, Point2d d, Size imageSize, Size levelSize, float scale, int border,
                 bool subPixel);
/** The position of a pixel's centre if it is not masked, else, with subPixel, the nearest centre of a pixel of the
 image that is not, if a keypoint there belongs to the pixel. False: there is none. */
bool usablePosition(const Mat& mask, int x, int y, Size levelSize, float scale, int border, bool subPixel,
                    Point2f& found);
Point2d subPixelOffset(const Mat& image, int x, int y);

//! cv::fastAtan2 with or without fused multiply-add.
float arctangent(float y, float x, bool fused = false);
/** Whether OpenCV was compiled with fused multiply-add, as for AArch64. Its angles then differ from ours in the last
 bit, and cv::ORB may round a turned test point to another pixel. */
bool opencvFusesMultiplyAdd();
float orientation(const Mat& image, int x, int y, int patchSize);

//! cv::ORB's blur with fused multiply-add before it is rounded, CV_32FC1.
Mat blur(const Mat& image);
//! The same rounded, CV_8UC1.
Mat roundedBlur(const Mat& image);

std::vector<Point> descriptorPattern(int patchSize, int WTA_K);
void descriptor(const Mat& image, const Mat& blurred, Point center, float angle,
                const std::vector<Point>& pattern, int WTA_K, uchar* bytes);

}  // namespace reference

//! Whether two lists hold the same corners in the same order.
::testing::AssertionResult sameCorners(const std::vector<aqorb::stages::Corner>& a,
                                       const std::vector<aqorb::stages::Corner>& b);

//! Runs the code on the baseline kernels until it goes out of scope.
class WithoutOptimization
{
public:
    WithoutOptimization() : before(useOptimized()) { setUseOptimized(false); }
    ~WithoutOptimization() { setUseOptimized(before); }

private:
    WithoutOptimization(const WithoutOptimization&);
    WithoutOptimization& operator=(const WithoutOptimization&);
    const bool before;
};

/** Calls check(copy, offset) with the image atOffset 0 to 63, on the kernels for this CPU and on the baseline's.
 The first failure ends it. */
template <typename Check> void atEveryOffset(const Mat& image, const Check& check)
{
    for (int offset = 0; offset < 64 && !::testing::Test::HasFailure(); offset++)
    {
        SCOPED_TRACE(format("offset %d", offset));
        const Mat copy = atOffset(image, offset);
        check(copy, offset);
        WithoutOptimization baseline;
        check(copy, offset);
    }
}

const int MAX_WIDTH = 130;  // of images that go through all widths: several vectors and a rest

}  // namespace opencv_test

#endif
