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

/** @brief Aligns the images at each match, moves its position in image 2 accordingly, and removes wrong matches.

Call it between a matcher and an estimator such as findHomography or findEssentialMat, in place of a loop that copies
the positions of the matches:
@code{.cpp}
    matcher.match(descriptors1, descriptors2, matches);
    aqorb::refineMatches(image1, keypoints1, image2, keypoints2, matches, points1, points2);
    Mat H = findHomography(points1, points2, USAC_MAGSAC, 1);  // a pixel is enough now
@endcode

It is the least squares matching of @cite Gruen1985LSM . It aligns the patches around the two keypoints of a match by an
affine map, a gain and a bias, starting from the sizes and angles of the keypoints. Only the position in image 2 moves:
a keypoint of image 1 has the same position in the matches with all other images.

@param image1, image2 The images of the keypoints, of type CV_8U with 1 (grey), 3 (BGR) or 4 (BGRA) channels. They may
differ in size and type.
@param keypoints1, keypoints2 Keypoints of any detector. The difference of the two angles turns the patch of image 2. If
either angle is -1, alignment starts without rotation and succeeds if the images are turned by up to about 20 degrees.
@param matches Matches with the queryIdx of a keypoint of image 1 and the trainIdx of a keypoint of image 2. The
function removes a match if it cannot be aligned, or if the patches correlate less than minCorrelation. The alignment
takes three steps. The correlation is measured before the last step, so patches that still have far to move do not
correlate. The remaining matches keep their order. See below for the second try.
@param points1 For each remaining match, the position of its keypoint in image 1, in pixels.
@param points2 For each remaining match, the position of the same spot in image 2, in pixels.
@param minCorrelation The smallest normalised correlation of the aligned patches, from -1 to 1. With -1 no match is
removed, and matches that cannot be aligned keep the position of the keypoint. The default is 0.8.
@param scaleFactor The size of the keypoint's patch in units of KeyPoint::size, finite and > 0, as for
cv::xfeatures2d::BEBLID: 1 for ORB, 5 for AKAZE, BRISK and FAST, 6.25 for KAZE and SURF, 6.75 for SIFT. The default
is 1.

The patch has 13 x 13 samples, half a pixel of the keypoint's pyramid level apart, but at least 0.7 pixels of image 1.
The samples come from the level of an image pyramid at which they are one to two pixels apart. A pixel of level k is the
mean of 2^k x 2^k pixels of the image, and k is at most 4. In image 1 the patch has one more sample on each side, for
derivatives. A match cannot be aligned if
- a position, a size or an angle of its keypoints is not finite, or a size is not positive,
- a sample lies less than half a pixel of its level from a side of its image (at level 0: beyond the centres of the
outermost pixels),
- a sample lies farther than 63 pixels of its level from the position of its keypoint, in x or in y,
- the variance of either patch is at most 4 squared grey values,
- or the alignment moves the position by more than 6 samples, or changes the area of the patch by more than a factor
of 4.

On a large plain shape, such as a letter or a logo, a patch sees one edge, and slides along it. So a match is tried once
more, with samples twice as far apart, if
- it cannot be aligned, or correlates by at most 0.1 less than minCorrelation,
- or it correlates, but the deviation of its position (see the overload below) is above 0.7 pixels.

The second patch then decides, and position, correlation and deviation are its own. A match that the first patch would
remove must correlate at least 0.9 with the second. With minCorrelation -1 no match is tried again. The second try does
not help near the sides of an image, because the larger patches also extend beyond them.

Any number of threads and any CPU give the same result. Other inputs raise a cv::Exception that names the argument, and
all outputs stay unchanged. Without matches, the images may be empty. Images have at most 1048575 pixels a side.

@sa growMatches, which finds more matches
 */
CV_EXPORTS_W void refineMatches(InputArray image1, const std::vector<KeyPoint>& keypoints1, InputArray image2,
                                const std::vector<KeyPoint>& keypoints2,
                                CV_IN_OUT std::vector<DMatch>& matches, CV_OUT std::vector<Point2f>& points1,
                                CV_OUT std::vector<Point2f>& points2, float minCorrelation = 0.8f,
                                float scaleFactor = 1.f);

/** @overload
@param image1, image2, keypoints1, keypoints2, matches, points1, points2, minCorrelation, scaleFactor As above.
@param deviations For each remaining match, the standard deviation of its position in image 2, in pixels, along its
least certain direction. It is infinite for a match that minCorrelation -1 keeps without alignment.

The covariance of the position is the inverse of the Hessian of the alignment times the variance of the differences
between the patches. A factor scales the standard deviation: on photographs with an exactly known geometry, at least
68 % of the errors are smaller than it. Use it to remove the least certain matches before estimating a pose, and to sort
the others for PROSAC (cv::USAC_PROSAC), which tries the first matches first.
 */
CV_EXPORTS CV_WRAP_AS(refineMatchesWithDeviations) void refineMatches(
    InputArray image1, const std::vector<KeyPoint>& keypoints1, InputArray image2,
    const std::vector<KeyPoint>& keypoints2, CV_IN_OUT std::vector<DMatch>& matches,
    CV_OUT std::vector<Point2f>& points1, CV_OUT std::vector<Point2f>& points2,
    CV_OUT std::vector<float>& deviations, float minCorrelation, float scaleFactor = 1.f);

/** @brief Refines matches, and finds matches for more keypoints of both images near the refined matches.

Descriptors find the matches of about one keypoint in three. The affine map of an aligned match predicts the positions
of neighbouring keypoints in the other image. growMatches first does what refineMatches does. Then it aligns each
unmatched keypoint of image 1 at the position in image 2 that the nearest refined match predicts, and keeps the match if
the patches correlate. It does the same with the unmatched keypoints of image 2, whose matches it finds in image 1. This
multiplies the number of right matches, which makes poses more exact:
@code{.cpp}
    matcher.match(descriptors1, descriptors2, matches);
    aqorb::growMatches(image1, keypoints1, image2, keypoints2, matches, grown1, grown2, points1, points2, deviations);
    // sorted by deviation, without matches whose deviation is above 0.35 pixels, as in the tutorial
    Mat E = findEssentialMat(points1, points2, cameraMatrix, USAC_PROSAC, 0.9999, 0.18);
    drawMatches(image1, grown1, image2, grown2, matches, output);
@endcode

@param image1, image2, keypoints1, keypoints2 As in refineMatches.
@param matches On return the refined matches in their order, then the matches grown into image 2 in the order of
queryIdx, then the matches grown into image 1 in the order of trainIdx. A grown match has the distance FLT_MAX and the
imgIdx 0. The queryIdx of a match is an index of grown1, the trainIdx an index of grown2.
@param grown1 keypoints1, then a keypoint for each match grown into image 1. It may be keypoints1 itself.
@param grown2 keypoints2, then a keypoint for each match grown into image 2. It may be keypoints2 itself. The aligned
map takes the position, size and angle of the keypoint of the other image to the grown keypoint; an angle of -1 stays
-1. Its octave is the octave of the nearby match's keypoint in the same image, plus the difference between the two
keypoints' octaves in the other image, but at least 0. Its response is 0 and its class_id -1.
@param points1, points2 For each match, its positions in the two images, in pixels. The position in image 1 is the
keypoint's, and the position in image 2 moves. For a match grown into image 1 it is the other way round.
@param deviations For each match, the standard deviation of the position that moved, as in refineMatches.
@param minCorrelation As in refineMatches. A grown match correlates at least 0.85.
@param scaleFactor As in refineMatches.
@param bothWays If false, no matches grow into image 1, and grown1 is keypoints1.

A keypoint of image 1 gets a match if
- a refined match, which correlates at least minCorrelation, lies at most 60 pixels from the keypoint in image 1 (ties
go to the first match),
- the patches can be aligned as in refineMatches, starting from the predicted position and affine map, and correlate at
least 0.85 and at least minCorrelation,
- and the alignment moves the position by at most 4 pixels.

The same holds for a keypoint of image 2, with the inverse map and all images exchanged. But it is not tried if it lies
at most a pixel from the position of a match grown into image 2: that match is the same pair, found from image 1.

Keypoints of removed matches are tried, too. Keypoints are grown independently of each other: two keypoints may grow
onto one position, and both matches stay. A second call with the matches and keypoints of the first call adds few
matches. If the images and keypoints are exchanged, the grown matches are exchanged, with three differences: the refined
matches and their maps come from the alignment in the other image; if a pair is found from both sides, the other of its
two matches stays; and the order differs.
 */
CV_EXPORTS_W void growMatches(InputArray image1, const std::vector<KeyPoint>& keypoints1, InputArray image2,
                              const std::vector<KeyPoint>& keypoints2, CV_IN_OUT std::vector<DMatch>& matches,
                              CV_OUT std::vector<KeyPoint>& grown1, CV_OUT std::vector<KeyPoint>& grown2,
                              CV_OUT std::vector<Point2f>& points1, CV_OUT std::vector<Point2f>& points2,
                              CV_OUT std::vector<float>& deviations, float minCorrelation = 0.8f,
                              float scaleFactor = 1.f, bool bothWays = true);

/** @brief Finds pairs of points of two images that show the same spot, to a tenth of a pixel, with one call.

The points are for an estimator such as findEssentialMat, findFundamentalMat, findHomography or PoseLib's:
@code{.cpp}
    aqorb::matchImages(image1, image2, points1, points2, deviations);
    // without matches whose deviation is above 0.35 pixels, as in the tutorial
    Mat E = findEssentialMat(points1, points2, cameraMatrix, USAC_PROSAC, 0.9999, 0.18);
@endcode

It consists of four calls: AdaptiveQuadtreeORB::create(nfeatures), detectAndCompute for each image,
HammingMatcher(NORM_HAMMING, true).match, and growMatches with its defaults. Then it sorts the matches by deviation.
Make these calls yourself if features serve several pairs, or if you need masks or other parameters.

@param image1, image2 Images of type CV_8U with 1 (grey), 3 (BGR) or 4 (BGRA) channels. They may differ in size and
type. If either is empty or shows no corners, there are no points.
@param points1, points2 For each match, its positions in the two images, in pixels. The most certain match comes first,
as PROSAC wants it; ties keep the order of growMatches.
@param deviations For each match, the standard deviation of its position in one image relative to the other, in pixels,
in ascending order.
@param nfeatures Largest number of keypoints in each image, >= 0. The default is 1000. 2000 give more exact poses.

Any number of threads and any CPU give the same result. Other inputs raise a cv::Exception that names the argument, and
all outputs stay unchanged.

@sa matchGuided, which finds still more matches of wide baselines
 */
CV_EXPORTS_W void matchImages(InputArray image1, InputArray image2, CV_OUT std::vector<Point2f>& points1,
                              CV_OUT std::vector<Point2f>& points2, CV_OUT std::vector<float>& deviations,
                              int nfeatures = 1000);

/** @brief Moves keypoints of image 1 to where a homography shows them in image 2.

This gives a match for every keypoint of a flat object that was found. refineMatches then keeps the matches that are
visible in the scene. They cover the whole object, while growMatches covers only the surroundings of its seeds:
@code{.cpp}
    Mat H = findHomography(points1, points2, USAC_MAGSAC, 1.5);  // of grown matches
    aqorb::transformKeypoints(keypoints1, H, keypoints2);
    matches.clear();
    for (int i = 0; i < int(keypoints1.size()); i++)
        matches.push_back(DMatch(i, i, 0));
    aqorb::refineMatches(image1, keypoints1, image2, keypoints2, matches, points1, points2);
    H = findHomography(points1, points2, USAC_MAGSAC, 1.5);
@endcode

@param keypoints Keypoints of image 1.
@param homography Matrix of 3x3 finite numbers that takes positions in image 1 to positions in image 2, in pixels.
@param transformed For each keypoint its position in image 2. The derivative of the homography at the keypoint turns its
angle (an angle of -1 stays -1), and the square root of the derivative's determinant, without its sign, scales its size.
All other fields stay. The position is not finite on the line that the homography takes to infinity; refineMatches
leaves such keypoints out. The output may be `keypoints` itself.
 */
CV_EXPORTS_W void transformKeypoints(const std::vector<KeyPoint>& keypoints, InputArray homography,
                                     CV_OUT std::vector<KeyPoint>& transformed);

//! @}

}  // namespace aqorb
}  // namespace cv

#endif
