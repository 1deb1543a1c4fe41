// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "precomp.hpp"

#include "given.hpp"

#include "input.hpp"

namespace cv
{
namespace aqorb
{
namespace stages
{

// Keypoints may come from a detector of more levels, but not make the pyramid as high as they like.
static const int MOST_LEVELS_GIVEN = 64;

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
        const GivenFeature feature = {
            {cvRound(keypoint.pt.x * inverseScale), cvRound(keypoint.pt.y * inverseScale), keypoint.angle},
            keypoint.octave,
            unsigned(i)};
        features.push_back(feature);
    }
    std::sort(features.begin(), features.end(),
              [](const GivenFeature& a, const GivenFeature& b)
              { return a.octave != b.octave ? a.octave < b.octave : InRasterOrder()(a.point, b.point); });
}

void batchGiven(const GivenScratch& given, int octave, FeatureBatch& batch)
{
    batch.reset(0);
    const auto isFiner = [](const GivenFeature& feature, int of) { return feature.octave < of; };
    auto next = std::lower_bound(given.features.begin(), given.features.end(), octave, isFiner);
    for (; next != given.features.end() && next->octave == octave; ++next)
    {
        batch.points.push_back(next->point);
        batch.keypoints.push_back(given.keypoints[next->index]);
        batch.outputKeys.push_back(next->index);
    }
}

}  // namespace stages
}  // namespace aqorb
}  // namespace cv
