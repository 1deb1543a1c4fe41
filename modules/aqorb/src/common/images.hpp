// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// Checks of callers' images, and their conversion to grey.

#ifndef OPENCV_AQORB_IMAGES_HPP
#define OPENCV_AQORB_IMAGES_HPP

#include <opencv2/core.hpp>

#include <vector>

namespace cv
{
namespace aqorb
{

//! Longest side of an image, and of a level of its pyramid.
const int MAX_LEVEL_SIDE = (1 << 20) - 1;

//! Whether the argument is a vector of images or of vectors, not one matrix.
bool isSequence(const _InputArray& array);

//! Throws unless grayImage can convert the image.
//! @param name argument name for the message
void checkImage(InputArray image, const char* name = "image");

//! Grey image: the input itself, or converted as cv::ORB does. Throws for other types.
//! @param memory buffer for the conversion; 0: allocates one
Mat grayImage(InputArray image, std::vector<uchar>* memory = 0);

//! Throws if the image is too large for a pyramid.
//! @param name argument name for the message
void checkPyramidInput(Size imageSize, const char* name = "image");

//! Second header of a UMat input, else an empty UMat. The caller holds it while it uses the UMat's Mat, so that nobody
//! frees the memory.
UMat retainUMat(InputArray input);

}  // namespace aqorb
}  // namespace cv

#endif
