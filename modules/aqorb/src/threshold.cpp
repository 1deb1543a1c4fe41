// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// The FAST thresholds of an image, by equation (7) of the paper.

#include "precomp.hpp"

#include "arguments.hpp"
#include "threshold.hpp"

#include <opencv2/aqorb.hpp>

namespace cv
{
namespace aqorb
{

double varianceOverMean(const Mat& image, const Mat& mask)
{
    CV_TRACE_FUNCTION();
    Mat used = image;
    if (!mask.empty())
    {
        used = Mat(image.size(), CV_8UC1, Scalar(0));
        image.copyTo(used, mask);
    }
    // The sums are whole numbers, so they are the same for any order of summation.
    const double sum = cv::sum(used)[0], count = mask.empty() ? double(image.total()) : countNonZero(mask);
    if (sum == 0)
        return 0;
    // This is (squares/n - (sum/n)^2) / (sum/n).
    return used.dot(used) / sum - sum / count;
}

Thresholds fastThresholds(double value, int fastThreshold, double minRatio)
{
    fastThreshold = std::min(std::max(fastThreshold, 0), 255);
    const double ini = value * fastThreshold / NEUTRAL_CONTRAST;
    Thresholds thresholds;
    thresholds.ini = cvRound(std::min(std::max(ini, 1.), 254.));
    // The lower threshold is never stricter than that of cv::ORB. For a night scene with a few lamps equation (7)
    // gives hundreds, and corners off the lamps would be lost.
    const double strictest = std::min(std::max(fastThreshold, 1), thresholds.ini);
    thresholds.min = cvRound(std::min(std::max(ini / minRatio, 1.), strictest));
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
