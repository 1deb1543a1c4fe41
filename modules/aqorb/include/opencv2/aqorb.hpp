// This file is part of the aqorb project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.

#ifndef OPENCV_AQORB_HPP
#define OPENCV_AQORB_HPP

#include <opencv2/aqorb/features.hpp>
#include <opencv2/core.hpp>

/**
@defgroup aqorb Uniformly distributed ORB features

ORB features that are spread uniformly over the image, found with an adaptive FAST threshold and a
quadtree of limited depth after @cite Yao2019AQORB. cv::aqorb::AdaptiveQuadtreeORB is a cv::ORB:
it takes the same parameters, gives the same descriptors to the bit, and stands wherever a cv::ORB
or a cv::Feature2D is asked for.

@code{.cpp}
    Ptr<ORB> orb = aqorb::AdaptiveQuadtreeORB::create(1000);   // was: ORB::create(1000)
    orb->detectAndCompute(image, noArray(), keypoints, descriptors);
@endcode

The free functions work with the keypoints of any detector: they measure how uniformly the keypoints
lie (distributionUniformity, distributionOccupancy), thin them out uniformly (retainUniform) and give
the contrast-adaptive FAST threshold of an image (adaptiveFastThreshold).

The class aqorb::SlamExtractor, in a header of its own, stands in for ORB-SLAM's extractor.

@ref tutorial_table_of_content_aqorb show how to use it and how it works.
*/

namespace cv
{
namespace aqorb
{

//! @addtogroup aqorb
//! @{

/** @brief ORB detector and descriptor whose keypoints are spread uniformly over the image.

The detector of @cite Yao2019AQORB with the descriptor of cv::ORB @cite RRKB11. In each level of an
image pyramid FAST corners are found with a threshold taken from the image's contrast, lowered in
those cells of a square mesh that would stay empty; a quadtree, no deeper than the number of features
asks for, then picks the corners so that every part of the level gets its share.

Use it where keypoints must cover the image: visual odometry and SLAM, stitching, homographies, dark
or low-contrast images. Prefer cv::ORB where keypoints must be the strongest ones only, wherever
they lie, or where the keypoints of earlier runs of cv::ORB must be found again.

What holds for every image and every parameter:
- never more than nfeatures keypoints, and nfeatures of them wherever the image holds enough corners;
- for equal edgeThreshold and fastThreshold never fewer than cv::ORB, up to nfeatures;
- the same keypoints and descriptors for any number of threads, on any CPU, at every repeat, for a
  Mat, a UMat, a region of a larger image or its clone;
- the descriptors are those that cv::ORB::compute with the same parameters gives for the keypoints
  on an x86-64 CPU with FMA; on others cv::ORB's own roundings differ, those here do not;
- any non-zero value of a mask means "use this pixel", on every level;
- one object may serve several threads at once, as long as none of them calls a setter.

Two parameters of create differ from cv::ORB's: edgeThreshold is 16 by default, and fastThreshold
scales the adaptive threshold. A bad parameter raises a cv::Exception that names it, and leaves the
object unchanged; what depends on two parameters is checked when an image is processed. So does a
keypoint given to compute whose octave is no level or whose angle is not finite.
 */
class CV_EXPORTS_W AdaptiveQuadtreeORB : public cv::ORB
{
public:
    /** @brief Creates the detector. The parameters are cv::ORB::create's, in the same order.

    @param nfeatures The most keypoints to return, >= 0. With 0 the outputs are empty.
    @param scaleFactor Ratio between the sizes of neighbouring pyramid levels, finite and > 0; > 1
    where there is more than one level.
    @param nlevels Number of pyramid levels, 1 to 65536. Levels too small to hold a keypoint are skipped.
    @param edgeThreshold Width in pixels, on each level, of the border without keypoints, >= 0. The
    default 16 is the least that keeps the orientation patch of the default patchSize inside the
    image; cv::ORB's 31 costs uniformity, as it is most of the image on small levels.
    @param firstLevel The level that holds the input image, 0 <= firstLevel < nlevels; levels before
    it are enlarged.
    @param WTA_K Number of points compared for each element of the descriptor: 2, 3 or 4. Match with
    NORM_HAMMING for 2, with NORM_HAMMING2 for 3 and 4 (see defaultNorm).
    @param scoreType What ranks corners and is returned as KeyPoint::response: ORB::HARRIS_SCORE
    (over 5x5 pixels) or ORB::FAST_SCORE.
    @param patchSize Diameter in pixels, on each level, of the patch that the orientation and the
    descriptor are taken from, 2 to 16384.
    @param fastThreshold Scale of the adaptive FAST threshold: 20 stands for equation (7) of the
    paper as it is, 10 for half of it, so a lower value means more corners, as in cv::ORB. With
    setAdaptiveThreshold(false) it is the FAST threshold itself. Limited to [0, 255] as by cv::FAST.
     */
    CV_WRAP static Ptr<AdaptiveQuadtreeORB> create(int nfeatures = 500, float scaleFactor = 1.2f,
                                                   int nlevels = 8, int edgeThreshold = 16,
                                                   int firstLevel = 0, int WTA_K = 2,
                                                   ORB::ScoreType scoreType = ORB::HARRIS_SCORE,
                                                   int patchSize = 31, int fastThreshold = 20);

    /** @brief Whether the FAST threshold is taken from the image, equation (7); default true, as in
    the paper. With false it is fastThreshold for every image. */
    CV_WRAP virtual void setAdaptiveThreshold(bool adaptiveThreshold) = 0;
    CV_WRAP virtual bool getAdaptiveThreshold() const = 0;

    /** @brief How many times lower the FAST threshold is in cells that would stay empty; finite,
    >= 1, default 4, as in the paper. 1 switches the second threshold off. */
    CV_WRAP virtual void setMinThresholdRatio(double minThresholdRatio) = 0;
    CV_WRAP virtual double getMinThresholdRatio() const = 0;

    /** @brief Side in pixels of the level of the square cells in which the lower threshold may
    apply; >= 8, default 35. A cell larger than the image means one threshold for the whole level. */
    CV_WRAP virtual void setCellSize(int cellSize) = 0;
    CV_WRAP virtual int getCellSize() const = 0;

    /** @brief Depth of the quadtree, 0 to 15, or -1 (the default, as in the paper) for equation (9):
    the smallest depth with at least as many leaves as the level is to have features. 0 ranks the
    corners of a level by their score alone. */
    CV_WRAP virtual void setMaxDepth(int maxDepth) = 0;
    CV_WRAP virtual int getMaxDepth() const = 0;

    /** @brief How far a keypoint keeps others away across levels, in pixels of the finer level;
    finite, >= 0, default 0.5. A corner strictly nearer than that to a keypoint of a coarser level
    gives way to corners elsewhere. 0 switches it off, as in the paper. */
    CV_WRAP virtual void setOctaveSuppression(double octaveSuppression) = 0;
    CV_WRAP virtual double getOctaveSuppression() const = 0;

    /** @brief Whether keypoint positions are refined to a fraction of a pixel and mapped to the image
    by pixel centres; default true. With false they are whole pixels of the level times its scale, as
    cv::ORB's and the paper's. */
    CV_WRAP virtual void setSubPixel(bool subPixel) = 0;
    CV_WRAP virtual bool getSubPixel() const = 0;

    /** @brief The image pyramid that keypoints are detected and described on, for work that needs the
    pixels around them, such as stereo matching: keypoint k lies on levels[k.octave].

    Level i has the size of the image over scaleFactor^(i - firstLevel), rounded, and is equal to
    cv::ORB's. The pyramid is computed anew: detection keeps none.

    @param image 8-bit image with 1, 3 (BGR) or 4 (BGRA) channels.
    @param levels One CV_8UC1 image a level, sharing no memory with the input: nlevels of them, or as
    many as have a pixel. Empty for an empty image.
     */
    CV_WRAP virtual void buildPyramid(InputArray image, OutputArrayOfArrays levels) const = 0;

    CV_WRAP virtual String getDefaultName() const CV_OVERRIDE;
};

/** @brief The adaptive FAST threshold of an image, variance over mean of the grey values: equation (7) of
@cite Yao2019AQORB.

Scales with the contrast: some 14 to 48 for photographs, a tenth of it for the same scene at a tenth
of the light.

@param image 8-bit image with 1, 3 (BGR) or 4 (BGRA) channels.
@param mask Optional CV_8UC1 mask of the image's size: only pixels where it is not zero count.
@return The threshold in grey levels, unrounded; 0 for an empty image, an image or mask that is all
zero, and an image of one grey value.
 */
CV_EXPORTS_W double adaptiveFastThreshold(InputArray image, InputArray mask = noArray());

/** @brief How uniformly keypoints are distributed: the measure u of Zu and Zhao @cite Zu2010Uniformity by which
@cite Yao2019AQORB compares detectors. Smaller is more uniform.

The image is halved in five ways: left/right, top/bottom, along each diagonal, centre/periphery. With
sigma the population standard deviation of the ten counts, u = 101 * log10(sigma). It sees the balance
between halves only (distributionOccupancy looks closer), and grows with the number of keypoints
where they cluster, so compare at equal numbers. Some values for 500 points: a jittered grid 30,
random points 101, all points in one half 216.

@param keypoints Keypoints of any detector; those whose position is not finite do not count.
@param imageSize Size of the image they were found in; both sides > 0.
@return u; 0 where sigma is below 1, that is for a distribution as even as whole counts allow, and
for no keypoints at all.
 */
CV_EXPORTS_W double distributionUniformity(const std::vector<KeyPoint>& keypoints, Size imageSize);

/** @brief The share of the cells of a grid over the image that hold at least one keypoint.

@param keypoints Keypoints of any detector; those outside the image do not count.
@param imageSize Size of the image they were found in; both sides > 0.
@param grid Number of columns and rows of the grid; both > 0, at most 2^24 cells.
@return Occupied cells over all cells, 0 to 1.
 */
CV_EXPORTS_W double distributionOccupancy(const std::vector<KeyPoint>& keypoints, Size imageSize,
                                          Size grid = Size(16, 12));

/** @brief Keeps the npoints keypoints that are spread best over the image, preferring high responses:
the selection of AdaptiveQuadtreeORB for the keypoints of any detector.

Beside cv::KeyPointsFilter::retainBest, which keeps the highest responses wherever they lie. The
quadtree spans the whole image; octaves are ignored. Ties in the response go to the keypoint of lower
y, then x, then index; NaN counts as the lowest response.

@param keypoints In: keypoints of any detector. Out: at most npoints of them, in their input order,
all fields untouched. Those outside the image are dropped, also where there are fewer than npoints.
@param imageSize Size of the image; both sides > 0.
@param npoints Number of keypoints to keep, >= 0.
 */
CV_EXPORTS_W void retainUniform(CV_IN_OUT std::vector<KeyPoint>& keypoints, Size imageSize, int npoints);

//! @}

}  // namespace aqorb
}  // namespace cv

#endif
