// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#ifndef OPENCV_AQORB_TEST_GEOMETRY_HPP
#define OPENCV_AQORB_TEST_GEOMETRY_HPP

// Homographies, poses and affine maps for tests and tools. OpenCV 5 has moved them from the modules calib3d and imgproc to
// the module geometry.

#include <opencv2/core/version.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/opencv_modules.hpp>

#if CV_VERSION_MAJOR >= 5
#include <opencv2/geometry.hpp>
#elif defined(HAVE_OPENCV_CALIB3D)
#include <opencv2/calib3d.hpp>
#endif

#endif
