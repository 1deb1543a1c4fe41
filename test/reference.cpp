// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// Steps of the paper before and after the selection: the FAST thresholds of equation (7), the pyramid with the quotas of
// equation (8), the mesh of cells with its second threshold, then Harris responses, positions and directions.

#include "reference.hpp"

namespace opencv_test
{
namespace reference
{

int pixel(const Mat& image, int x, int y)
{
    return image.at<uchar>(borderInterpolate(y, image.rows, BORDER_REFLECT_101),
                           borderInterpolate(x, image.cols, BORDER_REFLECT_101));
}

double varianceOverMean(const Mat& gray, const Mat& mask)
{
    int64 n = 0, sum = 0, squares = 0;
    for (int y = 0; y < gray.rows; y++)
        for (int x = 0; x < gray.cols; x++)
        {
            if (!mask.empty() && mask.at<uchar>(y, x) == 0)
                continue;
            const int64 value = gray.at<uchar>(y, x);
            n++;
            sum += value;
            squares += value * value;
        }
    return sum == 0 ? 0. : (double)squares / (double)sum - (double)sum / (double)n;
}

static double clamp(double value, double low, double high)
{
    return value < low ? low : value > high ? high : value;
}

Thresholds thresholds(double v, bool adaptive, int fastThreshold, double minRatio)
{
    const int fast = int(clamp(fastThreshold, 0, 255));
    v = adaptive ? v * fast / 20 : fast;
    Thresholds result;
    result.ini = cvRound(clamp(v, 1, 254));
    result.min = cvRound(clamp(v / minRatio, 1, std::min(std::max(fast, 1), result.ini)));
    return result;
}

float levelScale(int level, int firstLevel, double scaleFactor)
{
    return (float)std::pow(scaleFactor, (double)(level - firstLevel));
}

Size levelSize(Size imageSize, float scale)
{
    const float inverse = 1.f / scale;
    return Size(cvRound(imageSize.width * inverse), cvRound(imageSize.height * inverse));
}

std::vector<int> quotas(int nfeatures, double scaleFactor, int nlevels)
{
    std::vector<int> result(nlevels);
    const float factor = (float)(1.0 / scaleFactor);
    float wanted = nfeatures * (1 - factor) / (1 - (float)std::pow((double)factor, (double)nlevels));
    int sum = 0;
    for (int level = 0; level < nlevels - 1; level++)
    {
        result[level] = cvRound(wanted);
        sum += result[level];
        wanted *= factor;
    }
    result[nlevels - 1] = std::max(nfeatures - sum, 0);
    sum += result[nlevels - 1];
    for (int level = 0; sum > nfeatures; sum--)
    {
        while (result[level] == 0)
            level++;
        result[level]--;
    }
    return result;
}

// influences[i][j]: whether pixel j along an axis counts in pixel i of the resized one. Asked of
// cv::resize: of a diagonal image, only one pixel at a time is not 0.
static std::vector<std::vector<int>> influences(int from, int to)
{
    Mat resized;
    cv::resize(Mat::eye(from, from, CV_8UC1) * 255, resized, Size(to, from), 0, 0, INTER_LINEAR_EXACT);
    std::vector<std::vector<int>> result(to);
    for (int i = 0; i < to; i++)
        for (int j = 0; j < from; j++)
        {
            if (resized.at<uchar>(j, i) != 0)
                result[i].push_back(j);
        }
    return result;
}

std::vector<Mat> pyramid(const Mat& gray, int nlevels, int firstLevel, double scaleFactor)
{
    std::vector<Mat> levels;
    for (int i = 0; i < nlevels; i++)
    {
        Mat level = gray.clone();
        if (i != firstLevel)
            cv::resize(i <= firstLevel + 1 ? gray : levels[i - 1], level,
                       levelSize(gray.size(), levelScale(i, firstLevel, scaleFactor)), 0, 0,
                       INTER_LINEAR_EXACT);
        levels.push_back(level);
    }
    return levels;
}

Mat resizeMask(const Mat& mask, Size size)
{
    const std::vector<std::vector<int>> columns = influences(mask.cols, size.width);
    const std::vector<std::vector<int>> rows = influences(mask.rows, size.height);
    Mat result(size, CV_8UC1, Scalar(255));
    for (int y = 0; y < size.height; y++)
        for (int x = 0; x < size.width; x++)
            for (size_t i = 0; i < rows[y].size(); i++)
                for (size_t j = 0; j < columns[x].size(); j++)
                {
                    if (mask.at<uchar>(rows[y][i], columns[x][j]) == 0)
                        result.at<uchar>(y, x) = 0;
                }
    return result;
}

int cornerScore(const Mat& image, int x, int y)
{
    static const int CIRCLE[16][2] = {{0, 3},  {1, 3},  {2, 2},  {3, 1},   {3, 0},   {3, -1},
                                      {2, -2}, {1, -3}, {0, -3}, {-1, -3}, {-2, -2}, {-3, -1},
                                      {-3, 0}, {-3, 1}, {-2, 2}, {-1, 3}};
    const int v = pixel(image, x, y);
    int differences[16], best = -255;
    for (int i = 0; i < 16; i++)
        differences[i] = pixel(image, x + CIRCLE[i][0], y + CIRCLE[i][1]) - v;
    for (int first = 0; first < 16; first++)
    {
        int brighter = 255, darker = 255;
        for (int i = first; i < first + 9; i++)
        {
            brighter = std::min(brighter, differences[i % 16]);
            darker = std::min(darker, -differences[i % 16]);
        }
        best = std::max(best, std::max(brighter, darker));
    }
    return best;
}

std::vector<Corner> fastCorners(const Mat& image, const Rect& region, int threshold)
{
    const int RADIUS = 3;
    threshold = std::max(threshold, 1);
    // The score of every pixel that is a corner at the threshold; 0 elsewhere, and around the image.
    Mat scores = Mat::zeros(image.size(), CV_32SC1);
    for (int y = RADIUS; y < image.rows - RADIUS; y++)
        for (int x = RADIUS; x < image.cols - RADIUS; x++)
        {
            const int score = cornerScore(image, x, y);
            if (score > threshold)
                scores.at<int>(y, x) = score - 1;
        }
    std::vector<Corner> corners;
    for (int y = RADIUS; y < image.rows - RADIUS; y++)
        for (int x = RADIUS; x < image.cols - RADIUS; x++)
        {
            const Corner corner = {x, y, scores.at<int>(y, x)};
            bool isMaximum = corner.score > 0;
            for (int dy = -1; dy <= 1; dy++)
                for (int dx = -1; dx <= 1; dx++)
                {
                    if ((dx != 0 || dy != 0) && scores.at<int>(y + dy, x + dx) >= corner.score)
                        isMaximum = false;
                }
            if (isMaximum && region.contains(Point(x, y)))
                corners.push_back(corner);
        }
    return corners;
}

std::vector<Corner> findCorners(const Mat& image, const Mat& mask, const Rect& region, Thresholds t,
                                bool suppressNear)
{
    const int CELL = 35;
    std::vector<Corner> all, usable;
    all = fastCorners(image, region, t.min);
    for (size_t i = 0; i < all.size(); i++)
    {
        if (mask.empty() || mask.at<uchar>(all[i].y, all[i].x) != 0)
            usable.push_back(all[i]);
    }

    std::vector<Corner> result, candidates;
    for (size_t i = 0; i < usable.size(); i++)
    {
        const Corner& a = usable[i];
        bool cellIsFull = false;
        for (size_t j = 0; j < usable.size(); j++)
        {
            const Corner& b = usable[j];
            cellIsFull |= b.score >= t.ini && (a.x - region.x) / CELL == (b.x - region.x) / CELL &&
                          (a.y - region.y) / CELL == (b.y - region.y) / CELL;
        }
        if (a.score >= t.ini || !cellIsFull)
            candidates.push_back(a);
    }
    for (size_t i = 0; i < candidates.size(); i++)
    {
        const Corner& a = candidates[i];
        bool falls = false;
        for (size_t j = 0; suppressNear && j < candidates.size(); j++)
        {
            const Corner& b = candidates[j];
            const bool isBefore = b.y != a.y ? b.y < a.y : b.x < a.x;
            falls |= std::abs(a.x - b.x) <= 3 && std::abs(a.y - b.y) <= 3 &&
                     (b.score > a.score || (b.score == a.score && isBefore));
        }
        if (!falls)
            result.push_back(a);
    }
    return result;
}

float harrisResponse(const Mat& image, int x0, int y0)
{
    int a = 0, b = 0, c = 0;
    for (int y = y0 - 2; y <= y0 + 2; y++)
        for (int x = x0 - 2; x <= x0 + 2; x++)
        {
            int Ix = 0, Iy = 0;
            for (int i = -1; i <= 1; i++)
            {
                const int weight = i == 0 ? 2 : 1;
                Ix += weight * (pixel(image, x + 1, y + i) - pixel(image, x - 1, y + i));
                Iy += weight * (pixel(image, x + i, y + 1) - pixel(image, x + i, y - 1));
            }
            a += Ix * Ix;
            b += Iy * Iy;
            c += Ix * Iy;
        }
    const float k = 0.04f, scale = 1.f / ((1 << 2) * 5 * 255.f);
    return ((float)a * b - (float)c * c - k * ((float)a + b) * ((float)a + b)) *
           (scale * scale * scale * scale);
}

Point2d subPixelOffset(const Mat& image, int x, int y)
{
    struct Score
    {
        const Mat& image;
        int x, y;
        int operator()(int dx, int dy) const { return cornerScore(image, x + dx, y + dy); }
    } S = {image, x, y};

    const int gx2 = S(1, 0) - S(-1, 0), gy2 = S(0, 1) - S(0, -1);
    const int dxx = S(1, 0) - 2 * S(0, 0) + S(-1, 0), dyy = S(0, 1) - 2 * S(0, 0) + S(0, -1);
    const int dxy4 = S(1, 1) - S(-1, 1) - S(1, -1) + S(-1, -1);
    const int det16 = 16 * dxx * dyy - dxy4 * dxy4;
    if (!(dxx < 0 && det16 > 0))
        return Point2d(0, 0);
    const double px = 2. * (dxy4 * gy2 - 4 * dyy * gx2) / det16;
    const double py = 2. * (dxy4 * gx2 - 4 * dxx * gy2) / det16;
    return Point2d(clamp(px, -0.5, 0.5), clamp(py, -0.5, 0.5));
}

//! What a position keeps from the side of its pixel: a hundredth of a pixel or, in wide images, three times what the
//! rounding to a float moves it at most.
static double margin(int length)
{
    return std::max(0.01, 3. * length / (1 << 24));
}

static float nearestCoordinate(int x, double p, int imageLength, float scale, int border)
{
    const double most = 0.5 - margin(x), low = (x - most) * scale, high = (x + most) * scale,
                 last = imageLength - border - 0.5 - margin(imageLength);
    if (low <= last)  // else no position of the pixel is that far inside
        p = std::min(p, last);
    if (high >= border)
        p = std::max(p, (double)border);
    return (float)clamp(p, low, high);
}

static float coordinate(int x, double d, int imageLength, int levelLength, float scale, int border)
{
    return nearestCoordinate(x, (x + d + 0.5) * imageLength / levelLength - 0.5, imageLength, scale, border);
}

Point2f position(int x, int y, Point2d d, Size imageSize, Size levelSize, float scale, int border,
                 bool subPixel)
{
    if (!subPixel)
        return Point2f((float)x * scale, (float)y * scale);
    return Point2f(coordinate(x, d.x, imageSize.width, levelSize.width, scale, border),
                   coordinate(y, d.y, imageSize.height, levelSize.height, scale, border));
}

// On fine levels the position of a pixel on the side may lie half a pixel beyond the image.
static bool isUsable(const Mat& mask, const Point2f& p)
{
    return mask.at<uchar>(std::min(cvRound(p.y), mask.rows - 1), std::min(cvRound(p.x), mask.cols - 1)) != 0;
}

bool usablePosition(const Mat& mask, int x, int y, Size levelSize, float scale, int border, bool subPixel,
                    Point2f& found)
{
    const Size imageSize = mask.size();
    const Point2f center = position(x, y, Point2d(), imageSize, levelSize, scale, border, subPixel);
    if (isUsable(mask, center))
    {
        found = center;
        return true;
    }
    // The nearest of all, of which the first.
    double least = DBL_MAX;
    for (int row = 0; subPixel && row < mask.rows; row++)
        for (int column = 0; column < mask.cols; column++)
        {
            const Point2f p(nearestCoordinate(x, column, imageSize.width, scale, border),
                            nearestCoordinate(y, row, imageSize.height, scale, border));
            const double dx = p.x - center.x, dy = p.y - center.y;
            if (isUsable(mask, p) && dx * dx + dy * dy < least)
            {
                least = dx * dx + dy * dy;
                found = p;
            }
        }
    return least < DBL_MAX;
}

float arctangent(float y, float x, bool fused)
{
    // As in mathfuncs_core.simd.hpp.
    const auto sumOf = [fused](float a, float b, float c) { return fused ? std::fma(a, b, c) : a * b + c; };
    const float degrees = (float)(180 / CV_PI);
    const float p[] = {-0.04432655554792128f * degrees, 0.1555786518463281f * degrees,
                       -0.3258083974640975f * degrees, 0.9997878412794807f * degrees};
    const float ax = std::abs(x), ay = std::abs(y);
    const float c = std::min(ax, ay) / (std::max(ax, ay) + (float)DBL_EPSILON), c2 = c * c;
    float sum = p[0];
    for (int i = 1; i < 4; i++)
        sum = sumOf(sum, c2, p[i]);
    const float a = ax >= ay ? sum * c : sumOf(-sum, c, 90.f);
    const float half = x < 0 ? 180.f - a : a;
    return y < 0 ? 360.f - half : half;
}

bool opencvFusesMultiplyAdd()
{
    int x = 1;
    while (arctangent(100, float(x), true) == arctangent(100, float(x), false))
        x++;
    return fastAtan2(100, float(x)) == arctangent(100, float(x), true);
}

void discMoments(const Mat& image, int x, int y, int patchSize, int step, int& m10, int& m01)
{
    // As in orb.cpp.
    const int half = patchSize / 2;
    const int vmax = cvFloor(half * std::sqrt(2.f) / 2 + 1), vmin = cvCeil(half * std::sqrt(2.f) / 2);
    std::vector<int> umax(half + 2);
    for (int v = 0; v <= vmax; v++)
        umax[v] = cvRound(std::sqrt((double)half * half - v * v));
    for (int v = half, v0 = 0; v >= vmin; v--, v0++)
    {
        while (umax[v0] == umax[v0 + 1])
            v0++;
        umax[v] = v0;
    }
    umax[0] = half;

    // Large patches exceed 32 bits; the sums are then modulo 2^32.
    unsigned sum01 = 0, sum10 = 0;
    for (int v = -half; v <= half; v++)
    {
        if (v % step != 0)
            continue;
        for (int u = -umax[std::abs(v)]; u <= umax[std::abs(v)]; u++)
        {
            sum10 += unsigned(u * pixel(image, x + u, y + v));
            sum01 += unsigned(v * pixel(image, x + u, y + v));
        }
    }
    m10 = int(sum10);
    m01 = int(sum01);
}

float orientation(const Mat& image, int x, int y, int patchSize)
{
    int m10 = 0, m01 = 0;
    discMoments(image, x, y, patchSize, 1, m10, m01);
    return arctangent((float)m01, (float)m10);
}

}  // namespace reference
}  // namespace opencv_test
