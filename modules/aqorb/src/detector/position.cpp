// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// Maps pixels of a level to positions that belong to them, and masks pixels without one.

#include "precomp.hpp"

#include "detector/position.hpp"

namespace cv
{
namespace aqorb
{

// Distance that a position keeps from the border between two pixels, where rounding changes, about `length` pixels from
// the first pixel. A position is rounded to a float, and scaling it back rounds twice: the scale and the product.
static double safetyMargin(int length)
{
    const double FLOAT_ERROR = 1. / (1 << 24);  // largest relative rounding error
    return std::max(0.01, 3 * FLOAT_ERROR * length);
}

// Moves a coordinate to the nearest value that belongs to a pixel of a level.
static float clampToPixel(double position, int pixel, int imageLength, double scale, int border)
{
    // The descriptor is computed at the pixel to which position / scale rounds: it must be the given pixel.
    const double most = 0.5 - safetyMargin(pixel), low = (pixel - most) * scale,
                 high = (pixel + most) * scale;
    // cv::ORB::compute drops keypoints near the border. Some versions of OpenCV first round the positions. In both
    // cases these positions stay off the border, unless the whole pixel of an enlarged level lies in it.
    const double last = imageLength - border - 0.5 - safetyMargin(imageLength);
    if (low <= last)
        position = std::min(position, last);
    if (high >= border)
        position = std::max(position, double(border));
    return float(std::max(std::min(position, high), low));
}

Point2f PositionMap::nearest(int x, int y, const Point2d& p) const
{
    return Point2f(clampToPixel(p.x, x, imageSize.width, scale, border),
                   clampToPixel(p.y, y, imageSize.height, scale, border));
}

Point2f PositionMap::operator()(int x, int y, double dx, double dy) const
{
    if (!subPixel)
        return Point2f(float(x) * scale, float(y) * scale);
    return nearest(x, y, scaleByCenters(x + dx, y + dy, levelSize, imageSize));
}

static int nearestPixel(float position, int length)
{
    return std::min(std::max(cvRound(position), 0), length - 1);
}

bool isUsable(const Mat& imageMask, const Point2f& position)
{
    return imageMask.at<uchar>(nearestPixel(position.y, imageMask.rows),
                               nearestPixel(position.x, imageMask.cols)) != 0;
}

bool usablePosition(const Mat& imageMask, const PositionMap& position, int x, int y, Point2f& found)
{
    const Point2f center = position(x, y);
    if (isUsable(imageMask, center))
    {
        found = center;
        return true;
    }
    if (!position.subPixel)
        return false;
    const Point2f first = position.nearest(x, y, Point2d(0, 0));
    const Point2f last = position.nearest(x, y, Point2d(imageMask.cols - 1, imageMask.rows - 1));
    double least = std::numeric_limits<double>::infinity();
    for (int row = cvFloor(first.y); row <= cvCeil(last.y); row++)
    {
        for (int column = cvFloor(first.x); column <= cvCeil(last.x); column++)
        {
            const Point2f candidate = position.nearest(x, y, Point2d(column, row));
            const double dx = candidate.x - center.x, dy = candidate.y - center.y;
            if (dx * dx + dy * dy < least && isUsable(imageMask, candidate))
            {
                least = dx * dx + dy * dy;
                found = candidate;
            }
        }
    }
    return least < std::numeric_limits<double>::infinity();
}

void maskPositions(const Mat& imageMask, const PositionMap& position, Mat& levelMask)
{
    std::vector<int> columns(levelMask.cols);
    for (int x = 0; x < levelMask.cols; x++)
        columns[x] = nearestPixel(position(x, 0).x, imageMask.cols);
    Point2f anywhere;
    for (int y = 0; y < levelMask.rows; y++)
    {
        const uchar* maskRow = imageMask.ptr(nearestPixel(position(0, y).y, imageMask.rows));
        uchar* out = levelMask.ptr(y);
        for (int begin = 0, end; begin < levelMask.cols; begin = end)
        {
            // Most runs have no masked pixel.
            const int AT_ONCE = 64;
            end = std::min(begin + AT_ONCE, levelMask.cols);
            if (!std::memchr(maskRow + columns[begin], 0, size_t(columns[end - 1] + 1 - columns[begin])))
                continue;
            for (int x = begin; x < end; x++)
                if (out[x] && !maskRow[columns[x]] && !usablePosition(imageMask, position, x, y, anywhere))
                    out[x] = 0;
        }
    }
}

}  // namespace aqorb
}  // namespace cv
