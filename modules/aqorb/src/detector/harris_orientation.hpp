// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#ifndef OPENCV_AQORB_HARRIS_ORIENTATION_HPP
#define OPENCV_AQORB_HARRIS_ORIENTATION_HPP

// Harris responses and intensity moments at pixels of a level.

#include "detector/types.hpp"

namespace cv
{
namespace aqorb
{

/** Computes the Harris response of cv::ORB over a block of 5x5 instead of 7x7 pixels: det - 0.04 trace^2 of the matrix
 of summed products of Sobel derivatives. */
void harrisResponses(const Mat& image, const Corner* corners, size_t count, CornerResponse* responses);

//! Half widths of the rows 0 .. patchSize/2 of the circular patch, as in cv::ORB.
std::vector<int> circularPatch(int patchSize);

//! Weights of the pixels in the moments: u and v inside the circular patch, 0 outside.
struct PatchWeights
{
    enum
    {
        MAX_RADIUS = 31,
        MAX_WIDTH = 64
    };
    short u[MAX_RADIUS + 1][MAX_WIDTH], v[MAX_RADIUS + 1][MAX_WIDTH];  //!< [|v|][u + radius]
    int radius, rowStep;
    int width;  //!< of the patch, zero-padded to whole vectors
};

//! Circular patch, prepared for any number of points. Its moments sum over the middle row and each rowStep-th row above
//! and below.
struct OrientationPatch
{
    explicit OrientationPatch(const std::vector<int>& halfWidths, int rowStep = 1);

    std::vector<int> halfWidths;
    int rowStep;
    //! One element; empty if the patch is too large for the kernel, or without vectors.
    AlignedVector<PatchWeights> weights;
};

struct Moments;

//! Sets the angle of each point to the direction of its patch's intensity centroid, as cv::ORB does.
void orientations(const Mat& image, const OrientationPatch& patch, FeaturePoint* points, size_t count);

//! Computes the moments of the patch around points.
void patchMoments(const Mat& image, const OrientationPatch& patch, const FeaturePoint* points, size_t count,
                  Moments* moments);

// ---- for the kernel: plain structs only, see simd_compat.hpp ---------------------------------

//! Moments m10 and m01 of the patch around a pixel.
struct Moments
{
    int m10, m01;
};

}  // namespace aqorb
}  // namespace cv

#endif
