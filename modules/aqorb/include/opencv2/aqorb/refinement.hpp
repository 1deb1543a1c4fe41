// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#ifndef OPENCV_AQORB_REFINEMENT_HPP
#define OPENCV_AQORB_REFINEMENT_HPP

#include <opencv2/aqorb/features.hpp>
#include <opencv2/core.hpp>

#include <vector>

namespace cv
{
namespace aqorb
{

//! @addtogroup aqorb
//! @{

/** @brief Moves the positions of matches to where both images show the same spot, and leaves out wrong matches.

Call it between a matcher and an estimator such as findHomography or findEssentialMat, in place of the loop that copies
the positions of the matches:
@code{.cpp}
    matcher.match(descriptors1, descriptors2, matches);
    aqorb::refineMatches(image1, keypoints1, image2, keypoints2, matches, points1, points2);
    Mat H = findHomography(points1, points2, RANSAC, 1);  // half a pixel to one is enough now
@endcode

It is the least squares matching of @cite Gruen1985LSM . It aligns the patches around the two keypoints of a match, and
estimates an affine map, a gain and a bias, starting from the sizes and the angles of the keypoints. Only the position
in image 2 moves, so that a keypoint of image 1 has the same position in the matches with all other images.

@param image1, image2 The images of the keypoints, of type CV_8U with 1 (grey), 3 (BGR) or 4 (BGRA) channels. They may
differ in size and type.
@param keypoints1, keypoints2 Keypoints of any detector. A keypoint with the angle -1 is upright.
@param matches Matches with the queryIdx of a keypoint of image 1 and the trainIdx of a keypoint of image 2. A match is
removed if it cannot be aligned, or if its aligned patches correlate less than minCorrelation. The others keep their
order.
@param points1 For each match that is left, the position of its keypoint in image 1, in pixels.
@param points2 For each match that is left, the position in image 2 that shows the same spot, in pixels.
@param minCorrelation The smallest normalised correlation of the aligned patches, from -1 to 1. With -1 no match is
removed, and matches that cannot be aligned keep the position of the keypoint. The default is 0.8.
@param scaleFactor The size of the keypoint's patch in units of KeyPoint::size, finite and > 0, as for
cv::xfeatures2d::BEBLID: 1 for ORB, 5 for AKAZE, BRISK and FAST, 6.25 for KAZE and SURF, 6.75 for SIFT. The default
is 1.

The patch has 13 x 13 samples, half a pixel of the keypoint's pyramid level apart, but at least 0.7 pixels of image 1.
A match cannot be aligned if
- a position, a size or an angle of its keypoints is not finite, or a size is not positive,
- the patch leaves an image, or has a variance below 4 squared grey values,
- or the alignment moves the position by more than 6 samples, or changes the area of the patch by more than a factor
of 4.

Any number of threads and any CPU give the same result. Other inputs raise a cv::Exception that names the argument; then
all outputs stay as they were. Without matches, the images may be empty.
 */
CV_EXPORTS_W void refineMatches(InputArray image1, const std::vector<KeyPoint>& keypoints1, InputArray image2,
                                const std::vector<KeyPoint>& keypoints2,
                                CV_IN_OUT std::vector<DMatch>& matches, CV_OUT std::vector<Point2f>& points1,
                                CV_OUT std::vector<Point2f>& points2, float minCorrelation = 0.8f,
                                float scaleFactor = 1.f);

//! @}

}  // namespace aqorb
}  // namespace cv

#endif
