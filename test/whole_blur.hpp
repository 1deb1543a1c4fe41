// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#ifndef OPENCV_AQORB_TEST_WHOLE_BLUR_HPP
#define OPENCV_AQORB_TEST_WHOLE_BLUR_HPP

#include "blur.hpp"

namespace opencv_test
{

//! The rows of a matrix of type CV_16UC1.
inline aqorb::stages::BlurredRows rowsOf(const Mat& blurred)
{
    aqorb::stages::BlurredRows rows;
    rows.data = const_cast<ushort*>(blurred.ptr<ushort>());
    rows.step = ptrdiff_t(blurred.step1());
    return rows;
}

//! The approximate blur of a whole image, of which the module blurs parts only.
inline void approximateBlur(const Mat& image, Mat& blurred)
{
    aqorb::stages::BlurRegion everywhere;
    everywhere.begin(image.size());
    everywhere.add(Rect(Point(), image.size()));
    blurred.create(image.size(), CV_16UC1);
    aqorb::stages::BlurScratch scratch;
    aqorb::stages::approximateBlur(image, everywhere, Range(0, image.rows), rowsOf(blurred), scratch);
}

}  // namespace opencv_test

#endif
