// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// refineMatches: patches of matches, and the check of their alignment.

#include "precomp.hpp"

#include "common/angles.hpp"
#include "refinement/refinement.hpp"

#include <opencv2/aqorb/refinement.hpp>

namespace cv
{
namespace aqorb
{

double spacingOf(const KeyPoint& keypoint, float scaleFactor)
{
    const double ORB_SIZE = 31, MIN_SPACING = 0.7;
    const double pixel = keypoint.size / ORB_SIZE * scaleFactor;  // size of a pixel on the keypoint's level
    return std::max(MIN_SPACING, pixel / 2);
}

namespace
{

// Patches of a match. Their spacing is 0 if the keypoints do not define it.
PatchPair patchesOf(const KeyPoint& first, const KeyPoint& second, float scaleFactor)
{
    PatchPair pair = {{first.pt, 0}, {second.pt, 0}, Matx22d()};
    if (!(first.size > 0 && second.size > 0) || !std::isfinite(first.angle) || !std::isfinite(second.angle))
        return pair;
    pair.first.spacing = spacingOf(first, scaleFactor);
    pair.second.spacing = pair.first.spacing * second.size / first.size;
    const bool isTurnKnown = first.angle != -1 && second.angle != -1;
    const double turn = isTurnKnown ? std::fmod(double(second.angle) - first.angle, 360.) : 0;
    float sine, cosine;
    sineAndCosine(float(turn) * float(CV_PI / 180), sine, cosine);
    pair.map = pair.second.spacing * Matx22d(cosine, -sine, sine, cosine);
    return pair;
}

}  // namespace

void RefinementInput::check() const
{
    if (!(minCorrelation >= -1 && minCorrelation <= 1))
        CV_Error_(Error::StsOutOfRange, ("minCorrelation must be from -1 to 1, got %g", minCorrelation));
    if (!(scaleFactor > 0) || !std::isfinite(scaleFactor))
        CV_Error_(Error::StsOutOfRange, ("scaleFactor must be finite and > 0, got %g", scaleFactor));
    for (size_t i = 0; i < matches.size(); i++)
    {
        const int query = matches[i].queryIdx, train = matches[i].trainIdx;
        if (query < 0 || size_t(query) >= keypoints1.size() || train < 0 ||
            size_t(train) >= keypoints2.size())
            CV_Error_(Error::StsOutOfRange,
                      ("matches[%d] must have a queryIdx below %d and a trainIdx below %d, the numbers of "
                       "keypoints, and at least 0, got %d and %d",
                       int(i), int(keypoints1.size()), int(keypoints2.size()), query, train));
    }
}

void RefinedMatches::add(const DMatch& match, const PatchPair& pair, const PatchAlignment& alignment)
{
    matches.push_back(match);
    points1.push_back(pair.first.center);
    points2.push_back(alignment.center);
    deviations.push_back(alignment.deviation);
    maps.push_back(alignment.map * (1 / pair.first.spacing));
}

void RefinedMatches::append(const RefinedMatches& other)
{
    matches.insert(matches.end(), other.matches.begin(), other.matches.end());
    points1.insert(points1.end(), other.points1.begin(), other.points1.end());
    points2.insert(points2.end(), other.points2.begin(), other.points2.end());
    deviations.insert(deviations.end(), other.deviations.begin(), other.deviations.end());
    maps.insert(maps.end(), other.maps.begin(), other.maps.end());
}

RefinedMatches RefinedMatches::exchanged() const
{
    RefinedMatches result = {matches, points2, points1, deviations, maps};
    for (DMatch& match : result.matches)
        std::swap(match.queryIdx, match.trainIdx);
    for (Matx22d& map : result.maps)
        map = map.inv();
    return result;
}

namespace
{

// Whether a patch may have seen no more than one edge, along which it slides.
bool isUncertain(const PatchAlignment& alignment, float minCorrelation)
{
    const float NEARLY = 0.1f, MAX_DEVIATION = 0.7f;
    const float correlation = alignment.correlation;
    return correlation >= minCorrelation
               ? alignment.deviation > MAX_DEVIATION
               : correlation == NOT_ALIGNED || correlation >= minCorrelation - NEARLY;
}

// Aligns the uncertain pairs once more, with samples twice as far apart.
void alignUncertain(float minCorrelation, PatchAligner& aligner, std::vector<PatchPair>& pairs,
                    std::vector<PatchAlignment>& alignments)
{
    // More wrong matches than right ones align with one of two patches only.
    const float MIN_CORRELATION = std::max(minCorrelation, 0.9f);
    std::vector<size_t> indices;
    std::vector<PatchPair> wider;
    for (size_t i = 0; i < pairs.size(); i++)
    {
        if (!isUncertain(alignments[i], minCorrelation))
            continue;
        PatchPair& pair = pairs[i];
        pair.first.spacing *= 2;
        pair.second.spacing *= 2;
        pair.map = pair.map * 2;
        indices.push_back(i);
        wider.push_back(pair);
    }
    const std::vector<PatchAlignment> again = aligner.align(wider, false);
    for (size_t k = 0; k < indices.size(); k++)
    {
        PatchAlignment& alignment = alignments[indices[k]];
        const bool isDropped =
            alignment.correlation < minCorrelation && again[k].correlation < MIN_CORRELATION;
        alignment = again[k];
        if (isDropped)
            alignment.correlation = NOT_ALIGNED;
    }
}

}  // namespace

RefinedMatches refinedMatches(const RefinementInput& input, PatchAligner& aligner)
{
    std::vector<PatchPair> pairs;
    for (const DMatch& match : input.matches)
        pairs.push_back(patchesOf(input.keypoints1[size_t(match.queryIdx)],
                                  input.keypoints2[size_t(match.trainIdx)], input.scaleFactor));
    std::vector<PatchAlignment> alignments = aligner.align(pairs, false);
    const bool keepsAll = input.minCorrelation == -1;
    if (!keepsAll)
        alignUncertain(input.minCorrelation, aligner, pairs, alignments);
    RefinedMatches refined;
    for (size_t i = 0; i < pairs.size(); i++)
        if (keepsAll || alignments[i].correlation >= input.minCorrelation)
            refined.add(input.matches[i], pairs[i], alignments[i]);
    return refined;
}

void refineMatches(InputArray image1, const std::vector<KeyPoint>& keypoints1, InputArray image2,
                   const std::vector<KeyPoint>& keypoints2, std::vector<DMatch>& matches,
                   std::vector<Point2f>& points1, std::vector<Point2f>& points2,
                   std::vector<float>& deviations, float minCorrelation, float scaleFactor)
{
    CV_TRACE_FUNCTION();
    const RefinementInput input = {keypoints1, keypoints2, matches, minCorrelation, scaleFactor};
    input.check();
    PatchAligner aligner(image1, image2, !matches.empty());
    RefinedMatches refined = refinedMatches(input, aligner);
    matches.swap(refined.matches);
    points1.swap(refined.points1);
    points2.swap(refined.points2);
    deviations.swap(refined.deviations);
}

void refineMatches(InputArray image1, const std::vector<KeyPoint>& keypoints1, InputArray image2,
                   const std::vector<KeyPoint>& keypoints2, std::vector<DMatch>& matches,
                   std::vector<Point2f>& points1, std::vector<Point2f>& points2, float minCorrelation,
                   float scaleFactor)
{
    std::vector<float> deviations;
    refineMatches(image1, keypoints1, image2, keypoints2, matches, points1, points2, deviations,
                  minCorrelation, scaleFactor);
}

}  // namespace aqorb
}  // namespace cv
