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
one thread, AVX2, any k and two sets of 1000 descriptors of 32 bytes. With a mask it compares all pairs,
cv::BFMatcher only the pairs that the mask allows: it is at least twice as fast if the mask allows one pair of twenty.

`aqorb::HammingMatcher matcher(NORM_HAMMING, true)` takes the place of `BFMatcher matcher(NORM_HAMMING, true)`, also
where a pointer to a cv::BFMatcher is expected. A copy into a variable of the type cv::BFMatcher is a cv::BFMatcher
again, with its speed.

The matches equal those of the linked OpenCV's cv::BFMatcher, with the same distances and in the same order, for
descriptors of any length, for masks, for collections of several images and with cross check. Ties go to the image that
was added first, and in it to the first train descriptor. Any number of threads and any CPU give the same matches. Three
cases are defined where cv::BFMatcher leaves them open:
- knnMatch finds the k nearest descriptors of the whole collection, even where an image has fewer than k. There are
  fewer than k matches only if the collection has fewer descriptors that the masks allow.
- radiusMatch returns matches at the same distance in the order of their images, and of their descriptors in an image.
- An image may have any number of descriptors.

As with cv::BFMatcher, a query without a match has an empty list in the result. With compactResult knnMatch leaves such
lists out, and radiusMatch puts them behind the others. knnMatch appends to the list of lists that it is given. With
cross check k must be 1, and neither masks nor a second image are accepted.

Descriptors are matrices of type CV_8UC1 with a descriptor in each row, all of the same width. A matrix without rows or
columns holds no descriptors. Anything else raises a cv::Exception that names it, as does a lack of memory. Matrices of
type UMat are accepted and come behind the others. More than 1024 bytes take as long as with cv::BFMatcher.

Several threads may use one object at the same time, as long as none of them calls add, clear or train. After add, one
match with the collection must have returned before several threads match with it.
 */
class CV_EXPORTS_W HammingMatcher : public cv::BFMatcher
{
public:
    /** @brief Creates the matcher. It takes cv::BFMatcher's parameters.

    @param normType NORM_HAMMING, the number of bits in which two descriptors differ, for ORB, AKAZE, BRISK, BRIEF and
    FREAK; or NORM_HAMMING2, the number of pairs of bits, for ORB with WTA_K 3 or 4. Any other norm raises an exception.
    @param crossCheck Whether only pairs are returned in which each descriptor is the nearest one of the other.
     */
    CV_WRAP HammingMatcher(int normType = NORM_HAMMING, bool crossCheck = false);

    //! As the constructor.
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

/** @brief Matches two sets of binary descriptors, with the tests that are usually applied to matches, and returns the
matches as arrays.

A query descriptor is matched with its nearest train descriptor, or with the first of several equally near ones. The
pair is kept if it passes all tests that are asked for.

@param queryDescriptors, trainDescriptors CV_8UC1, a descriptor in each row, of the same width. If one of them has no
rows or no columns, there are no matches.
@param pairs A row of type CV_32SC1 for each match, with the indices of the query and the train descriptor, in the order
of the queries. It is empty if there are no matches.
@param distances A row of type CV_32SC1 with one element for each match: its distance in bits, or pairs of bits.
@param ratio Finite and >= 0. If it is greater than 0, the distance must be less than ratio times the distance of the
second nearest train descriptor, as Lowe proposed, and with crossCheck of the second nearest query descriptor, too. A
pair passes where there is no second nearest. With 0 there is no such test.
@param crossCheck Whether the query must be the nearest query of its train descriptor, too, or the first of equally near
ones. The default is true.
@param maxDistance The greatest distance that is kept, >= 0, or -1 for any. The default is -1.
@param normType NORM_HAMMING or NORM_HAMMING2.

Descriptors of another type or of different widths, values out of their ranges, and outputs of a fixed size or number of
channels that do not fit raise a cv::Exception that names the argument. Both outputs then stay as they were.
 */
CV_EXPORTS_W void matchArrays(InputArray queryDescriptors, InputArray trainDescriptors, OutputArray pairs,
                              OutputArray distances, double ratio = 0, bool crossCheck = true,
                              int maxDistance = -1, int normType = NORM_HAMMING);

/** @brief Finds the k nearest train descriptors of each query descriptor, and returns them as arrays.

@param queryDescriptors, trainDescriptors as for matchArrays
@param indices CV_32SC1, a row for each query and k columns: the indices of the nearest train descriptors, the nearest
one first and of equally near ones the first one first. It is -1 where there are fewer than k.
@param distances CV_32SC1 of the same size: their distances, -1 where there are fewer than k.
@param k From 1 to 536870911, as a row of a cv::Mat has at most INT_MAX bytes.
@param normType NORM_HAMMING or NORM_HAMMING2.

Errors are as for matchArrays.
 */
CV_EXPORTS_W void knnMatchArrays(InputArray queryDescriptors, InputArray trainDescriptors,
                                 OutputArray indices, OutputArray distances, int k,
                                 int normType = NORM_HAMMING);

/** @brief Matches binary descriptors whose positions are known approximately, as in a video or in a pair of rectified
images: a query is compared only with the train descriptors around the position at which it is expected.

It does what matchArrays does, for the pairs in which the train keypoint lies within the window of the query. Its time
grows with the number of keypoints that lie within reach.height of the query's row. It takes about as long as
matchArrays if all keypoints are within reach of all queries, and up to 2.5 times as long if about half of them are.
An example:
@code{.cpp}
    // the next frame of a video, in which nothing has moved by more than 20 pixels
    aqorb::matchByPosition(descriptors1, positions1, descriptors2, keypoints2, Size2f(20, 20), pairs, distances);
    // rectified images, in which a point lies 0 to 96 pixels further left in the second image, within 2 rows
    for (Point2f& position : positions1)
        position.x -= 48;
    aqorb::matchByPosition(descriptors1, positions1, descriptors2, keypoints2, Size2f(48, 2), pairs, distances);
@endcode

@param queryDescriptors, trainDescriptors as for matchArrays
@param predicted For each row of queryDescriptors, the position at which it is expected among the train keypoints, in
pixels. A query whose position is not finite has no match.
@param trainKeypoints The keypoint of each row of trainDescriptors. One whose position is not finite has no match.
@param reach How far from its predicted position a keypoint may lie, in pixels: at most reach.width in x, and at most
reach.height in y. Both >= 0. Infinity is accepted; an infinite width gives a band of rows.
@param pairs, distances, ratio, crossCheck, maxDistance, normType as for matchArrays

Errors are as for matchArrays.
 */
CV_EXPORTS_W void matchByPosition(InputArray queryDescriptors, const std::vector<Point2f>& predicted,
                                  InputArray trainDescriptors, const std::vector<KeyPoint>& trainKeypoints,
                                  Size2f reach, OutputArray pairs, OutputArray distances, double ratio = 0,
                                  bool crossCheck = true, int maxDistance = -1, int normType = NORM_HAMMING);

//! @}

}  // namespace aqorb
}  // namespace cv

#endif
