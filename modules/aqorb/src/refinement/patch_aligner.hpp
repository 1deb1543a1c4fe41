// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// Alignment of patches of two images, and refined matches.

#ifndef OPENCV_AQORB_PATCH_ALIGNER_HPP
#define OPENCV_AQORB_PATCH_ALIGNER_HPP

#include "refinement/alignment.hpp"

#include <vector>

namespace cv
{
namespace aqorb
{

//! Centre of a patch and distance of its samples, in pixels of the image. Alignment needs a spacing > 0.
struct PatchLocation
{
    Point2f center;
    double spacing;
};

//! Two patches to align. Sample (u, v) of the second patch lies at second.center + map * (u, v).
struct PatchPair
{
    PatchLocation first, second;
    Matx22d map;
};

//! Second patch after the alignment, in pixels of image 2.
struct PatchAlignment
{
    Point2f center;  //!< the start of the alignment if the patches cannot be aligned
    Matx22d map;
    float correlation;  //!< NOT_ALIGNED if the patches cannot be aligned
    float deviation;  //!< standard deviation along the worst axis; infinity if the patches cannot be aligned
};

/** Grey image pyramid; each level halves the level before. Patches are sampled from the level at which their samples
 are one to two pixels apart. A few patches of a large image get small pyramids of the pixels around them, with the same
 bytes as the whole pyramid. */
class PatchPyramid
{
public:
    //! Throws unless the input is an image. An input that is not needed may be empty.
    PatchPyramid(InputArray image, const char* name, bool isNeeded);

    //! Converts the whole image to grey if single patches would convert more pixels.
    //! @return number of levels for makeLevels
    int prepare(const std::vector<PatchLocation>& patches);
    void makeLevels(int count);

    //! Finds the window of a patch. Returns false if the centre lies too close to the border.
    //! @param memory buffer for the patch's own pyramid
    bool findWindow(const PatchLocation& patch, LevelWindow& window, Mat& memory) const;

private:
    bool hasLevel(int level) const;

    UMat retained;
    Mat image;
    std::vector<Mat> levels;  // level 0 is empty until the image is grey
};

//! Aligns patches of two images.
class PatchAligner
{
public:
    PatchAligner(InputArray image1, InputArray image2, bool areNeeded);
    //! The first patches of pairs lie in image 1, or in image 2 if isReversed.
    std::vector<PatchAlignment> align(const std::vector<PatchPair>& pairs, bool isReversed);

private:
    PatchPyramid pyramids[2];
};

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
