// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// The keypoints and descriptors that callers get.

#ifndef OPENCV_AQORB_OUTPUT_HPP
#define OPENCV_AQORB_OUTPUT_HPP

#include "types.hpp"

namespace cv
{
namespace aqorb
{

//! Gives the features of all levels: by level, and those of a level by their output keys and then in raster order.
//! @param descriptors a row for each feature; empty: they are not wanted
void outputFeatures(const std::vector<FeatureList>& features, std::vector<KeyPoint>& keypoints,
                    Mat& descriptors);

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
