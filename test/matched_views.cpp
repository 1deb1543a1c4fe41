// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "matched_views.hpp"

namespace opencv_test
{

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
            const Point2d seen(map(0, 0) * x + map(0, 1) * y + map(0, 2),
                               map(1, 0) * x + map(1, 1) * y + map(1, 2));
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
