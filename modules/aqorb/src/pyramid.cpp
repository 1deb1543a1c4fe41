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

float levelScale(int level, int firstLevel, double scaleFactor)
{
    return float(std::pow(scaleFactor, double(level - firstLevel)));
}

Size levelSize(Size imageSize, float scale)
{
    const float inverse = 1.f / scale;
    const float width = imageSize.width * inverse, height = imageSize.height * inverse;
    const float limit = float((1 << 20) - 1);
    if (!(width <= limit && height <= limit))
        CV_Error_(Error::StsOutOfRange,
                  ("scaleFactor, firstLevel: a level of the pyramid would be %g x %g pixels; at most "
                   "%g a side is accepted",
                   width, height, limit));
    return Size(cvRound(width), cvRound(height));
}

std::vector<int> levelQuotas(int nfeatures, double scaleFactor, int nlevels)
{
    const float factor = float(1.0 / scaleFactor);
    float desired = nfeatures * (1 - factor) / (1 - float(std::pow(double(factor), double(nlevels))));
    std::vector<int> quotas(nlevels);
    int64 sum = 0;
    for (int level = 0; level < nlevels - 1; level++)
    {
        quotas[level] = cvRound(desired);
        sum += quotas[level];
        desired *= factor;
    }
    quotas[nlevels - 1] = int(std::max<int64>(nfeatures - sum, 0));
    // cv::ORB's rounding can ask for more than nfeatures; the finest levels have the most to give.
    int64 excess = sum + quotas[nlevels - 1] - nfeatures;
    for (int level = 0; excess > 0; level++)
    {
        const int taken = int(std::min<int64>(excess, quotas[level]));
        quotas[level] -= taken;
        excess -= taken;
    }
    return quotas;
}

// The two source pixels, as far as they have a weight, that INTER_LINEAR_EXACT makes a pixel of.
static Range linearTaps(int position, int sourceLength, double scale)
{
    const double center = scale * (position + 0.5) - 0.5;
    const int first = cvFloor(center);
    if (first < 0 || sourceLength == 1)
        return Range(0, 1);
    if (first >= sourceLength - 1)
        return Range(sourceLength - 1, sourceLength);
    const int weight = cvRound((center - first) * 256);  // of the second, in 1/256
    return weight == 0 ? Range(first, first + 1)
                       : Range(weight == 256 ? first + 1 : first, first + 2);
}

// A pixel is usable if all the pixels it is made of are.
static Mat resizeMask(const Mat& mask, Size size)
{
    const double scaleX = 1.0 / (double(size.width) / mask.cols);
    const double scaleY = 1.0 / (double(size.height) / mask.rows);
    std::vector<Range> columns(size.width);
    for (int x = 0; x < size.width; x++)
        columns[x] = linearTaps(x, mask.cols, scaleX);
    Mat resized(size, CV_8UC1);
    for (int y = 0; y < size.height; y++)
    {
        const Range rows = linearTaps(y, mask.rows, scaleY);
        const uchar* upper = mask.ptr(rows.start);
        const uchar* lower = mask.ptr(rows.end - 1);
        uchar* out = resized.ptr(y);
        for (int x = 0; x < size.width; x++)
        {
            const int left = columns[x].start, right = columns[x].end - 1;
            out[x] = upper[left] && upper[right] && lower[left] && lower[right] ? 255 : 0;
        }
    }
    return resized;
}

void buildPyramid(const Mat& image, const Mat& mask, int nlevels, int firstLevel, double scaleFactor,
                  int minSide, std::vector<Level>& levels)
{
    CV_TRACE_FUNCTION();
    levels.clear();
    for (int i = 0; i < nlevels; i++)
    {
        Level level;
        level.scale = levelScale(i, firstLevel, scaleFactor);
        const Size size = levelSize(image.size(), level.scale);
        if (std::min(size.width, size.height) < minSide)
            break;
        if (i == firstLevel)
        {
            level.image = image;
            level.mask = mask;
        }
        else
        {
            // cv::ORB makes the level after the image's, too, from the image
            const bool fromImage = i <= firstLevel + 1;
            const Mat& source = fromImage ? image : levels.back().image;
            const Mat& sourceMask = fromImage ? mask : levels.back().mask;
            resize(source, level.image, size, 0, 0, INTER_LINEAR_EXACT);
            if (!mask.empty())
                level.mask = resizeMask(sourceMask, size);
        }
        levels.push_back(level);
    }
}

}  // namespace stages
}  // namespace aqorb
}  // namespace cv
