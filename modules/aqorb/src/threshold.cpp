// This file is part of the aqorb project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.

#include "precomp.hpp"

namespace cv
{
namespace aqorb
{
namespace stages
{

double varianceOverMean(const Mat& image, const Mat& mask)
{
    CV_TRACE_FUNCTION();
    // Whole sums: the same for any order of summation, so for any number of threads.
    uint64 sum = 0, squares = 0, count = 0;
    for (int y = 0; y < image.rows; y++)
    {
        const uchar* row = image.ptr(y);
        const uchar* use = mask.empty() ? NULL : mask.ptr(y);
        unsigned rowSum = 0;
        for (int x = 0; x < image.cols; x++)
        {
            if (use && !use[x])
                continue;
            rowSum += row[x];
            squares += unsigned(row[x]) * row[x];
            count++;
        }
        sum += rowSum;
    }
    if (sum == 0)
        return 0;
    // (squares/n - (sum/n)^2) / (sum/n)
    return double(squares) / double(sum) - double(sum) / double(count);
}

static Thresholds thresholdsFor(double ini, int fastThreshold, double minRatio)
{
    Thresholds thresholds;
    thresholds.ini = cvRound(std::min(std::max(ini, 1.), 254.));
    // Never stricter than cv::ORB: a night scene with a few lamps has equation (7) in the hundreds.
    const double loosest = std::min(std::max(fastThreshold, 1), thresholds.ini);
    thresholds.min = cvRound(std::min(std::max(ini / minRatio, 1.), loosest));
    return thresholds;
}

static int limitToGrey(int fastThreshold)
{
    return std::min(std::max(fastThreshold, 0), 255);
}

Thresholds adaptiveThresholds(double varianceOverMean, int fastThreshold, double minRatio)
{
    const int fast = limitToGrey(fastThreshold);
    return thresholdsFor(varianceOverMean * fast / 20, fast, minRatio);
}

Thresholds fixedThresholds(int fastThreshold, double minRatio)
{
    const int fast = limitToGrey(fastThreshold);
    return thresholdsFor(fast, fast, minRatio);
}

}  // namespace stages

double adaptiveFastThreshold(InputArray image, InputArray mask)
{
    if (image.empty())
        return 0;
    const Mat gray = stages::grayImage(image);
    return stages::varianceOverMean(gray, stages::checkedMask(mask, gray.size()));
}

}  // namespace aqorb
}  // namespace cv
