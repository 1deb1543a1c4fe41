// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#ifndef OPENCV_AQORB_SLAM_HPP
#define OPENCV_AQORB_SLAM_HPP

#include <opencv2/aqorb.hpp>

#include <algorithm>
#include <climits>
#include <cmath>

namespace cv
{
namespace aqorb
{

//! @addtogroup aqorb
//! @{

/** @brief AdaptiveQuadtreeORB with the interface of the feature extractor of ORB-SLAM2 and ORB-SLAM3; see
@ref tutorial_aqorb_slam.

A SLAM system includes this header in place of the header of `ORBextractor`, and writes
@code{.cpp}
    #include <opencv2/aqorb/slam.hpp>
    namespace ORB_SLAM3
    {
    using ORBextractor = cv::aqorb::SlamExtractor;
    }
@endcode

The extractor returns one extra keypoint for each level, nfeatures + nlevels in all, or as many as the image has
corners. ORB-SLAM2 starts only on a frame with more than 500 keypoints. If it asked for 500 features and got at most
500, as from AdaptiveQuadtreeORB, it would never start.

The extractor sets five properties of the detector for SLAM systems. SubPixel is false, because their stereo matching
subtracts a whole pixel of the level times its scale from the position of the left keypoint: with positions mapped by
pixel centres, disparities would be too large by (scale - 1) / 2 pixels. AdaptiveThreshold is false, so FAST takes the
given thresholds. OctaveSuppression is 0, because a single camera starts from keypoints of the finest level only, and
the best of them often lie near keypoints of a coarser level. StrengthWeight is 0.15, because stronger corners reappear
in more frames, at the cost of a slightly less even distribution. RankRadius is 2.25, because more points then stay in
view and paths are more exact. detector() gives access to all properties.

A dark or low-contrast image may have fewer than nfeatures corners at the given thresholds. If equation (7) gives a
value below 20 for this image (adaptiveFastThreshold()), the extractor searches the image again, with both thresholds
scaled by this value over 20, as with AdaptiveThreshold.

The extractor works on the calling thread alone, because SLAM systems call it from threads of their own. On a busy core,
waiting for another thread takes longer than its share of the work.

An object keeps the pyramid of its last image, so only one thread at a time may use it. Create one object for each
camera. A copy shares the detector() of the original, with its properties, but has its own vector of levels.
 */
class SlamExtractor
{
public:
    /** @brief Creates the extractor. Invalid values raise a cv::Exception.

    @param nfeatures The number of keypoints, >= 0. There can be up to nlevels more. With 0 there are none.
    @param scaleFactor Ratio between the sizes of neighbouring levels, finite, and > 1 if there are several levels.
    @param nlevels Number of pyramid levels, 1 to 65536.
    @param iniThFAST FAST threshold, 1 to 254.
    @param minThFAST FAST threshold in cells without a corner at iniThFAST, 1 to iniThFAST.
     */
    SlamExtractor(int nfeatures, float scaleFactor, int nlevels, int iniThFAST, int minThFAST)
    {
        if (iniThFAST < 1 || iniThFAST > 254)
            CV_Error_(Error::StsOutOfRange, ("iniThFAST must be from 1 to 254, got %d", iniThFAST));
        if (minThFAST < 1 || minThFAST > iniThFAST)
            CV_Error_(Error::StsOutOfRange, ("minThFAST must be from 1 to iniThFAST, got %d", minThFAST));
        orb = AdaptiveQuadtreeORB::create(withSurplus(nfeatures, nlevels), scaleFactor, nlevels);
        orb->setFastThreshold(iniThFAST);
        orb->setMinThresholdRatio(double(iniThFAST) / minThFAST);
        setForSlam(*orb);
        for (int level = 0; level < nlevels; level++)
        {
            const float scale = float(std::pow(double(scaleFactor), level));
            scales.push_back(scale);
            inverseScales.push_back(1.f / scale);
            sigmaSquares.push_back(scale * scale);
            inverseSigmaSquares.push_back(1.f / (scale * scale));
        }
    }

    /** @brief Finds keypoints and descriptors, and keeps the pyramid. ORB-SLAM2 calls this operator.

    @param image 8-bit image with 1, 3 (BGR) or 4 (BGRA) channels. An empty image gives no keypoints.
    @param mask Optional CV_8UC1 mask of the size of the image. Keypoints are found only where it is not zero. If it is
    empty, the mask of setMask() takes its place.
    @param keypoints By level, and within a level by response; coordinates in pixels of the image.
    @param descriptors CV_8UC1, one row of 32 bytes for each keypoint.
     */
    void operator()(InputArray image, InputArray mask, std::vector<KeyPoint>& keypoints,
                    OutputArray descriptors)
    {
        // A new vector for the pyramid, because the image may be a level of the last pyramid.
        std::vector<Mat> pyramid;
        const SingleThreadScope alone;
        const _InputArray usedMask = mask.empty() ? _InputArray(fixedMask) : mask;
        orb->detectAndComputeWithPyramid(image, usedMask, keypoints, descriptors, pyramid);
        if (!pyramid.empty() && !orb->getAdaptiveThreshold() &&
            int(keypoints.size()) < orb->getMaxFeatures() && adaptiveFastThreshold(pyramid[0], usedMask) < 20)
            withAdaptiveThreshold().detectAndCompute(pyramid[0], usedMask, keypoints, descriptors);
        pyramid.resize(scales.size());
        mvImagePyramid.swap(pyramid);
    }

    /** @brief Finds keypoints and descriptors for two cameras whose images overlap. ORB-SLAM3 calls this operator.

    @param image, mask, keypoints, descriptors As above, but keypoints outside the overlap come before keypoints inside.
    Each part comes by level, and within a level by response.
    @param vLappingArea First and last column of the overlap, in pixels of the image.
    @return Number of keypoints outside the overlap.
     */
    int operator()(InputArray image, InputArray mask, std::vector<KeyPoint>& keypoints,
                   OutputArray descriptors, const std::vector<int>& vLappingArea)
    {
        if (vLappingArea.size() != 2)
            CV_Error_(Error::StsBadSize,
                      ("vLappingArea must be the first and the last column, got %d numbers",
                       int(vLappingArea.size())));
        const float first = float(vLappingArea[0]), last = float(vLappingArea[1]);
        std::vector<KeyPoint> found;
        (*this)(image, mask, found, descriptors);
        Mat parted = descriptors.needed() ? descriptors.getMat() : Mat();
        const Mat rows = parted.clone();

        const auto isOutside = [=](const KeyPoint& k) { return k.pt.x < first || k.pt.x > last; };
        const int outside = int(std::count_if(found.begin(), found.end(), isOutside));
        keypoints.resize(found.size());
        int next[] = {outside, 0};  // next index for a keypoint inside the overlap, and outside
        for (int i = 0; i < int(found.size()); i++)
        {
            const int to = next[isOutside(found[i])]++;
            keypoints[to] = found[i];
            if (!rows.empty())
                rows.row(i).copyTo(parted.row(to));
        }
        return outside;
    }

    /** @brief Sets a mask for all calls whose own mask is empty, for example to exclude the car's bonnet and the sky.

    @param mask CV_8UC1, copied. It must have the size of the images; otherwise the call raises a cv::Exception that
    names both sizes. An empty mask removes the mask. */
    void setMask(const Mat& mask) { fixedMask = mask.clone(); }

    //! Frees the work space of the detector and the pyramid of the last image.
    void releaseMemory()
    {
        orb->releaseMemory();
        adaptive.reset();
        mvImagePyramid.clear();
    }

    //! Number of pyramid levels.
    int GetLevels() const { return int(scales.size()); }
    //! Ratio between the sizes of neighbouring levels.
    float GetScaleFactor() const { return float(orb->getScaleFactor()); }
    //! Size of a pixel of each level in pixels of the image: scaleFactor^level.
    std::vector<float> GetScaleFactors() const { return scales; }
    //! Inverses of GetScaleFactors.
    std::vector<float> GetInverseScaleFactors() const { return inverseScales; }
    //! Squares of the scale factors: variances of positions on each level, relative to level 0.
    std::vector<float> GetScaleSigmaSquares() const { return sigmaSquares; }
    //! Inverses of GetScaleSigmaSquares.
    std::vector<float> GetInverseScaleSigmaSquares() const { return inverseSigmaSquares; }

    /** @brief The detector, to set its other properties. Its getMaxFeatures() is nfeatures + nlevels. Do not change its
    number of levels, its scale factor or its firstLevel of 0. */
    const Ptr<AdaptiveQuadtreeORB>& detector() const { return orb; }

    /** @brief Levels of the last image: GetLevels() images without a border, with the sizes of
    AdaptiveQuadtreeORB::buildPyramid. A level without a pixel is empty. */
    std::vector<Mat> mvImagePyramid;

private:
    //! Adds one keypoint for each level. Passes invalid values on, because create names them.
    static int withSurplus(int nfeatures, int nlevels)
    {
        if (nfeatures <= 0 || nlevels <= 0)
            return nfeatures;
        return nfeatures < INT_MAX - nlevels ? nfeatures + nlevels : INT_MAX;
    }

    //! Sets the properties that differ from the detector's defaults, see above.
    static void setForSlam(AdaptiveQuadtreeORB& orb)
    {
        orb.setAdaptiveThreshold(false);
        orb.setSubPixel(false);
        orb.setOctaveSuppression(0);
        orb.setStrengthWeight(0.15);
        orb.setRankRadius(2.25);
    }

    //! A detector with the properties of detector(), and with AdaptiveThreshold.
    AdaptiveQuadtreeORB& withAdaptiveThreshold()
    {
        FileStorage properties("", FileStorage::WRITE | FileStorage::MEMORY | FileStorage::FORMAT_JSON);
        orb->write(properties);
        if (!adaptive)
            adaptive = AdaptiveQuadtreeORB::create();
        adaptive->read(
            FileStorage(properties.releaseAndGetString(), FileStorage::READ | FileStorage::MEMORY).root());
        adaptive->setAdaptiveThreshold(true);
        return *adaptive;
    }

    Ptr<AdaptiveQuadtreeORB> orb, adaptive;
    Mat fixedMask;
    std::vector<float> scales, inverseScales, sigmaSquares, inverseSigmaSquares;
};

//! @}

}  // namespace aqorb
}  // namespace cv

#endif
