// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#ifndef OPENCV_AQORB_REFERENCE_REFINEMENT_HPP
#define OPENCV_AQORB_REFERENCE_REFINEMENT_HPP

#include "test_precomp.hpp"

namespace opencv_test
{

//! Where the alignment starts: the position in image 2, and the map from image 1 to image 2 around it.
struct ReferenceStart
{
    Point2d position;
    Matx22d map;
};

struct ReferenceAlignment
{
    bool isAligned;
    Point2d position;  //!< in image 2; that of the start if the patches cannot be aligned
    Matx22d map;       //!< from image 1 to image 2
    double correlation;
    double deviation;
};

//! The start of a match, from the sizes and the angles of its keypoints.
ReferenceStart referenceStart(const KeyPoint& keypoint1, const KeyPoint& keypoint2);

//! The alignment of patches in grey images by the formulas, in double precision.
ReferenceAlignment referenceAlignment(const Mat& image1, const KeyPoint& keypoint1, const Mat& image2,
                                      const ReferenceStart& start, double scaleFactor, double widening = 1);

//! What refineMatches makes of a match: the alignment, or a second one with samples twice as far apart. isAligned is
//! false if the match is removed.
ReferenceAlignment referenceRefinement(const Mat& image1, const KeyPoint& keypoint1, const Mat& image2,
                                       const KeyPoint& keypoint2, double minCorrelation, double scaleFactor);

//! The arguments of refineMatches and growMatches.
struct MatchedViews
{
    Mat image1, image2;
    KeyPoints keypoints1, keypoints2;
    std::vector<DMatch> matches;
};

//! The results of refineMatches.
struct Refined
{
    std::vector<DMatch> matches;
    std::vector<Point2f> points1, points2;
    std::vector<float> deviations;
};
bool isSame(const Refined& a, const Refined& b);
Refined refine(const MatchedViews& views, float minCorrelation = 0.8f, float scaleFactor = 1);

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

//! Copies of a keypoint that cannot be aligned, as a number of each is bad.
KeyPoints unusable(const KeyPoint& keypoint);

Point2d mapped(const Matx23d& map, const Point2d& p);
//! How far a refined match is from the truth, in pixels of image 2.
double errorOf(const Matx23d& map, const Refined& refined, size_t i);
Matx23d similarity(double scale, double degrees, double x, double y);

}  // namespace opencv_test

#endif
