// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// Positions in the image, and the description of features from the top of a level to its bottom.

#include "precomp.hpp"

#include "description.hpp"

#include "fast.hpp"

namespace cv
{
namespace aqorb
{

// ---- positions --------------------------------------------------------------------------------

// How far positions about `length` pixels from the first pixel stay off the places between two pixels, where rounding
// changes. A position is rounded to a float, and scaling it back rounds twice: the scale and the product.
static double safetyMargin(int length)
{
    const double FLOAT_ERROR = 1. / (1 << 24);  // at most, relative
    return std::max(0.01, 3 * FLOAT_ERROR * length);
}

// Moves a position along one axis to where a keypoint belongs to a pixel of a level.
static float clampToPixel(double position, int pixel, int imageLength, double scale, int border)
{
    // The descriptor is taken at the pixel that position / scale rounds to. It must be the pixel given.
    const double most = 0.5 - safetyMargin(pixel), low = (pixel - most) * scale,
                 high = (pixel + most) * scale;
    // cv::ORB::compute drops keypoints near the border. Whether it first rounds positions depends on
    // the version of OpenCV. These positions stay off the border in both cases, unless the whole pixel lies in it, as
    // pixels of an enlarged level can.
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
    return nearest(x, y,
                   Point2d((x + dx + 0.5) * imageSize.width / levelSize.width - 0.5,
                           (y + dy + 0.5) * imageSize.height / levelSize.height - 0.5));
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
        const uchar* use = imageMask.ptr(nearestPixel(position(0, y).y, imageMask.rows));
        uchar* out = levelMask.ptr(y);
        if (!std::memchr(use, 0, size_t(imageMask.cols)))
            continue;
        for (int begin = 0, end; begin < levelMask.cols; begin = end)
        {
            // Hardly any pixel needs a closer look.
            const int AT_ONCE = 64;
            end = std::min(begin + AT_ONCE, levelMask.cols);
            int masked = 0;
            for (int x = begin; x < end; x++)
                masked |= out[x] & (use[columns[x]] ? 0 : 255);
            for (int x = begin; x < end && masked; x++)
                if (out[x] && !use[columns[x]] && !usablePosition(imageMask, position, x, y, anywhere))
                    out[x] = 0;
        }
    }
}

Point2d subPixelOffset(const Mat& image, int x, int y)
{
    int s[3][3];
    cornerScores3x3(image, x, y, s);

    // Derivatives by central differences. As whole numbers they are twice the gradient and four times dxy.
    const int gx2 = s[1][2] - s[1][0], gy2 = s[2][1] - s[0][1];
    const int dxx = s[1][2] - 2 * s[1][1] + s[1][0], dyy = s[2][1] - 2 * s[1][1] + s[0][1];
    const int dxy4 = s[2][2] - s[2][0] - s[0][2] + s[0][0];
    const int determinant16 = 16 * dxx * dyy - dxy4 * dxy4;
    if (dxx >= 0 || determinant16 <= 0)  // no peak
        return Point2d(0, 0);
    // The peak is at minus the inverse of the Hessian times the gradient.
    const double px = 2. * (dxy4 * gy2 - 4 * dyy * gx2) / determinant16;
    const double py = 2. * (dxy4 * gx2 - 4 * dxx * gy2) / determinant16;
    return Point2d(std::min(std::max(px, -0.5), 0.5), std::min(std::max(py, -0.5), 0.5));
}

// ---- features ---------------------------------------------------------------------------------

std::vector<FeatureRange> divideIntoRanges(const std::vector<FeatureList>& features, int threads)
{
    const size_t LEAST = 64;
    size_t all = 0;
    for (const FeatureList& list : features)
        all += list.points.size();
    const size_t most = threads == 1 ? all + 1 : std::max(all / (4 * threads), LEAST);
    std::vector<FeatureRange> ranges;
    for (size_t level = 0; level < features.size(); level++)
    {
        const size_t count = features[level].points.size(), parts = (count + most - 1) / most;
        for (size_t i = 0; i < parts; i++)
            ranges.push_back({int(level), Range(int(count * i / parts), int(count * (i + 1) / parts))});
    }
    return ranges;
}

// Finds the directions of features and completes their keypoints.
static void findKeypoints(const Level& level, const DescriptionRules& rules, size_t begin, size_t end,
                          FeatureList& list)
{
    CV_TRACE_FUNCTION();
    const Mat &image = level.image, &mask = *rules.imageMask;
    const bool subPixel = rules.position.subPixel;
    orientations(image, *rules.patch, &list.points[begin], end - begin);
    for (size_t i = begin; i < end; i++)
    {
        const FeaturePoint& point = list.points[i];
        KeyPoint& keypoint = list.keypoints[i];
        const Point2d offset = subPixel ? subPixelOffset(image, point.x, point.y) : Point2d();
        keypoint.pt = rules.position(point.x, point.y, offset.x, offset.y);
        keypoint.angle = point.angle;
        if (subPixel && !mask.empty() && !isUsable(mask, keypoint.pt))
            usablePosition(mask, rules.position, point.x, point.y, keypoint.pt);
    }
}

void describeFeatures(const Level& level, const DescriptionRules& rules, const Range& features,
                      FeatureList& list, DescriptionScratch& scratch)
{
    const size_t end = size_t(features.end);
    if (rules.patch)
        findKeypoints(level, rules, size_t(features.start), end, list);
    if (!rules.tests)
        return;
    const int ROWS = 128;  // that are blurred at once; more would be faster, and take more memory
    const int reach = rules.tests->reach, margin = rules.tests->margin();
    const int rowsEnd = level.image.rows + margin;  // of all that can be read
    const std::vector<FeaturePoint>& points = list.points;
    scratch.region.reset(level.image.size(), margin);
    for (size_t i = size_t(features.start); i < end; i++)
        scratch.region.addDisc(Point(points[i].x, points[i].y), rules.tests->halfHeights);

    BlurredRows blurred;
    blurred.step = ptrdiff_t(alignSize(size_t(level.image.cols) + 2 * margin, CACHE_LINE / sizeof(ushort)));
    const size_t capacity = size_t(std::min<int64>(ROWS + 2 * int64(reach) + 1, rowsEnd + margin));
    growTo(scratch.blurred, capacity * blurred.step);
    blurred.data = scratch.blurred.data() + margin;
    int filled = -margin;  // the rows from blurred.top to before it are blurred
    bool isExact = false;
    for (size_t next, i = size_t(features.start); i < end;)
    {
        // The rows that the next features read are kept.
        const int top = std::max(points[i].y - reach, -margin);
        if (top < filled)
            std::memmove(blurred.data - margin, blurred.row(top) - margin,
                         sizeof(ushort) * blurred.step * (filled - top));
        blurred.top = top;
        filled = std::max(filled, top);
        const int bottom = std::min(std::max(points[i].y + reach + 1, filled + ROWS), rowsEnd);
        for (next = i; next < end && (points[next].y + reach < bottom || bottom == rowsEnd);)
            next++;
        approximateBlur(level.image, scratch.region, Range(filled, bottom), blurred, scratch.blur, isExact);
        filled = bottom;
        i += computeDescriptors(level.image, blurred, &points[i], next - i, *rules.tests,
                                &list.descriptors[i * DESCRIPTOR_BYTES], DESCRIPTOR_BYTES, !isExact);
        if (i < next)
        {
            isExact = true;
            filled = -margin;
        }
    }
}

}  // namespace aqorb
}  // namespace cv
