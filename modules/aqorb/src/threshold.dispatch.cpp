// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "precomp.hpp"

#include "input.hpp"
#include "threshold.hpp"

#include "threshold.simd.hpp"
#include "threshold.simd_declarations.hpp"

#include <opencv2/aqorb.hpp>

namespace cv
{
namespace aqorb
{

static void addRows(const Mat& image, uint64& sum, uint64& squares)
{
    CV_CPU_DISPATCH(sumRows, (image.ptr(), ptrdiff_t(image.step), image.cols, image.rows, sum, squares),
                    CV_CPU_DISPATCH_MODES_ALL);
}

double varianceOverMean(const Mat& image, const Mat& mask)
{
    CV_TRACE_FUNCTION();
    // The sums are whole numbers, so they are the same for any order of summation.
    uint64 sum = 0, squares = 0, count = 0;
    if (mask.empty())
    {
        addRows(image, sum, squares);
        count = uint64(image.total());
    }
    for (int y = 0; y < image.rows && !mask.empty(); y++)
    {
        const uchar* row = image.ptr(y);
        const uchar* use = mask.ptr(y);
        for (int x = 0; x < image.cols; x++)
        {
            if (use[x])
            {
                sum += row[x];
                squares += unsigned(row[x]) * row[x];
                count++;
            }
        }
    }
    if (sum == 0)
        return 0;
    // This is (squares/n - (sum/n)^2) / (sum/n).
    return double(squares) / double(sum) - double(sum) / double(count);
}

Thresholds fastThresholds(double value, int fastThreshold, double minRatio)
{
    fastThreshold = std::min(std::max(fastThreshold, 0), 255);
    const double ini = value * fastThreshold / NEUTRAL_VALUE;
    Thresholds thresholds;
    thresholds.ini = cvRound(std::min(std::max(ini, 1.), 254.));
    // The lower threshold is never stricter than that of cv::ORB. For a night scene with a few lamps equation (7)
    // gives hundreds, and corners off the lamps would be lost.
    const double loosest = std::min(std::max(fastThreshold, 1), thresholds.ini);
    thresholds.min = cvRound(std::min(std::max(ini / minRatio, 1.), loosest));
    return thresholds;
}

double adaptiveFastThreshold(InputArray image, InputArray mask)
{
    if (image.empty())
        return 0;
    const Mat gray = grayImage(image);
    return varianceOverMean(gray, checkedMask(mask, gray.size()));
}

}  // namespace aqorb
}  // namespace cv
