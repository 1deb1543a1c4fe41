// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "data_files.hpp"

#include <cstdlib>

namespace opencv_test
{
using namespace cv;

static std::string fileIn(const char* variable, const std::string& name)
{
    const char* folder = std::getenv(variable);
    return folder && *folder ? std::string(folder) + "/" + name : std::string();
}

std::string dataFile(const std::string& name)
{
    return fileIn("OPENCV_TEST_DATA_PATH", name);
}

std::string sequenceFile(const std::string& name)
{
    return fileIn("AQORB_TEST_SEQUENCE", name);
}

static std::string oxfordFile(const std::string& set, const std::string& name)
{
    return dataFile("cv/detectors_descriptors_evaluation/images_datasets/" + set + "/" + name);
}

std::string oxfordImage(const std::string& set, int index)
{
    return oxfordFile(set, format("img%d.png", index));
}

Mat oxfordHomography(const std::string& set, int index)
{
    FileStorage file(oxfordFile(set, format("H1to%dp.xml", index)), FileStorage::READ);
    Mat homography;
    if (file.isOpened())
        file.getFirstTopLevelNode() >> homography;
    return homography;
}

}  // namespace opencv_test
