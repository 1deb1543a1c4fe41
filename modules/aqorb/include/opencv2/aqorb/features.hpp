// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#ifndef OPENCV_AQORB_FEATURES_HPP
#define OPENCV_AQORB_FEATURES_HPP

#include <opencv2/core/version.hpp>

// OpenCV 5 renamed the module features2d to features. OpenCV's own build must not use the header of the old name.
#if CV_VERSION_MAJOR >= 5
#include <opencv2/features.hpp>
#else
#include <opencv2/features2d.hpp>
#endif

#endif
