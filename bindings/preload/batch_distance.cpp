// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// cv::batchDistance for programs that are not to be changed: all the work of cv::BFMatcher is done by it.

#include "preload.hpp"

#include <opencv2/aqorb.hpp>

#include <cstdio>
#include <mutex>

namespace
{

using aqorb_preload::isVariableOn;

typedef void (*BatchDistance)(cv::InputArray, cv::InputArray, cv::OutputArray, int, cv::OutputArray, int, int,
                              cv::InputArray, int, bool);

BatchDistance originalBatchDistance()
{
    static const BatchDistance original = reinterpret_cast<BatchDistance>(
        aqorb_preload::originalOf(reinterpret_cast<void*>(BatchDistance(&cv::batchDistance))));
    if (!original)
        CV_Error(cv::Error::StsNotImplemented, "OpenCV's cv::batchDistance was not found");
    return original;
}

// Whether the arguments are those of a valid call for a Hamming norm. To others OpenCV says what is wrong with them.
bool isHammingCall(const cv::Mat& src1, const cv::Mat& src2, int dtype, bool hasIndices, int normType, int K,
                   const cv::Mat& mask, int update, bool crosscheck)
{
    return (normType == cv::NORM_HAMMING || normType == cv::NORM_HAMMING2) &&
           (dtype == -1 || dtype == CV_32S) && src1.dims == 2 && src2.dims == 2 && !src1.empty() &&
           !src2.empty() && src1.type() == CV_8UC1 && src2.type() == CV_8UC1 && src1.cols == src2.cols &&
           K >= 0 && hasIndices == (K > 0) &&
           (mask.empty() || (mask.type() == CV_8UC1 && mask.size() == cv::Size(src2.rows, src1.rows))) &&
           (!crosscheck || (std::min(K, src2.rows) == 1 && update == 0 && mask.empty()));
}

// Once a process, and only where it took place.
void noticeInterposition()
{
    static std::once_flag once;
    std::call_once(once, []
                   { std::fprintf(stderr, "aqorb: cv::batchDistance gives aqorb's Hamming distances\n"); });
}

}  // namespace

namespace cv
{

void batchDistance(InputArray src1, InputArray src2, OutputArray dist, int dtype, OutputArray nidx,
                   int normType, int K, InputArray mask, int update, bool crosscheck)
{
    if (isVariableOn("AQORB_DISABLE") || isVariableOn("AQORB_DISABLE_MATCHER") ||
        !isHammingCall(src1.getMat(), src2.getMat(), dtype, nidx.needed(), normType, K, mask.getMat(), update,
                       crosscheck))
    {
        originalBatchDistance()(src1, src2, dist, dtype, nidx, normType, K, mask, update, crosscheck);
        return;
    }
    if (isVariableOn("AQORB_VERBOSE"))
        noticeInterposition();
    aqorb::batchHammingDistance(src1, src2, dist, nidx, normType, K, mask, update, crosscheck);
}

}  // namespace cv
