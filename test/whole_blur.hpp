// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#ifndef OPENCV_AQORB_TEST_WHOLE_BLUR_HPP
#define OPENCV_AQORB_TEST_WHOLE_BLUR_HPP

#include "blur.hpp"

namespace opencv_test
{

//! The approximate blur of a whole image, of which the module blurs parts only.
inline void approximateBlur(const Mat& image, Mat& blurred)
{
    aqorb::stages::BlurRegion everywhere;
    everywhere.begin(image.size());
    everywhere.add(Rect(Point(), image.size()));
    blurred.create(image.size(), CV_16UC1);
    aqorb::stages::BlurScratch scratch;
    aqorb::stages::approximateBlur(image, everywhere, blurred, scratch);
}

}  // namespace opencv_test

#endif
