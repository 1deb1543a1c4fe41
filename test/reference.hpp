// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#ifndef OPENCV_AQORB_TEST_REFERENCE_HPP
#define OPENCV_AQORB_TEST_REFERENCE_HPP

#include "test_precomp.hpp"

#include "detector/selection.hpp"

#include <functional>

// The references are the specification of the module: the whole algorithm in its plainest form, without vectors of the
// CPU, tables or clever order. The detector and the matchers are tested to give the same bytes. A reader begins with
// detectAndCompute in reference_pipeline.cpp, which calls the steps in their order:
//
//   reference.cpp             threshold, equation (7); pyramid and quotas, equation (8); FAST, mesh of cells; Harris
//                             response, sub-pixel position, direction
//   reference_selection.cpp   the two selections: depth, equation (9), and Figure 2 of the paper; the ranked selection
//   reference_descriptor.cpp  blur, descriptor; and plain matchers
//   reference_refinement.cpp  the refinement of matches in double precision, from which positions differ by rounding;
//                             the test Aqorb_Growth.equals_the_plain_definition defines growth by it

namespace opencv_test
{
namespace reference
{

using aqorb::Corner;
using aqorb::LeafGrid;
using aqorb::RankRule;
using aqorb::Thresholds;

//! All parameters of AdaptiveQuadtreeORB with its defaults.
struct Settings
{
#define AQORB_FIELD(property, type, name, key, byDefault, ...) type name = type(byDefault);
    AQORB_PARAMETERS(AQORB_FIELD)
#undef AQORB_FIELD

    //! The distance that octaveSuppression stands for.
    double octaveSuppressionInUse() const;
    void set(AdaptiveQuadtreeORB& detector) const;
    Ptr<AdaptiveQuadtreeORB> create() const;
    //! cv::ORB with those of them that it has.
    Ptr<ORB> createOrb() const;
    //! All of them, for messages.
    std::string text() const;
};
//! Random values of all parameters that go together.
Settings randomSettings(RNG& rng);

//! What detectAndCompute must give.
Features detectAndCompute(const Mat& image, const Mat& mask, const Settings& settings);

//! A pixel by value, reflected outside of the image.
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

//! The corners of a level that pass the rules.
std::vector<Corner> findCorners(const Mat& image, const Mat& mask, const Rect& region, Thresholds thresholds,
                                bool suppressNear);

float harrisResponse(const Mat& image, int x, int y);

int quadtreeDepth(int quota);

//! A corner in its leaf. Of equal keys the lower y comes first, then the lower x, then the lower index.
struct LeafCorner
{
    int column, row;
    float x, y;
    float key;
    int index;
};

//! The indices of corners in the order of Figure 2, of a tree whose nodes are objects. Their keys are their responses.
std::vector<int> quadtreeOrder(const std::vector<LeafCorner>& corners, Size root, int set_kp, int D_max);

// The rule of RANKED_SELECTION.

//! Quotas of as many levels, in proportion to area * scale^1.25, level 0 half as much again.
std::vector<int> rankedQuotas(int nfeatures, const std::vector<Size>& regions,
                              const std::vector<float>& scales);
//! The leaves of a level's tree or, in a narrow one, of its trees side by side. They are at least 2 pixels a side.
LeafGrid rankedGrid(int quota, double usable, Size root, double density = 1);
//! The fourth power of a corner's strength, whose moment is in units of 2^16.
float strength(int fastScore, float response, bool isHarris, int64 m10, int64 m01);

/** The indices of corners in the order in which they are chosen.
 @param isUnmasked whether the mask allows a corner in the centre of a leaf
 @param strengthOf asked of the best corners of leaves that are representatives
 @param breaksTiesByKey whether the higher key comes first among equally strong ones; else the upper, then left leaf */
std::vector<int> rankedOrder(const std::vector<LeafCorner>& corners, const RankRule& rule,
                             const std::function<bool(int column, int row)>& isUnmasked,
                             const std::function<float(const LeafCorner&)>& strengthOf, double density,
                             bool breaksTiesByKey = false);
//! How many times as many leaves as 9 a feature has at a weight, and a leaf better neighbours than 3 that displace it.
double representativeDensity(double strengthWeight);
KeyPoints retainUniform(const KeyPoints& keypoints, Size imageSize, int npoints);

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
//! The moments of the orientation disc over the rows that are a multiple of step away from its centre.
void discMoments(const Mat& image, int x, int y, int patchSize, int step, int& m10, int& m01);
float orientation(const Mat& image, int x, int y, int patchSize);

//! cv::ORB's blur with fused multiply-add before it is rounded, CV_32FC1.
Mat blur(const Mat& image);
//! The same rounded, CV_8UC1.
Mat roundedBlur(const Mat& image);

std::vector<Point> descriptorPattern(int patchSize, int WTA_K);
void descriptor(const Mat& image, const Mat& blurred, Point center, float angle,
                const std::vector<Point>& pattern, int WTA_K, uchar* bytes);

}  // namespace reference

// Plain matchers.

typedef std::vector<std::vector<DMatch>> MatchLists;

//! All matches of a query that are allowed, the nearest first, then by image and by index.
std::vector<DMatch> referenceMatches(const Mat& query, int row, const std::vector<Mat>& images,
                                     const std::vector<Mat>& masks, int normType);

//! Whether a query may be matched with a train descriptor.
typedef std::function<bool(int, int)> Allowed;

//! What matchArrays documents.
struct ReferenceTests
{
    double ratio;
    bool crossCheck;
    int maxDistance, normType;
};
std::vector<DMatch> referenceTested(const Mat& query, const Mat& train, const ReferenceTests& tests,
                                    const Allowed& isAllowed);
//! Whether two finite positions differ by at most `reach` in each coordinate, without rounding.
bool isInWindow(const Point2f& a, const Point2f& b, Size2f reach);
//! What matchGuided documents. tests.crossCheck does not count, and maxDistance is not -1.
std::vector<DMatch> referenceGuided(const Mat& query, const KeyPoints& queryKeypoints, const Mat& train,
                                    const KeyPoints& trainKeypoints, const Matx33d& F, double reach,
                                    const ReferenceTests& tests);

/** Random descriptors. Some are copies of others, and of some only a few bits differ, so that many distances are equal.
 They may be a part of a larger matrix. */
Mat randomDescriptors(RNG& rng, int rows, int bytes);

::testing::AssertionResult sameMatches(const MatchLists& a, const MatchLists& b);
//! Whether arrays of pairs and distances hold these matches.
::testing::AssertionResult isMatchedAs(const std::vector<DMatch>& expected, const Mat& pairs,
                                       const Mat& distances);

//! Whether two lists hold the same corners in the same order.
::testing::AssertionResult sameCorners(const std::vector<aqorb::Corner>& a,
                                       const std::vector<aqorb::Corner>& b);

//! Runs the code on the baseline kernels until it goes out of scope.
class WithoutOptimization
{
public:
    WithoutOptimization() : before(useOptimized()) { setUseOptimized(false); }
    ~WithoutOptimization() { setUseOptimized(before); }
    WithoutOptimization(const WithoutOptimization&) = delete;

private:
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
