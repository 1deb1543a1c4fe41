// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// The alignment of patches of two images, and the matches that it refines.

#ifndef OPENCV_AQORB_PATCH_ALIGNER_HPP
#define OPENCV_AQORB_PATCH_ALIGNER_HPP

#include "alignment.hpp"

#include <vector>

namespace cv
{
namespace aqorb
{

//! The centre of a patch and the distance of its samples, in pixels of the image. A patch whose spacing is not > 0
//! cannot be aligned.
struct PatchLocation
{
    Point2f center;
    double spacing;
};

//! Two patches to align. Sample (u, v) of the second one lies at second.center + map * (u, v).
struct PatchPair
{
    PatchLocation first, second;
    Matx22d map;
};

//! The second patch after the alignment, in pixels of image 2.
struct PatchAlignment
{
    Point2f center;  //!< that of the start if the patches cannot be aligned
    Matx22d map;
    float correlation;  //!< NOT_ALIGNED if the patches cannot be aligned
    float deviation;    //!< of the position along its worst axis; infinity if the patches cannot be aligned
};

/** The grey pyramid of an image, whose levels are made by halving. Patches are sampled from the level at which their
 samples are one to two pixels apart. A few patches of a large image get small pyramids of the pixels around them, which
 have the same bytes as that part of the whole pyramid. */
class PatchPyramid
{
public:
    //! Throws unless the input is an image, or is empty and not needed.
    PatchPyramid(InputArray image, const char* name, bool isNeeded);

    //! Converts the image to grey where more pixels would be converted for single patches.
    //! @return how many levels makeLevels then makes
    int prepare(const std::vector<PatchLocation>& patches);
    void makeLevels(int count);

    //! The window of a patch. False if the centre lies too close to the border.
    //! @param memory for the patch's own pyramid
    bool findWindow(const PatchLocation& patch, LevelWindow& window, Mat& memory) const;

private:
    bool hasLevel(int level) const;

    UMat retained;
    Mat image;
    std::vector<Mat> levels;  // level 0 is empty as long as no grey image is at hand
};

//! Aligns patches of two images.
class PatchAligner
{
public:
    PatchAligner(InputArray image1, InputArray image2, bool areNeeded);
    std::vector<PatchAlignment> align(const std::vector<PatchPair>& pairs);

private:
    PatchPyramid pyramids[2];
};

//! The arguments of refineMatches and growMatches, but for the images.
struct RefinementInput
{
    //! Throws where an argument is wrong.
    void check() const;

    const std::vector<KeyPoint>& keypoints1;
    const std::vector<KeyPoint>& keypoints2;
    const std::vector<DMatch>& matches;
    float minCorrelation, scaleFactor;
};

//! The matches that are kept.
struct RefinedMatches
{
    void add(const DMatch& match, const PatchPair& pair, const PatchAlignment& alignment);

    std::vector<DMatch> matches;
    std::vector<Point2f> points1, points2;
    std::vector<float> deviations;
    std::vector<Matx22d> maps;  //!< from image 1 to image 2, around the positions
};
RefinedMatches refinedMatches(const RefinementInput& input, PatchAligner& aligner);

//! The distance of samples of a keypoint of image 1, in pixels of the image.
double spacingOf(const KeyPoint& keypoint, float scaleFactor);

}  // namespace aqorb
}  // namespace cv

#endif
