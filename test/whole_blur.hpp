// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#ifndef OPENCV_AQORB_TEST_WHOLE_BLUR_HPP
#define OPENCV_AQORB_TEST_WHOLE_BLUR_HPP

#include "blur.hpp"

namespace opencv_test
{

const int BLUR_MARGIN = 61;  // wide enough for the patches of the tests, and a blurMargin

//! The rows of a matrix of type CV_16UC1, which is a part of a larger one that has the margin, too.
inline aqorb::BlurredRows rowsOf(const Mat& blurred)
{
    return {const_cast<ushort*>(blurred.ptr<ushort>()), ptrdiff_t(blurred.step1()), 0};
}

//! The matrix with the margin around it.
inline Mat withMargin(Mat blurred)
{
    const int margin = BLUR_MARGIN;
    return blurred.adjustROI(margin, margin, margin, margin);
}

//! A matrix with a margin around it.
inline Mat blurredOf(Size size, int value = 0)
{
    const int margin = BLUR_MARGIN;
    const Mat all(size + Size(2 * margin, 2 * margin), CV_16UC1, Scalar(value));
    return all(Rect(Point(margin, margin), size));
}

//! The approximate blur of a whole image, of which the module blurs parts only, and of the margin around it.
inline void approximateBlur(const Mat& image, Mat& blurred, bool isExact = false)
{
    const int margin = BLUR_MARGIN;
    aqorb::BlurRegion everywhere;
    everywhere.reset(image.size(), BLUR_MARGIN);
    everywhere.addDisc(Point(), std::vector<int>(image.cols + BLUR_MARGIN + 1, image.rows + BLUR_MARGIN));
    blurred = blurredOf(image.size());
    std::vector<uchar> scratch;
    aqorb::approximateBlur(image, everywhere, Range(-margin, image.rows + margin), rowsOf(blurred), scratch,
                           isExact);
}

}  // namespace opencv_test

#endif
