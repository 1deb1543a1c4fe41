// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "test_precomp.hpp"

// In a file of its own, so that programs which share test_util.cpp need no image codecs.

namespace opencv_test
{

std::vector<Mat> photographs()
{
    const std::string names[] = {oxfordImage("bikes", 1),      oxfordImage("leuven", 4),
                                 oxfordImage("bark", 1),       oxfordImage("trees", 2),
                                 oxfordImage("ubc", 6),        oxfordImage("graf", 3),
                                 dataFile("cv/shared/box.png")};
    std::vector<Mat> images;
    for (const std::string& name : names)
    {
        const Mat image = imread(name, IMREAD_GRAYSCALE);
        EXPECT_FALSE(image.empty()) << name;
        if (!image.empty())
            images.push_back(image);
    }
    return images;
}

}  // namespace opencv_test
