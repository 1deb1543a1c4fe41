// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "data_files.hpp"

#include <cstdlib>

namespace opencv_test
{
using namespace cv;

std::string dataFile(const std::string& name)
{
    const char* const folder = std::getenv("OPENCV_TEST_DATA_PATH");
    return folder && *folder ? std::string(folder) + "/" + name : std::string();
}

std::string oxfordImage(const std::string& set, int index)
{
    return dataFile(
        format("cv/detectors_descriptors_evaluation/images_datasets/%s/img%d.png", set.c_str(), index));
}

}  // namespace opencv_test
