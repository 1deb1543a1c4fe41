// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// FAST thresholds of an image, by equation (7) of the paper.

#include "precomp.hpp"

#include "detector/arguments.hpp"
#include "common/for_each.hpp"
#include "detector/threshold.hpp"

#include <opencv2/aqorb.hpp>

namespace cv
{
namespace aqorb
{

double varianceOverMean(const Mat& image, const Mat& mask, int threads)
{
    CV_TRACE_FUNCTION();
    const int MIN_ROWS = 64;
    const int bands = std::max(std::min(threads, image.rows / MIN_ROWS), 1);
    struct Sums
    {
        double grays, squares, count;
    };
    std::vector<Sums> sums(bands);
    forEach(size_t(bands), threads,
            [&](size_t i, int)
            {
                const Range rows(int(int64(i) * image.rows / bands), int(int64(i + 1) * image.rows / bands));
                Mat used = image.rowRange(rows);
                double count = double(used.total());
                if (!mask.empty())
                {
                    used = Mat(used.size(), CV_8UC1, Scalar(0));
                    image.rowRange(rows).copyTo(used, mask.rowRange(rows));
                    count = countNonZero(mask.rowRange(rows));
                }
                sums[i] = {cv::sum(used)[0], used.dot(used), count};
            });
    // The sums are whole numbers, so the order of summation does not matter.
    Sums all = {};
    for (const Sums& band : sums)
        all = {all.grays + band.grays, all.squares + band.squares, all.count + band.count};
    // Equals (squares/n - (sum/n)^2) / (sum/n).
    return all.grays == 0 ? 0 : all.squares / all.grays - all.grays / all.count;
}

Thresholds fastThresholds(double contrast, int fastThreshold, double minRatio)
{
    fastThreshold = std::min(std::max(fastThreshold, 0), 255);
    const double ini = contrast * fastThreshold / NEUTRAL_CONTRAST;
    Thresholds thresholds;
    thresholds.ini = cvRound(std::min(std::max(ini, 1.), 254.));
    // The lower threshold is at most cv::ORB's. For a night scene with a few lamps equation (7) gives hundreds, and the
    // scene would keep corners only at the lamps.
    const double strictest = std::min(std::max(fastThreshold, 1), thresholds.ini);
    thresholds.min = cvRound(std::min(std::max(ini / minRatio, 1.), strictest));
    return thresholds;
}

double adaptiveFastThreshold(InputArray image, InputArray mask)
{
    if (image.empty())
        return 0;
    const Mat gray = grayImage(image);
    return varianceOverMean(gray, checkedMask(mask, gray.size()), stageThreads());
}

}  // namespace aqorb
}  // namespace cv
