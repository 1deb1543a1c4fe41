// This file is part of the aqorb project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.

#ifndef OPENCV_AQORB_TEST_REFERENCE_HPP
#define OPENCV_AQORB_TEST_REFERENCE_HPP

#include "test_precomp.hpp"

namespace opencv_test
{

//! The parameters of AdaptiveQuadtreeORB, for the reference.
struct ReferenceParameters
{
    explicit ReferenceParameters(const AdaptiveQuadtreeORB& detector);

    int nfeatures;
    double scaleFactor;
    int nlevels, edgeThreshold, firstLevel, WTA_K;
    bool isHarris;
    int patchSize, fastThreshold;
    bool adaptiveThreshold;
    double minThresholdRatio;
    int cellSize, maxDepth;
    double octaveSuppression;
    bool subPixel;
};

/** The whole algorithm in the plainest terms: the judge of every fast path. Written from the definition,
 without the module's stages. */
Features referenceFeatures(const Mat& image, const Mat& mask, const ReferenceParameters& parameters);

//! The FAST score by its definition; one less than it is cv::FAST's response.
int referenceScore(const Mat& image, Point p);
//! cv::ORB's blur by its definition, before it is rounded to 8 bits; std::fma throughout.
float referenceBlur(const Mat& image, Point p);
//! cv::ORB's Harris response, over a 5x5 block.
float referenceHarris(const Mat& image, int x, int y);
//! cv::ORB's direction of a keypoint.
float referenceAngle(const Mat& image, int x, int y, int patchSize);
//! The pixel, reflected into the image.
int reflectedPixel(const Mat& image, int x, int y);
//! The balanced sequence by its definition: indices of the points, best first.
std::vector<int> referenceSequence(const std::vector<aqorb::stages::LeafPoint>& points, int depth);

}  // namespace opencv_test

#endif
