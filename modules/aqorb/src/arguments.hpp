// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// The images, masks and keypoints that callers give, the outputs that they get, and the checks of both.

#ifndef OPENCV_AQORB_ARGUMENTS_HPP
#define OPENCV_AQORB_ARGUMENTS_HPP

#include "parameters.hpp"
#include "types.hpp"

#include <opencv2/core.hpp>

#include <vector>

namespace cv
{
namespace aqorb
{

//! Throws unless the input is an image that can be converted to grey.
//! @param name of the argument
void checkImage(InputArray image, const char* name = "image");

//! The grey image: the input itself, or its conversion as cv::ORB converts it. Throws for any other type of image.
//! @param memory for the conversion; 0: the conversion gets memory of its own
Mat grayImage(InputArray image, std::vector<uchar>* memory = 0);

//! Throws for an image that is too large for a pyramid.
//! @param name of the argument
void checkPyramidInput(Size imageSize, const char* name = "image");

//! A second header of the input if it is a UMat, else an empty one. The caller keeps it for as long as it uses the
//! UMat's Mat, so that nothing frees the UMat meanwhile.
UMat retainUMat(InputArray input);

//! Throws unless both sides are > 0.
void checkImageSize(Size imageSize);

//! The mask, or an empty Mat where there is none. Throws for a mask of another size or type.
Mat checkedMask(InputArray mask, Size imageSize);

//! The images and masks of a collection. A UMat among them is mapped to memory by the thread that makes this object.
struct Collection
{
    //! Throws unless there is one mask for each image, or none at all.
    explicit Collection(InputArrayOfArrays images, InputArrayOfArrays masks = noArray());
    Mat mask(size_t index) const { return masks.empty() ? Mat() : masks[index]; }

    std::vector<UMat> held;
    std::vector<Mat> images, masks;
};

//! Whether the argument is a vector of images, or of vectors, where one matrix is wanted.
bool isSequence(const _InputArray& array);

//! Throws unless the argument is a vector of Mat or UMat.
void checkIsOfMats(const _InputArray& array, const char* name);

/** The given keypoints that cv::ORB::compute describes, and the pixels at which it describes them: a list for each
 level, up to their highest octave. Throws where an octave is negative or has no pixels, or an angle is not finite. */
std::vector<FeatureList> groupGivenKeypoints(const std::vector<KeyPoint>& keypoints,
                                             const Parameters& parameters, Size imageSize);

//! Throws unless the output can hold several matrices of bytes.
void checkMatsOutput(OutputArrayOfArrays output, const char* name);

//! Puts the matrices into the output. Throws if the output is fixed to another number of them.
void assignMats(const std::vector<Mat>& mats, OutputArrayOfArrays output, const char* name);

//! Throws unless the output is a single one that can hold CV_8UC1. Its size is checked by the function below.
void checkDescriptorsOutput(OutputArray descriptors);

//! Makes the output a matrix of a row for each keypoint, empty for none. Throws if its size is fixed to another one.
Mat createDescriptors(OutputArray descriptors, int count);

}  // namespace aqorb
}  // namespace cv

#endif
