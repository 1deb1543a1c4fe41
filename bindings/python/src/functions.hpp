// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// The functions of the module that need no detector.

#ifndef AQORB_PYTHON_FUNCTIONS_HPP
#define AQORB_PYTHON_FUNCTIONS_HPP

#include "arguments.hpp"

namespace aqorb_python
{

KeyPointsObject retainUniform(const KeyPointsObject& keypoints, const SizeObject& imageSize, int npoints);
double distributionUniformity(const KeyPointsObject& keypoints, const SizeObject& imageSize);
double distributionOccupancy(const KeyPointsObject& keypoints, const SizeObject& imageSize,
                             const SizeObject& grid);
double adaptiveFastThreshold(const OptionalArrayObject& image, const OptionalArrayObject& mask);
ArrayObject keypointsToArray(const KeyPointsObject& keypoints);
KeyPointTupleObject keypointsFromArray(const KeyPointsObject& keypoints);

}  // namespace aqorb_python

#endif
