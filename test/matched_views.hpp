// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#ifndef OPENCV_AQORB_MATCHED_VIEWS_HPP
#define OPENCV_AQORB_MATCHED_VIEWS_HPP

#include "test_precomp.hpp"

namespace opencv_test
{

//! The arguments of refineMatches and growMatches.
struct MatchedViews
{
    Mat image1, image2;
    KeyPoints keypoints1, keypoints2;
    std::vector<DMatch> matches;
};

//! Waves of all directions: a texture that is known at every position.
struct Texture
{
    explicit Texture(int seed) : rng(seed)
    {
        for (int i = 0; i < WAVES; i++)
        {
            const double direction = rng.uniform(0., CV_2PI), frequency = CV_2PI / rng.uniform(6., 24.);
            waves[i] = Vec3d(frequency * std::cos(direction), frequency * std::sin(direction),
                             rng.uniform(0., CV_2PI));
        }
    }
    double at(const Point2d& p) const
    {
        double sum = 0;
        for (const Vec3d& wave : waves)
            sum += std::sin(wave[0] * p.x + wave[1] * p.y + wave[2]);
        return 128 + 40 * sum / std::sqrt(WAVES / 2.);
    }

    static const int WAVES = 20;
    RNG rng;
    Vec3d waves[WAVES];
};

//! Two views of a texture: a position p of the first one is at map * p in the second one. The keypoints of image 2 are
//! wrong by a pixel, some degrees and a fifth of the size.
MatchedViews viewsOf(const Texture& texture, const Matx23d& map, double gain = 1, double bias = 0,
                     double noise = 0);

Matx23d similarity(double scale, double degrees, double x, double y);

}  // namespace opencv_test

#endif
