// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#ifndef OPENCV_AQORB_TEST_DATA_FILES_HPP
#define OPENCV_AQORB_TEST_DATA_FILES_HPP

#include <opencv2/core.hpp>

#include <string>

// Where the files of opencv_extra are. This needs neither test framework, so that tools/ uses it, too.

namespace opencv_test
{

//! Path of a file of opencv_extra's testdata; empty where OPENCV_TEST_DATA_PATH is not set.
std::string dataFile(const std::string& name);
//! Path of image `index` (1 to 6) of an Oxford set: bikes, leuven, bark, trees, ubc or graf.
std::string oxfordImage(const std::string& set, int index);

}  // namespace opencv_test

#endif
