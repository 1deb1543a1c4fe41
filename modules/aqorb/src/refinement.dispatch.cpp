// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// The positions of matches: which patches are compared, and which matches are kept.

#include "precomp.hpp"

#include "arguments.hpp"
#include "descriptor.hpp"
#include "for_each.hpp"
#include "refinement.hpp"

#include "refinement.simd.hpp"
#include "refinement.simd_declarations.hpp"

#include <opencv2/aqorb/refinement.hpp>

namespace cv
{
namespace aqorb
{

void alignPatches(const PatchPair* pairs, int count, Alignment* alignments)
{
    CV_TRACE_FUNCTION();
    CV_CPU_DISPATCH(alignByLanes, (pairs, count, alignments), CV_CPU_DISPATCH_MODES_ALL);
}

namespace
{

// An image and its halves, from which patches are sampled.
struct Halves
{
    void build(const Mat& image, int count)
    {
        images.assign(1, image.step > size_t(MAX_PATCH_STEP) ? image.clone() : image);
        while (int(images.size()) < count && std::min(images.back().cols, images.back().rows) > 1)
        {
            const Mat& last = images.back();
            const Size size(last.cols / 2, last.rows / 2);
            Mat half;
            resize(last(Rect(0, 0, 2 * size.width, 2 * size.height)), half, size, 0, 0, INTER_AREA);
            images.push_back(half);
        }
    }

    // The place of a position in pixels of the image. False where there is none.
    bool find(const Point2f& position, int level, PatchPlace& place) const
    {
        if (size_t(level) >= images.size())
            return false;
        const Mat& image = images[size_t(level)];
        const double size = 1 << level;
        const double x = (position.x + 0.5) / size - 0.5, y = (position.y + 0.5) / size - 0.5;
        if (!(x >= 0 && y >= 0 && x < image.cols - 1 && y < image.rows - 1))
            return false;
        const int left = std::max(cvFloor(x) - PATCH_AREA / 2, 0),
                  top = std::max(cvFloor(y) - PATCH_AREA / 2, 0);
        const float MARGIN = 0.01f;  // rounding must not reach the last column or row
        place.origin = image.ptr(top) + left;
        place.step = int(image.step);
        place.x = float(x - left);
        place.y = float(y - top);
        place.right = std::min(image.cols - 1 - left, PATCH_AREA) - MARGIN;
        place.bottom = std::min(image.rows - 1 - top, PATCH_AREA) - MARGIN;
        return true;
    }

    Point2f positionOf(const PatchPlace& place, int level, const Alignment& alignment) const
    {
        const ptrdiff_t offset = place.origin - images[size_t(level)].ptr();
        const ptrdiff_t left = offset % place.step, top = offset / place.step;
        const double size = 1 << level;
        return Point2f(float((double(left) + alignment.x + 0.5) * size - 0.5),
                       float((double(top) + alignment.y + 0.5) * size - 0.5));
    }

    std::vector<Mat> images;
};

// A match, and how its patches are sampled.
struct Sampling
{
    int levels[2];       // of the halves
    double spacings[2];  // of samples, in pixels of the images
    float turn;          // of the second keypoint against the first one, in degrees
    bool isDefined;      // whether keypoints have sizes and angles by which they can be sampled
};

const int MAX_HALVES = 5;

// Samples are one to two pixels of their level apart.
int levelOf(double spacing)
{
    int level = 0;
    while (level < MAX_HALVES - 1 && spacing >= (2 << level))
        level++;
    return level;
}

Sampling samplingOf(const KeyPoint& first, const KeyPoint& second, float scaleFactor)
{
    const double ORB_SIZE = 31, MIN_SPACING = 0.7, MAX_SPACING = PATCH_AREA << MAX_HALVES;
    const double pixel = first.size / ORB_SIZE * scaleFactor;  // of the keypoint's pyramid level
    Sampling sampling;
    sampling.spacings[0] = std::max(MIN_SPACING, pixel / 2);
    sampling.spacings[1] = sampling.spacings[0] * second.size / first.size;
    const bool isUpright = first.angle == -1 || second.angle == -1;
    sampling.turn = isUpright ? 0 : float(std::fmod(double(second.angle) - first.angle, 360.));
    sampling.isDefined = first.size > 0 && second.size > 0 && sampling.spacings[0] < MAX_SPACING &&
                         sampling.spacings[1] < MAX_SPACING && std::isfinite(sampling.turn);
    for (int i = 0; i < 2; i++)
        sampling.levels[i] = sampling.isDefined ? levelOf(sampling.spacings[i]) : 0;
    return sampling;
}

// The grey image; empty for an input without pixels.
Mat grayOf(InputArray image, const char* name, bool isNeeded)
{
    if (image.empty() && isNeeded)
        CV_Error_(Error::StsBadArg, ("%s must have pixels, as there are matches", name));
    if (image.empty())
        return Mat();
    checkImage(image, name);
    return grayImage(image);
}

void checkMatches(const std::vector<DMatch>& matches, size_t count1, size_t count2)
{
    for (size_t i = 0; i < matches.size(); i++)
    {
        const int query = matches[i].queryIdx, train = matches[i].trainIdx;
        if (query < 0 || size_t(query) >= count1 || train < 0 || size_t(train) >= count2)
            CV_Error_(Error::StsOutOfRange,
                      ("matches[%d] must have a queryIdx below %d and a trainIdx below %d, the numbers of "
                       "keypoints, and at least 0, got %d and %d",
                       int(i), int(count1), int(count2), query, train));
    }
}

}  // namespace

void refineMatches(InputArray image1, const std::vector<KeyPoint>& keypoints1, InputArray image2,
                   const std::vector<KeyPoint>& keypoints2, std::vector<DMatch>& matches,
                   std::vector<Point2f>& points1, std::vector<Point2f>& points2, float minCorrelation,
                   float scaleFactor)
{
    CV_TRACE_FUNCTION();
    if (!(minCorrelation >= -1 && minCorrelation <= 1))
        CV_Error_(Error::StsOutOfRange, ("minCorrelation must be from -1 to 1, got %g", minCorrelation));
    if (!(scaleFactor > 0) || !std::isfinite(scaleFactor))
        CV_Error_(Error::StsOutOfRange, ("scaleFactor must be finite and > 0, got %g", scaleFactor));
    checkMatches(matches, keypoints1.size(), keypoints2.size());
    const UMat held1 = retainUMat(image1), held2 = retainUMat(image2);
    const Mat grays[] = {grayOf(image1, "image1", !matches.empty()),
                         grayOf(image2, "image2", !matches.empty())};

    std::vector<Sampling> samplings;
    int levels[] = {1, 1};
    for (const DMatch& match : matches)
    {
        samplings.push_back(samplingOf(keypoints1[match.queryIdx], keypoints2[match.trainIdx], scaleFactor));
        for (int i = 0; i < 2; i++)
            levels[i] = std::max(levels[i], samplings.back().levels[i] + 1);
    }
    const int threads = threadsAllowed();
    Halves halves[2];
    forEach(2, threads, [&](size_t i, int) { halves[i].build(grays[i], levels[i]); });

    // Each thread takes some matches at a time.
    const size_t CHUNK = 64;
    std::vector<Point2f> refined(matches.size());
    std::vector<uchar> isKept(matches.size());
    const auto refineChunk = [&](size_t chunk, int)
    {
        std::vector<PatchPair> pairs;
        std::vector<size_t> indices;
        for (size_t i = chunk * CHUNK; i < std::min((chunk + 1) * CHUNK, matches.size()); i++)
        {
            const Sampling& by = samplings[i];
            const KeyPoint &first = keypoints1[matches[i].queryIdx],
                           &second = keypoints2[matches[i].trainIdx];
            refined[i] = second.pt;
            isKept[i] = minCorrelation == -1;
            PatchPair pair;
            if (!by.isDefined || !halves[0].find(first.pt, by.levels[0], pair.first) ||
                !halves[1].find(second.pt, by.levels[1], pair.second))
                continue;
            float sine, cosine;
            sineAndCosine(by.turn * float(CV_PI / 180), sine, cosine);
            pair.spacing = float(by.spacings[0] / (1 << by.levels[0]));
            const float spacing = float(by.spacings[1] / (1 << by.levels[1]));
            pair.map[0] = pair.map[3] = spacing * cosine;
            pair.map[1] = -spacing * sine;
            pair.map[2] = spacing * sine;
            pairs.push_back(pair);
            indices.push_back(i);
        }
        std::vector<Alignment> alignments(pairs.size());
        alignPatches(pairs.data(), int(pairs.size()), alignments.data());
        for (size_t k = 0; k < pairs.size(); k++)
        {
            if (alignments[k].correlation == NOT_ALIGNED)
                continue;
            const size_t i = indices[k];
            refined[i] = halves[1].positionOf(pairs[k].second, samplings[i].levels[1], alignments[k]);
            isKept[i] |= alignments[k].correlation >= minCorrelation;
        }
    };
    forEach((matches.size() + CHUNK - 1) / CHUNK, threads, refineChunk);

    std::vector<DMatch> kept;
    std::vector<Point2f> kept1, kept2;
    for (size_t i = 0; i < matches.size(); i++)
    {
        if (!isKept[i])
            continue;
        kept.push_back(matches[i]);
        kept1.push_back(keypoints1[matches[i].queryIdx].pt);
        kept2.push_back(refined[i]);
    }
    matches.swap(kept);
    points1.swap(kept1);
    points2.swap(kept2);
}

}  // namespace aqorb
}  // namespace cv
