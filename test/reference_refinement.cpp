// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// The refinement of one match by alignment of two patches, in double precision.

#include "reference_refinement.hpp"

#include <limits>

namespace opencv_test
{
namespace
{

const int RADIUS = 6, SIDE = 2 * RADIUS + 1;

//! The means of squares of 2 x 2 pixels, rounded. The last column and row count twice where their number is odd.
Mat halfOf(const Mat& image)
{
    Mat half((image.rows + 1) / 2, (image.cols + 1) / 2, CV_8UC1);
    const auto pixel = [&](int y, int x)
    { return int(image.at<uchar>(std::min(y, image.rows - 1), std::min(x, image.cols - 1))); };
    for (int y = 0; y < half.rows; y++)
        for (int x = 0; x < half.cols; x++)
            half.at<uchar>(y, x) = uchar((pixel(2 * y, 2 * x) + pixel(2 * y, 2 * x + 1) +
                                          pixel(2 * y + 1, 2 * x) + pixel(2 * y + 1, 2 * x + 1) + 2) /
                                         4);
    return half;
}

//! The level of an image's pyramid in which samples at a distance are one to two pixels apart.
struct View
{
    View(const Mat& image_, double spacing) : image(image_), size(image_.size())
    {
        for (; scale < 16 && spacing / scale >= 2; scale *= 2)
            image = halfOf(image);
    }
    //! Bilinear, at a position in pixels of the image. False closer to a side than half a pixel of the level.
    bool at(const Vec2d& p, double& value) const
    {
        const double left = p[0] + 0.5, top = p[1] + 0.5;
        if (!(left > scale / 2 && size.width - left > scale / 2 && top > scale / 2 &&
              size.height - top > scale / 2))
            return false;
        const double x = left / scale - 0.5, y = top / scale - 0.5;
        const int column = int(x), row = int(y);
        const double dx = x - column, dy = y - row;
        value =
            (image.at<uchar>(row, column) * (1 - dx) + image.at<uchar>(row, column + 1) * dx) * (1 - dy) +
            (image.at<uchar>(row + 1, column) * (1 - dx) + image.at<uchar>(row + 1, column + 1) * dx) * dy;
        return true;
    }

    Mat image;
    Size size;  //!< of the image
    double scale = 1;
};

//! The samples of a square around a centre. False if one lies too close to a side.
bool samplesOf(const View& view, const Vec2d& center, const Matx22d& map, int radius, Mat_<double>& samples)
{
    samples.create(2 * radius + 1, 2 * radius + 1);
    for (int v = -radius; v <= radius; v++)
        for (int u = -radius; u <= radius; u++)
            if (!view.at(center + map * Vec2d(u, v), samples(v + radius, u + radius)))
                return false;
    return true;
}

//! Whether all samples lie within 63 pixels of the level, in x and in y.
bool isNear(const View& view, const Vec2d& offset, const Matx22d& map)
{
    for (int i = 0; i < 2; i++)
        if (std::abs(offset[i]) + RADIUS * (std::abs(map(i, 0)) + std::abs(map(i, 1))) >= 63 * view.scale)
            return false;
    return true;
}

}  // namespace

ReferenceStart referenceStart(const KeyPoint& keypoint1, const KeyPoint& keypoint2)
{
    const bool isTurnKnown = keypoint1.angle != -1 && keypoint2.angle != -1;
    const double turn = isTurnKnown ? (double(keypoint2.angle) - keypoint1.angle) * CV_PI / 180 : 0;
    const Matx22d rotation(std::cos(turn), -std::sin(turn), std::sin(turn), std::cos(turn));
    return {keypoint2.pt, double(keypoint2.size) / keypoint1.size * rotation};
}

ReferenceAlignment referenceAlignment(const Mat& image1, const KeyPoint& keypoint1, const Mat& image2,
                                      const ReferenceStart& start, double scaleFactor, double widening)
{
    const ReferenceAlignment notAligned = {false, start.position, start.map, -1,
                                           std::numeric_limits<double>::infinity()};
    const double spacing = widening * std::max(0.7, keypoint1.size / 31 * scaleFactor / 2),
                 spacing2 = spacing * std::sqrt(std::abs(determinant(start.map)));
    const View view1(image1, spacing), view2(image2, spacing2);

    // The template, its derivatives by the unknowns, and the normal equations.
    Mat_<double> wide, patch;
    if (!samplesOf(view1, Vec2d(keypoint1.pt.x, keypoint1.pt.y), spacing * Matx22d::eye(), RADIUS + 1, wide))
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

    Matx22d map = start.map * spacing;
    const Vec2d origin(start.position.x, start.position.y);
    Vec2d center = origin;
    Mat_<double> difference;
    double norm2 = 0, correlation = 0;
    for (int step = 0; step < 3; step++)
    {
        if (!isNear(view2, center - origin, map) || !samplesOf(view2, center, map, RADIUS, patch))
            return notAligned;
        patch -= mean(patch)[0];
        norm2 = cv::norm(patch);
        difference = patch * (norm1 / norm2) - base;
        correlation = base.dot(patch) / (norm1 * norm2);
        Mat_<double> change;
        if (norm2 == 0 || !solve(derivatives, difference.clone().reshape(1, SIDE * SIDE), change,
                                 DECOMP_NORMAL | DECOMP_LU))
            return notAligned;
        map = map * Matx22d(1 + change(0), change(1), change(3), 1 + change(4)).inv();
        center -= map * Vec2d(change(2), change(5));
    }
    const double area = std::abs(determinant(map)) / (spacing2 * spacing2);
    if (!isNear(view2, center - origin, map) || !samplesOf(view2, center, map, RADIUS, patch) ||
        norm2 * norm2 < 4 * SIDE * SIDE || area > 4 || area < 0.25 ||
        cv::norm(center - origin) / spacing2 > RADIUS)
        return notAligned;
    // The covariance of the unknowns. Rounding of grey values alone has a variance of 1/12 in each image.
    const double variance = std::max(difference.dot(difference) / (SIDE * SIDE), 1 / 6.);
    const Mat_<double> covariance = (derivatives.t() * derivatives).inv(DECOMP_SVD) * variance;
    const Matx22d shift(covariance(2, 2), covariance(2, 5), covariance(5, 2), covariance(5, 5));
    Mat_<double> axes;
    eigen(Mat(map * shift * map.t()), axes);
    return {true, Point2d(center[0], center[1]), map * (1 / spacing), correlation, 3.5 * std::sqrt(axes(0))};
}

ReferenceAlignment referenceRefinement(const Mat& image1, const KeyPoint& keypoint1, const Mat& image2,
                                       const KeyPoint& keypoint2, double minCorrelation, double scaleFactor)
{
    const ReferenceStart start = referenceStart(keypoint1, keypoint2);
    ReferenceAlignment first = referenceAlignment(image1, keypoint1, image2, start, scaleFactor);
    const bool isKept = first.isAligned && first.correlation >= minCorrelation;
    if (isKept ? first.deviation <= 0.7 : first.isAligned && first.correlation < minCorrelation - 0.1)
    {
        first.isAligned = isKept;
        return first;
    }
    ReferenceAlignment second = referenceAlignment(image1, keypoint1, image2, start, scaleFactor, 2);
    second.isAligned =
        second.isAligned && second.correlation >= (isKept ? minCorrelation : std::max(minCorrelation, 0.9));
    return second;
}

bool isSame(const Refined& a, const Refined& b)
{
    const auto isSameMatch = [](const DMatch& x, const DMatch& y)
    { return x.queryIdx == y.queryIdx && x.trainIdx == y.trainIdx && x.distance == y.distance; };
    return a.matches.size() == b.matches.size() && a.points1 == b.points1 && a.points2 == b.points2 &&
           a.deviations == b.deviations &&
           std::equal(a.matches.begin(), a.matches.end(), b.matches.begin(), isSameMatch);
}

Refined refine(const MatchedViews& views, float minCorrelation, float scaleFactor)
{
    Refined refined;
    refined.matches = views.matches;
    aqorb::refineMatches(views.image1, views.keypoints1, views.image2, views.keypoints2, refined.matches,
                         refined.points1, refined.points2, refined.deviations, minCorrelation, scaleFactor);
    return refined;
}

KeyPoints unusable(const KeyPoint& keypoint)
{
    KeyPoints all;
    for (float value : {NOT_A_NUMBER, ENDLESS, -ENDLESS, 0.f, -1e30f, 1e30f, 1e-30f, 1e-42f})
    {
        all.insert(all.end(), 3, keypoint);
        all[all.size() - 3].pt.x = value;
        all[all.size() - 2].pt.y = value;
        all[all.size() - 1].size = value;
        if (std::isfinite(value))
            continue;  // any other angle is one
        all.push_back(keypoint);
        all.back().angle = value;
    }
    return all;
}

double errorOf(const Matx23d& map, const Refined& refined, size_t i)
{
    return cv::norm(mapped(map, refined.points1[i]) - Point2d(refined.points2[i]));
}

Point2d mapped(const Matx23d& map, const Point2d& p)
{
    const Vec2d moved = map * Vec3d(p.x, p.y, 1);
    return Point2d(moved[0], moved[1]);
}

MatchedViews viewsOf(const Texture& texture, const Matx23d& map, double gain, double bias, double noise)
{
    const Size size(320, 240);
    const Matx22d inverse = Matx22d(map(0, 0), map(0, 1), map(1, 0), map(1, 1)).inv();
    MatchedViews pair;
    pair.image1.create(size, CV_8UC1);
    pair.image2.create(size, CV_8UC1);
    RNG rng(5);
    for (int y = 0; y < size.height; y++)
    {
        for (int x = 0; x < size.width; x++)
        {
            const Vec2d seen = inverse * Vec2d(x - map(0, 2), y - map(1, 2));
            pair.image1.at<uchar>(y, x) =
                saturate_cast<uchar>(texture.at(Point2d(x, y)) + rng.gaussian(noise));
            pair.image2.at<uchar>(y, x) =
                saturate_cast<uchar>(gain * texture.at(seen) + bias + rng.gaussian(noise));
        }
    }
    const double turn = std::atan2(map(1, 0), map(0, 0)) * 180 / CV_PI,
                 scale = std::hypot(map(0, 0), map(1, 0));
    for (int y = 40; y < size.height; y += 20)
    {
        for (int x = 40; x < size.width; x += 20)
        {
            const Point2d seen = mapped(map, Point2d(x, y));
            if (!Rect2d(40, 40, size.width - 80, size.height - 80).contains(seen))
                continue;
            const Point2d found = seen + Point2d(rng.uniform(-1., 1.), rng.uniform(-1., 1.));
            const int index = int(pair.keypoints1.size());
            pair.keypoints1.push_back(KeyPoint(Point2f(float(x), float(y)), 50, 350));
            pair.keypoints2.push_back(KeyPoint(found, float(50 * scale * rng.uniform(0.85, 1.15)),
                                               float(std::fmod(710 + turn + rng.uniform(-8., 8.), 360))));
            pair.matches.push_back(DMatch(index, index, float(index)));
        }
    }
    return pair;
}

Matx23d similarity(double scale, double degrees, double x, double y)
{
    const double a = scale * std::cos(degrees * CV_PI / 180), b = scale * std::sin(degrees * CV_PI / 180);
    return Matx23d(a, -b, x, b, a, y);
}

}  // namespace opencv_test
