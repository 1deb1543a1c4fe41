// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#ifndef OPENCV_AQORB_MATCHING_HPP
#define OPENCV_AQORB_MATCHING_HPP

#include <opencv2/aqorb/features.hpp>
#include <opencv2/core.hpp>

#include <vector>

namespace cv
{
namespace aqorb
{

//! @addtogroup aqorb
//! @{

/** @brief Brute-force matcher of binary descriptors: cv::BFMatcher for the Hamming norms, at least 6 times as fast with
one thread, AVX2, any k and two sets of 1000 descriptors of 32 bytes. With a mask it compares all pairs, while
cv::BFMatcher compares only allowed pairs. Even so, it is at least twice as fast if the mask allows one pair in twenty.

`aqorb::HammingMatcher matcher(NORM_HAMMING, true)` replaces `BFMatcher matcher(NORM_HAMMING, true)`, also behind a
pointer to a cv::BFMatcher. A copy into a variable of type cv::BFMatcher is a cv::BFMatcher again, with its speed.

The matches equal those of the linked OpenCV's cv::BFMatcher, with the same distances and in the same order, for
descriptors of any length, for masks, for collections of several images and with cross check. Ties go to the first image
of the collection, and in it to the first train descriptor. Any number of threads and any CPU give the same matches. The
class defines three cases that cv::BFMatcher leaves open:
- knnMatch finds the k nearest descriptors of the whole collection, even if an image has fewer than k. It returns fewer
  than k matches only if the collection has, or the masks allow, fewer than k descriptors.
- radiusMatch orders matches at the same distance by image, and within an image by descriptor.
- An image may have any number of descriptors.

As with cv::BFMatcher, a query without a match has an empty list in the result. With compactResult knnMatch leaves out
empty lists, and radiusMatch puts them at the end. knnMatch appends to its output. With cross check k must be 1, and
neither masks nor a second image are accepted.

Descriptors are matrices of type CV_8UC1 with one descriptor per row, all of the same width. A matrix without rows or
columns holds no descriptors. Anything else raises a cv::Exception that names it, and so does a lack of memory. In a
collection, UMat matrices come after Mat matrices. Descriptors of more than 1024 bytes take as long as with
cv::BFMatcher.

Several threads may use one object at the same time, while no thread calls add, clear or train. After UMat matrices
were added, one match with the collection must return before several threads match with it.
 */
class CV_EXPORTS_W HammingMatcher : public cv::BFMatcher
{
public:
    /** @brief Creates the matcher. It takes cv::BFMatcher's parameters.

    @param normType NORM_HAMMING, the number of bits in which two descriptors differ, for ORB, AKAZE, BRISK, BRIEF and
    FREAK; or NORM_HAMMING2, the number of pairs of bits, for ORB with WTA_K 3 or 4. Any other norm raises an exception.
    @param crossCheck Returns only pairs of mutually nearest descriptors.
     */
    CV_WRAP HammingMatcher(int normType = NORM_HAMMING, bool crossCheck = false);

    //! See the constructor.
    CV_WRAP static Ptr<HammingMatcher> create(int normType = NORM_HAMMING, bool crossCheck = false);

    CV_NODISCARD_STD virtual Ptr<DescriptorMatcher> clone(bool emptyTrainData = false) const CV_OVERRIDE;

protected:
    virtual void knnMatchImpl(InputArray queryDescriptors, std::vector<std::vector<DMatch>>& matches, int k,
                              InputArrayOfArrays masks = noArray(), bool compactResult = false) CV_OVERRIDE;
    virtual void radiusMatchImpl(InputArray queryDescriptors, std::vector<std::vector<DMatch>>& matches,
                                 float maxDistance, InputArrayOfArrays masks = noArray(),
                                 bool compactResult = false) CV_OVERRIDE;

private:
    std::vector<Mat> gatherTrainDescriptors(const Mat& query);
};

/** @brief Matches two sets of binary descriptors with the usual tests, and returns the matches as arrays.

Each query descriptor is paired with its nearest train descriptor; ties go to the first. A pair is a match if it passes
all requested tests.

@param queryDescriptors, trainDescriptors CV_8UC1, one descriptor per row, of the same width. If either has no rows or
no columns, there are no matches.
@param pairs CV_32SC1, one row for each match: the indices of the query and the train descriptor, in the order of the
queries. It is empty without matches.
@param distances CV_32SC1, one element for each match: its distance in bits, or pairs of bits.
@param ratio Finite and >= 0. Above 0, the distance must be less than ratio times the distance of the second nearest
train descriptor, as Lowe proposed, and with crossCheck also of the second nearest query descriptor. A pair without a
second nearest descriptor passes. 0 switches the test off.
@param crossCheck Requires the query to be the nearest query of its train descriptor, or the first of equally near
queries. The default is true.
@param maxDistance Largest distance of a match, >= 0, or -1 for any. The default is -1.
@param normType NORM_HAMMING or NORM_HAMMING2.

Descriptors of another type or of different widths, values out of range, and outputs whose fixed size or number of
channels does not fit raise a cv::Exception that names the argument. Both outputs then stay unchanged.
 */
CV_EXPORTS_W void matchArrays(InputArray queryDescriptors, InputArray trainDescriptors, OutputArray pairs,
                              OutputArray distances, double ratio = 0, bool crossCheck = true,
                              int maxDistance = -1, int normType = NORM_HAMMING);

/** @brief Finds the k nearest train descriptors of each query descriptor, and returns them as arrays.

@param queryDescriptors, trainDescriptors as for matchArrays
@param indices CV_32SC1, one row for each query and k columns: the indices of the nearest train descriptors by ascending
distance. Ties go to the lower index. Rows with fewer than k descriptors are filled up with -1.
@param distances CV_32SC1 of the same size: the distances, filled up with -1.
@param k From 1 to 536870911, because a row of a cv::Mat has at most INT_MAX bytes.
@param normType NORM_HAMMING or NORM_HAMMING2.

Errors are as for matchArrays.
 */
CV_EXPORTS_W void knnMatchArrays(InputArray queryDescriptors, InputArray trainDescriptors,
                                 OutputArray indices, OutputArray distances, int k,
                                 int normType = NORM_HAMMING);

/** @brief Matches binary descriptors with approximately known positions, as in a video or in a pair of rectified
images: it compares a query only with train descriptors near its predicted position.

It matches like matchArrays, among pairs whose train keypoint lies within the window of the query. Its time grows with
the number of keypoints within reach.height of the query's row. It takes about as long as matchArrays if all keypoints
are within reach of all queries, and up to 2.5 times as long if about half of them are.
An example:
@code{.cpp}
    // next frame of a video: nothing has moved by more than 20 pixels
    aqorb::matchByPosition(descriptors1, positions1, descriptors2, keypoints2, Size2f(20, 20), pairs, distances);
    // rectified images: a point lies 0 to 96 pixels further left in the second image, within 2 rows
    for (Point2f& position : positions1)
        position.x -= 48;
    aqorb::matchByPosition(descriptors1, positions1, descriptors2, keypoints2, Size2f(48, 2), pairs, distances);
@endcode

@param queryDescriptors, trainDescriptors as for matchArrays
@param predicted The expected position among the train keypoints for each row of queryDescriptors, in pixels. A query
whose position is not finite has no match.
@param trainKeypoints The keypoint of each row of trainDescriptors. A keypoint whose position is not finite has no
match.
@param reach Largest offset of a keypoint from the predicted position, in pixels: reach.width in x, reach.height in y,
both >= 0. Infinity is accepted; an infinite width gives a band of rows. Offsets are compared without rounding.
@param pairs, distances, ratio, crossCheck, maxDistance, normType as for matchArrays

Errors are as for matchArrays.
 */
CV_EXPORTS_W void matchByPosition(InputArray queryDescriptors, const std::vector<Point2f>& predicted,
                                  InputArray trainDescriptors, const std::vector<KeyPoint>& trainKeypoints,
                                  Size2f reach, OutputArray pairs, OutputArray distances, double ratio = 0,
                                  bool crossCheck = true, int maxDistance = -1, int normType = NORM_HAMMING);

/** @brief Matches binary descriptors of two images along epipolar lines, once a first pose of the cameras is known.

The point of image 2 that corresponds to a keypoint of image 1 lies on the epipolar line of this keypoint. Among the few
keypoints near the line, the nearest descriptor is often right even if it is not the nearest one of the whole image:
where a wide baseline has changed the descriptors, or where a texture repeats. Pass the keypoints without a match that
agrees with the first pose. The matches are candidates: align them by refineMatches, keep those that still lie near
their lines, and estimate the pose again (@ref tutorial_aqorb_match has the whole second pass). An example:
@code{.cpp}
    Mat F = findFundamentalMat(points1, points2, USAC_MAGSAC, 1);
    aqorb::matchGuided(descriptors1, keypoints1, descriptors2, keypoints2, F, 3, matches, distances);
@endcode

A query is paired with its nearest descriptor among the train keypoints near the query's epipolar line; ties go to the
first. A train keypoint is near the line if its distance is at most reach * max(1, s / 31) pixels, where s is its
KeyPoint::size. Several queries may be paired with one train keypoint. The time grows with the product of both numbers
of keypoints.

@param queryDescriptors, trainDescriptors As for matchArrays.
@param queryKeypoints, trainKeypoints The keypoint of each row. A keypoint without a finite position, a train keypoint
without a finite size, and a query without a line (the epipole) have no match.
@param F The fundamental matrix, 3 x 3 of type CV_64FC1 or CV_32FC1, finite and not zero: x2^T F x1 = 0 for the
positions x1 of a query and x2 of a train keypoint, as findFundamentalMat returns it. With the matrices K1 and K2 of
calibrated cameras it is K2^-T E K1^-1. Its scale does not matter.
@param reach Largest distance from the line for a train keypoint of size 31 or less, in pixels, >= 0. Infinity is
accepted. 3 suits ORB's keypoints.
@param matches CV_32SC1, one row for each match: the indices of the query and the train descriptor, in the order of the
queries. It is empty without matches.
@param distances CV_32SC1, one element for each match: its distance in bits, or pairs of bits.
@param ratio Finite and >= 0. Above 0, the distance must be less than ratio times the distance of a second descriptor:
the nearest one among the keypoints near the line that lie at least 8 pixels from the matched keypoint. A pair without a
second descriptor passes. 0 switches the test off. The default is 0.9.
@param maxDistance Largest distance of a match, >= 0. The default -1 stands for 90 of 256 bits, or 67 of 128 pairs of
bits; for descriptors of other lengths it is in proportion, rounded down.
@param normType NORM_HAMMING or NORM_HAMMING2.

Errors are as for matchArrays.
 */
CV_EXPORTS_W void matchGuided(InputArray queryDescriptors, const std::vector<KeyPoint>& queryKeypoints,
                              InputArray trainDescriptors, const std::vector<KeyPoint>& trainKeypoints,
                              InputArray F, float reach, OutputArray matches, OutputArray distances,
                              double ratio = 0.9, int maxDistance = -1, int normType = NORM_HAMMING);

//! @}

}  // namespace aqorb
}  // namespace cv

#endif
