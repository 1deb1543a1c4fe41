// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#ifndef OPENCV_AQORB_HARRIS_ORIENTATION_HPP
#define OPENCV_AQORB_HARRIS_ORIENTATION_HPP

// Of pixels of a level the Harris response, and the moments that give the direction.

#include "types.hpp"

namespace cv
{
namespace aqorb
{

/** Computes the Harris response of cv::ORB, but over a block of 5x5 instead of 7x7 pixels: det - 0.04 trace^2
 of the sums over the block of the products of the Sobel derivatives. */
void harrisResponses(const Mat& image, const Corner* corners, size_t count, CornerResponse* responses);

//! Half widths of the rows 0 .. patchSize/2 of the circular patch, as in cv::ORB.
std::vector<int> circularPatch(int patchSize);

//! The factors of the pixels of a circular patch in its moments: u and v inside of the circle, 0 outside.
struct PatchWeights
{
    enum
    {
        MAX_RADIUS = 31,
        MAX_WIDTH = 64
    };
    short u[MAX_RADIUS + 1][MAX_WIDTH], v[MAX_RADIUS + 1][MAX_WIDTH];  //!< [|v|][u + radius]
    int radius, rowStep;
    int width;  //!< of the patch, filled up with zeros to whole vectors
};

//! A circular patch, prepared for any number of points. Its moments are summed over the middle row and every rowStep-th
//! row above and below it.
struct OrientationPatch
{
    explicit OrientationPatch(const std::vector<int>& halfWidths, int rowStep = 1);

    std::vector<int> halfWidths;
    int rowStep;
    AlignedVector<PatchWeights>
        weights;  //!< one; empty where the patch is too large for the kernel, or there are no vectors
};

struct Moments;

//! Sets the angles of points to the direction of the intensity centroid of the patch around them, as in cv::ORB.
void orientations(const Mat& image, const OrientationPatch& patch, FeaturePoint* points, size_t count);

//! Computes the moments of the patch around points.
void patchMoments(const Mat& image, const OrientationPatch& patch, const FeaturePoint* points, size_t count,
                  Moments* moments);

//! The direction of a vector in degrees from 0 to 360, by the source code of cv::fastAtan2. OpenCV's compiled function
//! rounds differently on some CPUs, where compilers fuse its multiplications and additions.
static CV_ALWAYS_INLINE float directionOf(float vectorX, float vectorY)
{
    const float DEGREES = float(180 / CV_PI);
    const float P1 = 0.9997878412794807f * DEGREES, P3 = -0.3258083974640975f * DEGREES;
    const float P5 = 0.1555786518463281f * DEGREES, P7 = -0.04432655554792128f * DEGREES;
    const float x = std::abs(vectorX), y = std::abs(vectorY);
    const float t = std::min(x, y) / (std::max(x, y) + float(DBL_EPSILON)), t2 = t * t;
    const float angle = (((P7 * t2 + P5) * t2 + P3) * t2 + P1) * t;
    // The angle, or whole - angle. Branches on a direction would be hard to predict.
    const auto mirrored = [](bool isMirrored, float whole, float v)
    { return whole * float(isMirrored) + v * float(1 - 2 * int(isMirrored)); };
    return mirrored(vectorY < 0, 360, mirrored(vectorX < 0, 180, mirrored(x < y, 90, angle)));
}

// ---- for the kernel: plain structs only, see types.hpp ---------------------------------------

//! The moments m10 and m01 of the patch around a pixel.
struct Moments
{
    int m10, m01;
};

}  // namespace aqorb
}  // namespace cv

#endif
