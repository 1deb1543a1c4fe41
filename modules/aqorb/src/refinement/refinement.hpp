// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// Refinement of matches, which growth begins with.

#ifndef OPENCV_AQORB_SRC_REFINEMENT_HPP
#define OPENCV_AQORB_SRC_REFINEMENT_HPP

#include "refinement/alignment.hpp"

namespace cv
{
namespace aqorb
{

//! Arguments of refineMatches and growMatches, without the images.
struct RefinementInput
{
    //! Throws if an argument is invalid.
    void check() const;

    const std::vector<KeyPoint>& keypoints1;
    const std::vector<KeyPoint>& keypoints2;
    const std::vector<DMatch>& matches;
    float minCorrelation, scaleFactor;
};

//! Matches kept by the refinement, with positions, deviations and maps.
struct RefinedMatches
{
    void add(const DMatch& match, const PatchPair& pair, const PatchAlignment& alignment);
    void append(const RefinedMatches& other);
    //! The same matches from image 2 to image 1.
    RefinedMatches exchanged() const;

    std::vector<DMatch> matches;
    std::vector<Point2f> points1, points2;
    std::vector<float> deviations;
    std::vector<Matx22d> maps;  //!< from image 1 to image 2, around the positions
};
RefinedMatches refinedMatches(const RefinementInput& input, PatchAligner& aligner);

//! Distance of the samples of a keypoint of image 1, in pixels of the image.
double spacingOf(const KeyPoint& keypoint, float scaleFactor);

}  // namespace aqorb
}  // namespace cv

#endif
