// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// In place of the file of this name in OpenCV's build tree, which opencv2/core/cvdef.h includes under
// __OPENCV_BUILD. See cmake/AqorbDispatch.cmake.

#ifndef OPENCV_AQORB_CVCONFIG_H
#define OPENCV_AQORB_CVCONFIG_H

#define CV_ENABLE_INTRINSICS

#endif
