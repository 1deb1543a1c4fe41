// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "precomp.hpp"

#include "given.hpp"

namespace cv
{
namespace aqorb
{

// Keypoints may come from a detector of more levels, but not make the pyramid as high as they like.
static const int MOST_LEVELS_GIVEN = 64;

// The highest octave of the keypoints; 0 for none. Throws where an octave is negative or an angle is not finite.
static int highestOctave(const std::vector<KeyPoint>& keypoints)
{
    int highest = 0;
    for (size_t i = 0; i < keypoints.size(); i++)
    {
        const int octave = keypoints[i].octave;
        if (octave < 0)
            CV_Error_(
                Error::StsOutOfRange,
                ("keypoints must have an octave of at least 0, got %d (SIFT packs more than the octave into "
                 "the field: unpack it first)",
                 octave));
        // With such an angle the descriptor would read outside of the image.
        if (!std::isfinite(keypoints[i].angle))
            CV_Error_(Error::StsOutOfRange,
                      ("keypoints must have a finite angle, got %g", keypoints[i].angle));
        highest = std::max(highest, octave);
    }
    return highest;
}

// Whether a point is inside the image. The image begins half a pixel before the centre of its first pixel and ends a
// whole pixel behind the centre of its last one. In the last half pixel a point rounds to a pixel beside the image, but
// cv::ORB describes it there.
static bool isInside(const Point2f& pt, const Size& size)
{
    return pt.x >= -0.5f && pt.y >= -0.5f && pt.x < float(size.width) && pt.y < float(size.height);
}

// The keypoints that cv::ORB describes. The others lie outside of the image or nearer than `edgeThreshold` to its border.
static void describableKeypoints(const std::vector<KeyPoint>& keypoints, Size imageSize, int edgeThreshold,
                                 std::vector<KeyPoint>& describable)
{
    describable.clear();
    for (size_t i = 0; i < keypoints.size(); i++)
    {
        if (isInside(keypoints[i].pt, imageSize))
            describable.push_back(keypoints[i]);
    }
    const int border = std::min(edgeThreshold, std::max(imageSize.width, imageSize.height));
    KeyPointsFilter::runByImageBorder(describable, imageSize, border);
}

void takeGiven(const std::vector<KeyPoint>& keypoints, const Parameters& parameters, Levels& levels,
               GivenScratch& scratch)
{
    const Size imageSize = levels.input().image.size();
    const int highest = highestOctave(keypoints);
    parameters.checkTogether(std::max(parameters.nlevels, highest > 0 ? 2 : 1));
    const Size smallest =
        levelSize(imageSize, levelScale(highest, parameters.firstLevel, parameters.scaleFactor));
    const int most = std::max(parameters.nlevels, MOST_LEVELS_GIVEN);
    if (highest >= most || smallest.width < 1 || smallest.height < 1)
        CV_Error_(
            Error::StsOutOfRange,
            ("keypoints must have octaves below %d whose levels have pixels, got octave %d (SIFT packs more "
             "than the octave into the field: unpack it first)",
             most, highest));

    std::vector<KeyPoint>& inside = scratch.keypoints;
    describableKeypoints(keypoints, imageSize, parameters.edgeThreshold, inside);
    levels.layOut(inside.empty() ? 0 : highestOctave(inside) + 1, 1);
    std::vector<GivenFeature>& features = scratch.features;
    features.clear();
    for (size_t i = 0; i < inside.size(); i++)
    {
        const KeyPoint& keypoint = inside[i];
        const float inverseScale = 1.f / levels[keypoint.octave].scale;
        const Point2f p = keypoint.pt * inverseScale;
        features.push_back({{cvRound(p.x), cvRound(p.y), keypoint.angle}, keypoint.octave, unsigned(i)});
    }
    std::sort(features.begin(), features.end(),
              [](const GivenFeature& a, const GivenFeature& b)
              { return a.octave != b.octave ? a.octave < b.octave : InRasterOrder()(a.point, b.point); });
}

void listGiven(const GivenScratch& given, int octave, FeatureList& list)
{
    list.reset(0);
    const auto isFiner = [](const GivenFeature& feature, int of) { return feature.octave < of; };
    auto next = std::lower_bound(given.features.begin(), given.features.end(), octave, isFiner);
    for (; next != given.features.end() && next->octave == octave; ++next)
    {
        list.points.push_back(next->point);
        list.keypoints.push_back(given.keypoints[next->index]);
        list.outputKeys.push_back(next->index);
    }
}

}  // namespace aqorb
}  // namespace cv
