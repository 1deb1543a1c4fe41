// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#ifndef OPENCV_AQORB_HPP
#define OPENCV_AQORB_HPP

#include <opencv2/aqorb/features.hpp>
#include <opencv2/aqorb/matching.hpp>
#include <opencv2/aqorb/refinement.hpp>
#include <opencv2/core.hpp>

#include <atomic>
#include <memory>

/**
@defgroup aqorb Uniformly distributed ORB features

ORB features that are spread uniformly over the image. The detector uses an adaptive FAST threshold and a quadtree after
@cite Yao2019AQORB. The class cv::aqorb::AdaptiveQuadtreeORB is derived from cv::ORB: it takes the same parameters,
computes the same descriptors, and replaces a cv::ORB or a cv::Feature2D anywhere.

Four functions work with any detector: distributionUniformity and distributionOccupancy measure the uniformity of its
keypoints, retainUniform thins them out uniformly, and adaptiveFastThreshold computes a FAST threshold from the contrast
of an image.

The class aqorb::HammingMatcher finds the matches of cv::BFMatcher for binary descriptors, at least 6 times as fast with
AVX2. matchArrays, knnMatchArrays, matchByPosition and matchGuided return matches as arrays. refineMatches and
growMatches refine the positions of matches. matchImages finds exact pairs of points of two images. The class
aqorb::SlamExtractor, in the header aqorb/slam.hpp, replaces the feature extractor of ORB-SLAM.

The @ref tutorial_table_of_content_aqorb "tutorials" show how to use the module and how it works.
*/

namespace cv
{
namespace aqorb
{

//! @addtogroup aqorb
//! @{

/** @brief ORB detector and descriptor whose keypoints are spread uniformly over the image.

Use it if keypoints must cover the image: for visual odometry and SLAM, stitching, homographies, and dark or
low-contrast images. Prefer cv::ORB if you want only the strongest keypoints, wherever they lie, or the same keypoints
as earlier runs of cv::ORB.

@code{.cpp}
    Ptr<aqorb::AdaptiveQuadtreeORB> detector = aqorb::AdaptiveQuadtreeORB::create(1000);  // was: ORB::create(1000)
    detector->setMinThresholdRatio(1);  // no weak corners in smooth parts of the image
    detector->detectAndCompute(image, mask, keypoints, descriptors);
@endcode

### How keypoints are found

The detector follows @cite Yao2019AQORB, and the descriptor is cv::ORB's @cite RRKB11. FAST finds corners on each level
of an image pyramid. A quadtree divides the level into leaves. The corner with the highest FAST score represents its
leaf, unless at least three of the eight leaves around it have better corners. The detector takes representatives by
their *strength*, weighed against their *rank*, the number of stronger representatives around them. The strength of a
corner is its FAST score, times the fourth root of its Harris response (not with ORB::FAST_SCORE), times the length of
its orientation moment. @ref tutorial_aqorb_algorithm has the formulas.

### What a keypoint holds

- pt: the position in pixels of the image; (0, 0) is the centre of the first pixel. Each coordinate is at least 0 and
  less than the width or the height. See setSubPixel().
- size: the diameter of the descriptor's patch, in pixels of the image: patchSize * scale. The scale of a level is
  scaleFactor^(octave - firstLevel).
- angle: the direction from the centre of the patch to the centroid of its intensity, in degrees, from 0 to 360.
  It grows from the x axis towards the y axis, which points down.
- response: the Harris response or the FAST score, see scoreType of create. cv::ORB's Harris response differs: it covers
  7x7 pixels.
- octave: the number of the level, from 0 (the finest) to nlevels - 1. class_id is -1.

### What you can rely on

- There are never more than nfeatures keypoints, and exactly nfeatures if the image has that many corners.
- Keypoints are ordered by octave, the lowest first, and within a level by response, the highest first.
- The keypoints and descriptors are the same for any number of threads, on any CPU, at every repetition.
- The descriptor of a keypoint equals cv::ORB::compute's with the same parameters.
- Any non-zero value of a mask means "use this pixel", on every level.
- Several threads may use one object at the same time, while no thread calls a setter.

@ref tutorial_aqorb_promises states each promise exactly, with its exceptions and its test.

### Errors

An invalid parameter raises a cv::Exception that names it and leaves the object unchanged. create and each call check
combinations of parameters; setters do not, because they may come in any order. An image and each level have at most
2^20 - 1 pixels a side; otherwise an exception names the size of the image. compute raises an exception for a keypoint
whose octave is negative or stands for a level without a pixel, or whose angle is not finite. An octave may be nlevels
or more, as with cv::ORB, but must be below 64 or below nlevels. A call that raises an exception because of an argument
leaves its outputs unchanged. */
class CV_EXPORTS_W AdaptiveQuadtreeORB : public cv::ORB
{
public:
    //! Rule that selects the corners of a level, see setSelectionType().
    enum SelectionType
    {
        RANKED_SELECTION = 0,   //!< by strength and by the number of stronger corners nearby
        QUADTREE_SELECTION = 1  //!< the paper's method
    };

    /** @brief Creates the detector. It takes cv::ORB::create's parameters, in the same order.

    Two of them differ from cv::ORB's: edgeThreshold is 16 by default, and fastThreshold scales the adaptive threshold.
    Each parameter also has the setter and the getter of cv::ORB.

    @param nfeatures The maximum number of keypoints, >= 0. With 0 the outputs are empty.
    @param scaleFactor Ratio between the sizes of neighbouring pyramid levels, finite and > 0. It must be > 1 if there
    is more than one level.
    @param nlevels Number of pyramid levels, 1 to 65536. Levels too small for a keypoint are skipped.
    @param edgeThreshold Width in pixels, on each level, of the border without keypoints, >= 0. The default 16 is the
    smallest value that keeps the orientation patch of the default patchSize inside the image. The value 31 of cv::ORB
    costs uniformity, because on small levels most of the image is within the border.
    @param firstLevel The level that is the input image, 0 <= firstLevel < nlevels. Levels before it are enlarged, so
    their border is narrower than edgeThreshold pixels of the image. compute, like cv::ORB::compute, keeps edgeThreshold
    pixels of the image free and drops some keypoints that detect finds on enlarged levels.
    @param WTA_K Number of points compared for each element of the descriptor: 2, 3 or 4. Match with NORM_HAMMING for 2,
    with NORM_HAMMING2 for 3 and 4 (see defaultNorm).
    @param scoreType The score in KeyPoint::response: ORB::HARRIS_SCORE (the Harris response over 5x5 pixels) or
    ORB::FAST_SCORE (the highest threshold at which the pixel is a FAST corner). With RANKED_SELECTION it also decides
    whether the Harris response is part of a corner's strength. The FAST score selects a leaf's representative in either
    case. With RANKED_SELECTION and ORB::HARRIS_SCORE a corner gives way to a corner of higher FAST score among the 7x7
    pixels around it. With QUADTREE_SELECTION corners do not give way, and the corner of the highest score represents
    its node.
    @param patchSize Diameter in pixels, on each level, of the patch of the orientation and the descriptor, 2 to 16384.
    @param fastThreshold Scale of the adaptive FAST threshold. 20 gives the threshold of the paper's equation (7), and
    10 half of it. A lower value gives more corners, as in cv::ORB. With setAdaptiveThreshold(false) it is the FAST
    threshold itself. It is limited to [0, 255]. */
    CV_WRAP static Ptr<AdaptiveQuadtreeORB> create(int nfeatures = 500, float scaleFactor = 1.2f,
                                                   int nlevels = 8, int edgeThreshold = 16,
                                                   int firstLevel = 0, int WTA_K = 2,
                                                   ORB::ScoreType scoreType = ORB::HARRIS_SCORE,
                                                   int patchSize = 31, int fastThreshold = 20);

    //! @name Properties
    //! @{

    /** @brief Weight of a corner's strength against an even distribution: 0 to 1000, without a unit. The default is
    0.05.

    Representatives of a level are taken in the order of (1 + rank) / strength^StrengthWeight, the lowest first. At 0
    rank alone decides, which gives the most even distribution. A larger value prefers strong corners in fewer parts of
    the image. (To find a small object, grow its matches instead: growMatches.) Above 0.15 more corners compete: the
    tree has StrengthWeight / 0.15 times as many leaves, and the number of better neighbours that displaces a
    representative grows by the same factor. At 1000 strength alone decides: even a rank of a million outweighs at most
    2 % of strength. With OctaveSuppression 0 and MinThresholdRatio 1 the keypoints then lie where those of cv::ORB lie,
    except that corners still give way within 7x7 pixels. It has no effect with QUADTREE_SELECTION. */
    CV_WRAP virtual void setStrengthWeight(double strengthWeight) = 0;
    CV_WRAP virtual double getStrengthWeight() const = 0;  //!< see setStrengthWeight()

    /** @brief Distance that a corner keeps from earlier keypoints of neighbouring levels, in pixels of its own level:
    finite and >= 0. The default -1 takes the distance of the selection type, see setSelectionType().

    Coarse levels choose first, so keypoints of neighbouring levels lie at least this many pixels of the finer level
    apart. The detector takes a nearer corner only when no corner that keeps the distance is left. The detected pixels,
    mapped to the image by pixel centres, keep this distance; refined positions (setSubPixel()) can be nearer. 0
    switches the rule off, as in the paper. */
    CV_WRAP virtual void setOctaveSuppression(double octaveSuppression) = 0;
    CV_WRAP virtual double getOctaveSuppression() const = 0;  //!< see setOctaveSuppression()

    /** @brief Whether the detector refines keypoint positions to a fraction of a pixel and maps them to the image by
    pixel centres. The default is true.

    With false, a position is a whole pixel of the level times the level's scale, as in cv::ORB and in the paper. In
    either case keypoint k is detected, oriented and described at the pixel cvRound(k.pt / scale) of its level. */
    CV_WRAP virtual void setSubPixel(bool subPixel) = 0;
    CV_WRAP virtual bool getSubPixel() const = 0;  //!< see setSubPixel()

    /** @brief Whether the FAST threshold adapts to the image by equation (7) of the paper. The default is true. With
    false it is fastThreshold for every image. */
    CV_WRAP virtual void setAdaptiveThreshold(bool adaptiveThreshold) = 0;
    CV_WRAP virtual bool getAdaptiveThreshold() const = 0;  //!< see setAdaptiveThreshold()

    /** @brief Ratio of the FAST threshold to the lower threshold in cells without a corner: finite, >= 1. The default
    is 4, as in the paper. Cells are squares of 35 pixels of the level. The lower threshold is never above
    fastThreshold, so with 1 both thresholds are equal unless the first is above fastThreshold. */
    CV_WRAP virtual void setMinThresholdRatio(double minThresholdRatio) = 0;
    CV_WRAP virtual double getMinThresholdRatio() const = 0;  //!< see setMinThresholdRatio()

    // The full name of the type, because OpenCV's wrappers for Python and Java need it.
    /** @brief Rule that selects the corners of a level. The default is RANKED_SELECTION.

    - RANKED_SELECTION counts the stronger representatives around each representative (setRankRadius()), and weighs this
      rank against its strength (setStrengthWeight()). Neither depends much on where a corner lies in the frame, so a
      camera that turns finds nearly the same corners. Levels share the features in proportion to area * scale^1.25,
      where the area excludes the borders; the finest level gets half as much again. The tree has the smallest depth
      that gives at least 9 leaves for each feature of the level's quota, not counting leaves on masked pixels; a
      StrengthWeight above 0.15 requires more leaves. No leaf is shorter than 2 pixels: if one tree would need shorter
      leaves, a level at least twice as long as wide has several trees in a row. There are at most 2^24 leaves. A corner
      keeps 2.1 / (1 + StrengthWeight) pixels from keypoints of neighbouring levels, so a corner of the scene can give a
      keypoint on every second level.
    - QUADTREE_SELECTION is the paper's method, equations (7), (8) and (9) and Figure 2. Levels share the features in
      proportion to their widths. The tree splits its nodes, the fullest of each depth first, up to the level's quota or
      the depth of equation (9). The corner with the highest response represents its node. If there are fewer nodes than
      features, the strongest other corners follow. Positions are whole pixels, and levels do not suppress each other's
      corners: StrengthWeight, RankRadius, OctaveSuppression and SubPixel keep their values and have no effect.

    Any other value raises an exception. */
    CV_WRAP virtual void setSelectionType(cv::aqorb::AdaptiveQuadtreeORB::SelectionType selectionType) = 0;
    //! See setSelectionType().
    CV_WRAP virtual cv::aqorb::AdaptiveQuadtreeORB::SelectionType getSelectionType() const = 0;

    /** @brief Radius of the disc in which stronger corners count for the rank of a corner: 0 to 16, in units of the
    mean distance between the features of the level. The default is 1.

    The mean distance is the square root of A / n, where A is the level's unmasked area between the borders, and n its
    number of features. With 0 all representatives have the same rank, and their strength decides. It has no effect with
    QUADTREE_SELECTION.
    */
    CV_WRAP virtual void setRankRadius(double rankRadius) = 0;
    CV_WRAP virtual double getRankRadius() const = 0;  //!< see setRankRadius()

    //! @}

    /** @brief Computes the image pyramid of the detector, for work on the pixels around keypoints such as stereo
    matching: keypoint k lies on levels[k.octave].

    Level i has the pixels of cv::ORB's level. It has cvRound(width * (1.f / scale)) columns, and rows in the same way,
    where scale is scaleFactor^(i - firstLevel) as a float, all products are floats, and cvRound rounds halves to even.
    Detection keeps no pyramid, so this function computes all levels.

    @param image 8-bit image with 1, 3 (BGR) or 4 (BGRA) channels.
    @param levels A vector of Mat or UMat: one CV_8UC1 image for each level, without shared memory with the input. The
    vector may hold the input itself. It has nlevels images, fewer if levels have no pixel, and none for an empty image.
    */
    CV_WRAP virtual void buildPyramid(InputArray image, OutputArrayOfArrays levels) const = 0;

    /** @brief detectAndCompute and buildPyramid in one call, which makes the pyramid once.

    @param image, mask, keypoints, descriptors As for cv::Feature2D::detectAndCompute.
    @param levels The images of buildPyramid. */
    virtual void detectAndComputeWithPyramid(InputArray image, InputArray mask,
                                             std::vector<KeyPoint>& keypoints, OutputArray descriptors,
                                             std::vector<Mat>& levels) = 0;

    /** @brief detectAndCompute for the images of a collection, in parallel. Any number of threads gives the results of
    one call for each image.

    Each of the cv::getNumThreads threads takes one image after another, which is faster than sharing each image among
    the threads. If the collection has only one image, all threads share it. The functions of cv::Feature2D for
    collections, detect(images, keypoints, masks) and compute(images, keypoints, descriptors), work in the same way and
    report errors in the same way.

    @param images A vector of Mat or UMat. Images may differ in size and number of channels, and each may be empty.
    @param masks One mask for each image, which may be empty; or no masks at all.
    @param keypoints The keypoints of each image.
    @param descriptors A vector of Mat or UMat: the descriptors of each image, empty without keypoints. noArray()
    computes none.

    An exception names the image, as in "images[3]: mask must be ...". If several images fail, the call waits for all
    threads, then throws the first image's exception. The outputs are then unchanged. */
    CV_WRAP virtual void detectAndComputeBatch(InputArrayOfArrays images, InputArrayOfArrays masks,
                                               CV_OUT std::vector<std::vector<KeyPoint>>& keypoints,
                                               OutputArrayOfArrays descriptors) = 0;

    /** @brief Frees the work space that the object keeps between calls. The next call allocates it anew.

    A work space takes a few times the memory of the image. Each of several simultaneous calls has its own; the object
    keeps at most one for each CPU. */
    CV_WRAP virtual void releaseMemory() = 0;

    /** @brief The name that cv::Algorithm writes to a file: "Feature2D.AdaptiveQuadtreeORB". */
    CV_WRAP virtual String getDefaultName() const CV_OVERRIDE;
};

/** @brief Keeps calls of the module on the calling thread. While a thread holds a scope, its calls into this module
start no other threads. It is for programs that process each image on a thread of their own.

A thread may have several scopes, which may end in any order and on any thread. */
class CV_EXPORTS SingleThreadScope
{
public:
    SingleThreadScope();
    ~SingleThreadScope();
    SingleThreadScope(const SingleThreadScope&) = delete;

private:
    const std::shared_ptr<std::atomic<int>> scopes;  //!< number of scopes of the thread that made this scope
};

/** @brief Computes the adaptive FAST threshold of an image: variance over mean of the grey values, equation (7) of
@cite Yao2019AQORB.

The threshold scales with the contrast. It is between 14 and 48 for most photographs, and a tenth as high for the same
scene at a tenth of the light.

@param image 8-bit image with 1, 3 (BGR) or 4 (BGRA) channels.
@param mask Optional CV_8UC1 mask of the size of the image. Only pixels where it is not zero count.
@return The threshold in grey levels, not rounded. It is 0 for an empty image, an image or a mask of zeros, and an image
with a single grey value.

An image or a mask of another type or size raises a cv::Exception that names it. */
CV_EXPORTS_W double adaptiveFastThreshold(InputArray image, InputArray mask = noArray());

/** @brief Measures the uniformity of keypoints: u of Zu and Zhao @cite Zu2010Uniformity, by which @cite Yao2019AQORB
compares detectors. A smaller value is more uniform.

The measure halves the image in five ways: left and right, top and bottom, along each diagonal, and into centre and
periphery. With the population standard deviation sigma of the ten counts, u = 101 * log10(sigma). It measures only the
balance between halves; distributionOccupancy resolves smaller parts. u of clustered keypoints grows with their number,
so compare equal numbers of keypoints. Some values for 500 points: 30 for a jittered grid, 101 for random points, 216 if
all points are in one half.

@param keypoints Keypoints of any detector. A keypoint whose position is not finite is ignored.
@param imageSize Size of the keypoints' image; both sides > 0.
@return u, or 0 if sigma is below 1: for a distribution as even as whole counts allow, and without keypoints.

A size out of its range raises a cv::Exception that names it. */
CV_EXPORTS_W double distributionUniformity(const std::vector<KeyPoint>& keypoints, Size imageSize);

/** @brief Computes the share of the cells of a grid over the image that contain at least one keypoint.

@param keypoints Keypoints of any detector. Keypoints outside the image are ignored.
@param imageSize Size of the keypoints' image; both sides > 0.
@param grid Number of columns and rows of the grid; both > 0, at most 2^24 cells.
@return Number of occupied cells divided by the number of cells, 0 to 1.

A size or a grid out of its range raises a cv::Exception that names it. */
CV_EXPORTS_W double distributionOccupancy(const std::vector<KeyPoint>& keypoints, Size imageSize,
                                          Size grid = Size(16, 12));

/** @brief Keeps npoints keypoints, spread over the image, and prefers high responses: the selection of
AdaptiveQuadtreeORB for the keypoints of any detector.

Use it in place of cv::KeyPointsFilter::retainBest, which keeps the highest responses wherever they lie. The rule is
RANKED_SELECTION with a StrengthWeight of 0.15 and a RankRadius of 1. The response replaces the FAST score and the
strength, and octaves are ignored. The quadtree spans the whole image and has at least 9 leaves for each of npoints
keypoints, but at most 2^24. The best keypoint of a leaf represents it, unless at least three of the eight leaves around
it have better keypoints. Representatives are taken in the order of (1 + rank) / response^StrengthWeight, where infinity
counts as twice the highest finite response. Representatives with a zero, negative or NaN response come last, by their
rank. The other keypoints follow by response. In every comparison NaN counts as the lowest response. A hash of their
places in raster order breaks ties, so keypoints of equal responses are spread, too. Only ratios of responses count: a
positive factor changes nothing, unless the products are rounded or leave the range of a float.

@param keypoints In: keypoints of any detector. Out: at most npoints of them, in their input order and with all fields
unchanged. Keypoints outside the image are dropped, even if there are fewer than npoints.
@param imageSize Size of the image; both sides > 0.
@param npoints Number of keypoints to keep, >= 0.

A size or a number out of its range raises a cv::Exception that names it. */
CV_EXPORTS_W void retainUniform(CV_IN_OUT std::vector<KeyPoint>& keypoints, Size imageSize, int npoints);

//! @}

}  // namespace aqorb
}  // namespace cv

#endif
