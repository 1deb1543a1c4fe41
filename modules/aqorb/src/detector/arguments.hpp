// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// Checks of the callers' masks, collections and output arguments.

#ifndef OPENCV_AQORB_ARGUMENTS_HPP
#define OPENCV_AQORB_ARGUMENTS_HPP

#include "common/images.hpp"

#include <opencv2/core.hpp>

#include <vector>

namespace cv
{
namespace aqorb
{

//! Throws unless both sides are > 0.
void checkImageSize(Size imageSize);

//! Mask as a Mat, empty without a mask. Throws if its size differs from the image's or its type is not CV_8UC1.
Mat checkedMask(InputArray mask, Size imageSize);

//! Images and masks of a collection. The constructing thread maps UMats to memory.
struct Collection
{
    //! Throws unless each image has a mask, or none has.
    explicit Collection(InputArrayOfArrays images, InputArrayOfArrays masks = noArray());
    Mat mask(size_t index) const { return masks.empty() ? Mat() : masks[index]; }

    std::vector<UMat> retained;
    std::vector<Mat> images, masks;
};

//! Throws unless the output can hold a vector of CV_8UC1 matrices.
void checkMatsOutput(OutputArrayOfArrays output, const char* name);

//! Assigns the matrices to the output. Throws if the output has another, fixed number of elements.
void assignMats(const std::vector<Mat>& mats, OutputArrayOfArrays output, const char* name);

//! Throws unless the output can hold one CV_8UC1 matrix. createDescriptors checks its size.
void checkDescriptorsOutput(OutputArray descriptors);

//! Allocates the output with one row for each keypoint, empty for none. Throws if the output has another, fixed size.
Mat createDescriptors(OutputArray descriptors, int count);

}  // namespace aqorb
}  // namespace cv

#endif
