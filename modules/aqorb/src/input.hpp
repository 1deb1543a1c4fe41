// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#ifndef OPENCV_AQORB_INPUT_HPP
#define OPENCV_AQORB_INPUT_HPP

#include <opencv2/core.hpp>

#include <vector>

namespace cv
{
namespace aqorb
{
namespace stages
{

//! Throws unless the input is an image that can be converted to grey.
void checkImage(InputArray image);

//! The grey image: the input itself, or its conversion as cv::ORB converts it. Throws for any other type of image.
//! @param memory for the conversion; 0: the conversion gets memory of its own
Mat grayImage(InputArray image, std::vector<uchar>* memory = 0);

//! Throws for an image that is too large for a pyramid.
void checkPyramidInput(Size imageSize);

//! A second header of the input if it is a UMat, else an empty one. The caller keeps it for as long as it uses the
//! UMat's Mat, so that nothing frees the UMat meanwhile.
UMat heldUMat(InputArray input);

//! Throws unless both sides are > 0.
void checkImageSize(Size imageSize);

//! The mask, or an empty Mat where there is none. Throws for a mask of another size or type.
Mat checkedMask(InputArray mask, Size imageSize);

//! The images and masks of a collection. They are mapped to memory here, by the thread that calls.
struct Collection
{
    //! Throws unless there is one mask for each image, or none at all.
    explicit Collection(InputArrayOfArrays images, InputArrayOfArrays masks = noArray());
    Mat mask(size_t index) const { return masks.empty() ? Mat() : masks[index]; }

    std::vector<UMat> held;
    std::vector<Mat> images, masks;
};

//! Throws unless the output can hold several matrices of bytes.
void checkMatsOutput(OutputArrayOfArrays output, const char* name);

//! Puts the matrices into the output. Throws if it has a fixed number of them, and that is another one.
void giveMats(const std::vector<Mat>& mats, OutputArrayOfArrays output, const char* name);

//! Throws unless the output is a single one that can hold CV_8UC1. Its size is checked by the two functions below.
void checkDescriptorsOutput(OutputArray descriptors);

//! Makes the output a matrix of a row for each keypoint. Throws if its size is fixed to another one.
Mat createDescriptors(OutputArray descriptors, int count);

//! Empties the output. Throws if its size is fixed to another one.
void releaseDescriptors(OutputArray descriptors);

//! The highest octave of keypoints that are given to be described; 0 for no keypoints. Throws where an octave is
//! negative or an angle is not finite.
int highestOctave(const std::vector<KeyPoint>& keypoints);

//! Of keypoints that are given to be described, those that cv::ORB describes. The others lie outside of the image or
//! nearer than `edgeThreshold` to its border.
void describableKeypoints(const std::vector<KeyPoint>& keypoints, Size imageSize, int edgeThreshold,
                          std::vector<KeyPoint>& describable);

}  // namespace stages
}  // namespace aqorb
}  // namespace cv

#endif
