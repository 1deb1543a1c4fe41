// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// growMatches: matches predicted by the affine maps of refined matches nearby.

#include "precomp.hpp"

#include "common/angles.hpp"
#include "refinement/refinement.hpp"

#include <opencv2/aqorb/refinement.hpp>

namespace cv
{
namespace aqorb
{

namespace
{

// Index of the aligned matches by their positions in image 1, sorted by y. Only these have a map.
class SeedIndex
{
public:
    explicit SeedIndex(const RefinedMatches& refined) : points(refined.points1)
    {
        for (size_t i = 0; i < points.size(); i++)
            if (std::isfinite(refined.deviations[i]))
                order.push_back(int(i));
        std::sort(order.begin(), order.end(),
                  [&](int a, int b)
                  {
                      const float yA = points[size_t(a)].y, yB = points[size_t(b)].y;
                      return yA != yB ? yA < yB : a < b;
                  });
    }

    // Seed nearest to a position of image 1, or -1 if none lies within a distance. Ties go to the first match.
    int nearest(const Point2f& position, double maxDistance) const
    {
        double smallest = maxDistance * maxDistance;
        int found = -1;
        // Returns false if all seeds beyond this one are farther away.
        const auto compare = [&](int seed)
        {
            const Point2d offset = Point2d(points[size_t(seed)]) - Point2d(position);
            const double distance = offset.dot(offset);
            if (distance < smallest || (distance == smallest && (found < 0 || seed < found)))
            {
                smallest = distance;
                found = seed;
            }
            return offset.y * offset.y <= smallest;
        };
        const auto middle = std::lower_bound(order.begin(), order.end(), position.y,
                                             [&](int i, float y) { return points[size_t(i)].y < y; });
        for (auto seed = middle; seed != order.end() && compare(*seed); ++seed)
            continue;
        for (auto seed = middle; seed != order.begin() && compare(*--seed);)
            continue;
        return found;
    }

private:
    const std::vector<Point2f>& points;
    std::vector<int> order;
};

// Patches of a keypoint of image 1 and of its position in image 2 as a seed predicts it.
PatchPair predictedPatches(const KeyPoint& keypoint, const RefinedMatches& seeds, size_t seed,
                           float scaleFactor)
{
    const Matx22d& map = seeds.maps[seed];
    const Point2d offset = Point2d(keypoint.pt) - Point2d(seeds.points1[seed]);
    const Vec2d moved = map * Vec2d(offset.x, offset.y);
    const double spacing = spacingOf(keypoint, scaleFactor);
    return {{keypoint.pt, spacing},
            {Point2f(Point2d(seeds.points2[seed]) + Point2d(moved[0], moved[1])),
             spacing * std::sqrt(std::abs(determinant(map)))},
            map * spacing};
}

// A keypoint that a map takes to a position. An angle of -1 or one that is not finite stays.
KeyPoint mappedKeypoint(const KeyPoint& keypoint, const Point2f& position, const Matx22d& map)
{
    KeyPoint mapped(position, float(keypoint.size * std::sqrt(std::abs(determinant(map)))), keypoint.angle);
    if (keypoint.angle != -1 && std::isfinite(keypoint.angle))
    {
        float sine, cosine;
        sineAndCosine(keypoint.angle * float(CV_PI / 180), sine, cosine);
        const Vec2d direction = map * Vec2d(cosine, sine);
        mapped.angle = directionOf(float(direction[0]), float(direction[1]));
    }
    return mapped;
}

// Keypoint of image 2 that shows the same spot as a keypoint of image 1.
KeyPoint grownKeypoint(const KeyPoint& keypoint, const PatchAlignment& alignment, const Matx22d& map,
                       int64 octave)
{
    KeyPoint grown = mappedKeypoint(keypoint, alignment.center, map);
    grown.octave = saturate_cast<int>(std::max<int64>(octave, 0));
    return grown;
}

// Growth from image 1 into image 2, or the other way round with all members exchanged.
struct Direction
{
    // Aligns the keypoints of image 1 that no seed has and that `found` does not show.
    // Appends a keypoint to grown2 for each match found.
    RefinedMatches grow(const RefinedMatches& seeds, const RefinedMatches& found,
                        std::vector<KeyPoint>& grown2) const
    {
        const double MAX_SEED_DISTANCE = 60, SAME_DISTANCE = 1;
        // Wrong predictions seldom correlate as well so near.
        const float MIN_CORRELATION = 0.85f, MAX_SHIFT = 4;
        std::vector<uchar> hasMatch(keypoints1.size());
        for (const DMatch& match : seeds.matches)
            hasMatch[size_t(match.queryIdx)] = 1;
        const SeedIndex index(seeds), foundIndex(found);
        std::vector<PatchPair> pairs;
        std::vector<int> queries, origins;
        for (size_t i = 0; i < keypoints1.size(); i++)
        {
            const KeyPoint& keypoint = keypoints1[i];
            const bool isTried = !hasMatch[i] && keypoint.size > 0 && std::isfinite(keypoint.angle) &&
                                 foundIndex.nearest(keypoint.pt, SAME_DISTANCE) < 0;
            const int seed = isTried ? index.nearest(keypoint.pt, MAX_SEED_DISTANCE) : -1;
            if (seed < 0)
                continue;
            pairs.push_back(predictedPatches(keypoint, seeds, size_t(seed), scaleFactor));
            queries.push_back(int(i));
            origins.push_back(seed);
        }

        RefinedMatches matches;
        const std::vector<PatchAlignment> alignments = aligner.align(pairs, isReversed);
        for (size_t i = 0; i < pairs.size(); i++)
        {
            const Point2f shift = alignments[i].center - pairs[i].second.center;
            if (!(alignments[i].correlation >= std::max(minCorrelation, MIN_CORRELATION)) ||
                !(shift.dot(shift) <= MAX_SHIFT * MAX_SHIFT))
                continue;
            const DMatch& seed = seeds.matches[size_t(origins[i])];
            const KeyPoint& keypoint = keypoints1[size_t(queries[i])];
            const int64 octave = int64(keypoints2[size_t(seed.trainIdx)].octave) + keypoint.octave -
                                 keypoints1[size_t(seed.queryIdx)].octave;
            matches.add(DMatch(queries[i], int(grown2.size()), 0, FLT_MAX), pairs[i], alignments[i]);
            grown2.push_back(grownKeypoint(keypoint, alignments[i], matches.maps.back(), octave));
        }
        return matches;
    }

    const std::vector<KeyPoint>& keypoints1;
    const std::vector<KeyPoint>& keypoints2;
    PatchAligner& aligner;
    bool isReversed;
    float minCorrelation, scaleFactor;
};

}  // namespace

void growMatches(InputArray image1, const std::vector<KeyPoint>& keypoints1, InputArray image2,
                 const std::vector<KeyPoint>& keypoints2, std::vector<DMatch>& matches,
                 std::vector<KeyPoint>& grown1, std::vector<KeyPoint>& grown2, std::vector<Point2f>& points1,
                 std::vector<Point2f>& points2, std::vector<float>& deviations, float minCorrelation,
                 float scaleFactor, bool bothWays)
{
    CV_TRACE_FUNCTION();
    const RefinementInput input = {keypoints1, keypoints2, matches, minCorrelation, scaleFactor};
    input.check();
    PatchAligner aligner(image1, image2, !matches.empty());
    RefinedMatches all = refinedMatches(input, aligner);
    std::vector<KeyPoint> all1 = keypoints1, all2 = keypoints2;
    const Direction forward = {keypoints1, keypoints2, aligner, false, minCorrelation, scaleFactor};
    const RefinedMatches into2 = forward.grow(all, RefinedMatches(), all2);
    if (bothWays)
    {
        const Direction back = {keypoints2, keypoints1, aligner, true, minCorrelation, scaleFactor};
        const RefinedMatches into1 = back.grow(all.exchanged(), into2.exchanged(), all1);
        all.append(into2);
        all.append(into1.exchanged());
    }
    else
        all.append(into2);
    matches.swap(all.matches);
    grown1.swap(all1);
    grown2.swap(all2);
    points1.swap(all.points1);
    points2.swap(all.points2);
    deviations.swap(all.deviations);
}

void transformKeypoints(const std::vector<KeyPoint>& keypoints, InputArray homography,
                        std::vector<KeyPoint>& transformed)
{
    CV_TRACE_FUNCTION();
    const Mat given = homography.getMat();
    if (given.size() != Size(3, 3) || given.channels() != 1 || !checkRange(given))
        CV_Error(Error::StsBadArg,
                 "homography must be 3x3 finite numbers of one channel, got " +
                     format("%dx%d of %d channels", given.rows, given.cols, given.channels()));
    Matx33d h;
    given.convertTo(h, CV_64F);
    std::vector<KeyPoint> result;
    for (const KeyPoint& keypoint : keypoints)
    {
        const Vec3d p = h * Vec3d(keypoint.pt.x, keypoint.pt.y, 1);
        const double x = p[0] / p[2], y = p[1] / p[2];
        // The derivatives of the position by those in image 1.
        const Matx22d map((h(0, 0) - x * h(2, 0)) / p[2], (h(0, 1) - x * h(2, 1)) / p[2],
                          (h(1, 0) - y * h(2, 0)) / p[2], (h(1, 1) - y * h(2, 1)) / p[2]);
        KeyPoint mapped = mappedKeypoint(keypoint, Point2d(x, y), map);
        mapped.octave = keypoint.octave;
        mapped.response = keypoint.response;
        mapped.class_id = keypoint.class_id;
        result.push_back(mapped);
    }
    transformed.swap(result);
}

}  // namespace aqorb
}  // namespace cv
