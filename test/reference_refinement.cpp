// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "test_precomp.hpp"

#include "reference_refinement.hpp"

namespace opencv_test
{
namespace
{

const int RADIUS = 6, SIDE = 2 * RADIUS + 1;

//! The means of squares of 2 x 2 pixels, rounded.
Mat halfOf(const Mat& image)
{
    Mat half(image.rows / 2, image.cols / 2, CV_8UC1);
    for (int y = 0; y < half.rows; y++)
        for (int x = 0; x < half.cols; x++)
            half.at<uchar>(y, x) =
                uchar((image.at<uchar>(2 * y, 2 * x) + image.at<uchar>(2 * y, 2 * x + 1) +
                       image.at<uchar>(2 * y + 1, 2 * x) + image.at<uchar>(2 * y + 1, 2 * x + 1) + 2) /
                      4);
    return half;
}

//! The half of an image, or of a half, in which samples at a distance are one to two pixels apart.
struct View
{
    View(const Mat& image_, double& spacing, Point2d& position) : image(image_)
    {
        for (int level = 0; level < 4 && spacing >= 2; level++)
        {
            image = halfOf(image);
            spacing /= 2;
            position = (position + Point2d(0.5, 0.5)) / 2 - Point2d(0.5, 0.5);
            scale *= 2;
        }
    }
    Point2d inImage(const Vec2d& p) const
    {
        return Point2d((p[0] + 0.5) * scale - 0.5, (p[1] + 0.5) * scale - 0.5);
    }
    //! Bilinear; false outside.
    bool at(const Vec2d& p, double& value) const
    {
        if (!(p[0] > 0 && p[1] > 0 && p[0] < image.cols - 1 && p[1] < image.rows - 1))
            return false;
        const int x = int(p[0]), y = int(p[1]);
        const double dx = p[0] - x, dy = p[1] - y;
        value = (image.at<uchar>(y, x) * (1 - dx) + image.at<uchar>(y, x + 1) * dx) * (1 - dy) +
                (image.at<uchar>(y + 1, x) * (1 - dx) + image.at<uchar>(y + 1, x + 1) * dx) * dy;
        return true;
    }

    Mat image;
    double scale = 1;
};

//! The samples of a square around a centre, less their mean. False if one lies outside of the image.
bool samplesOf(const View& view, const Vec2d& center, const Matx22d& map, int radius, Mat_<double>& samples)
{
    samples.create(2 * radius + 1, 2 * radius + 1);
    for (int v = -radius; v <= radius; v++)
        for (int u = -radius; u <= radius; u++)
            if (!view.at(center + map * Vec2d(u, v), samples(v + radius, u + radius)))
                return false;
    return true;
}

}  // namespace

ReferenceAlignment referenceAlignment(const Mat& image1, const KeyPoint& keypoint1, const Mat& image2,
                                      const KeyPoint& keypoint2, double scaleFactor)
{
    const ReferenceAlignment notAligned = {false, keypoint2.pt, -1};
    Point2d center1 = keypoint1.pt, center2 = keypoint2.pt;
    double spacing1 = std::max(0.7, keypoint1.size / 31 * scaleFactor / 2);
    double spacing2 = spacing1 * keypoint2.size / keypoint1.size;
    const View view1(image1, spacing1, center1), view2(image2, spacing2, center2);

    // The template, its derivatives by the unknowns, and the normal equations.
    Mat_<double> wide, patch;
    if (!samplesOf(view1, Vec2d(center1.x, center1.y), spacing1 * Matx22d::eye(), RADIUS + 1, wide))
        return notAligned;
    const Mat_<double> inner = wide(Rect(1, 1, SIDE, SIDE));
    const Mat_<double> base = inner - mean(inner)[0];
    const double norm1 = cv::norm(base);
    if (norm1 * norm1 < 4 * SIDE * SIDE)
        return notAligned;
    Mat_<double> derivatives(SIDE * SIDE, 8);
    for (int i = 0; i < SIDE * SIDE; i++)
    {
        const int y = i / SIDE, x = i % SIDE, u = x - RADIUS, v = y - RADIUS;
        const double dx = (wide(y + 1, x + 2) - wide(y + 1, x)) / 2,
                     dy = (wide(y + 2, x + 1) - wide(y, x + 1)) / 2;
        const double row[] = {dx * u, dx * v, dx,         dy * u,
                              dy * v, dy,     base(y, x), 1};  // the last two: gain and bias
        Mat(1, 8, CV_64F, const_cast<double*>(row)).copyTo(derivatives.row(i));
    }

    const bool isUpright = keypoint1.angle == -1 || keypoint2.angle == -1;
    const double turn = isUpright ? 0 : (keypoint2.angle - keypoint1.angle) * CV_PI / 180;
    const Matx22d start = spacing2 * Matx22d(std::cos(turn), -std::sin(turn), std::sin(turn), std::cos(turn));
    Matx22d map = start;
    Vec2d center(center2.x, center2.y);
    double norm2 = 0, correlation = 0;
    for (int step = 0; step < 3; step++)
    {
        if (!samplesOf(view2, center, map, RADIUS, patch))
            return notAligned;
        patch -= mean(patch)[0];
        norm2 = cv::norm(patch);
        correlation = base.dot(patch) / (norm1 * norm2);
        Mat_<double> change;
        const Mat_<double> difference = patch * (norm1 / norm2) - base;
        if (norm2 == 0 ||
            !solve(derivatives, difference.reshape(1, SIDE * SIDE), change, DECOMP_NORMAL | DECOMP_LU))
            return notAligned;
        map = map * Matx22d(1 + change(0), change(1), change(3), 1 + change(4)).inv();
        center -= map * Vec2d(change(2), change(5));
    }
    const double area = std::abs(determinant(map) / determinant(start));
    const double shift = cv::norm(center - Vec2d(center2.x, center2.y)) / spacing2;
    if (!samplesOf(view2, center, map, RADIUS, patch) || norm2 * norm2 < 4 * SIDE * SIDE || area > 4 ||
        area < 0.25 || shift > RADIUS)
        return notAligned;
    return {true, view2.inImage(center), correlation};
}

}  // namespace opencv_test
