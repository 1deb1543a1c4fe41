// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// retainUniform: uniform selection of keypoints of any detector.

#include "precomp.hpp"

#include "detector/arguments.hpp"
#include "detector/selection.hpp"

#include <opencv2/aqorb.hpp>

namespace cv
{
namespace aqorb
{

typedef std::vector<unsigned> Indices;

// Keypoints inside the image.
static Indices keypointsInside(const std::vector<KeyPoint>& keypoints, Size imageSize)
{
    Indices inside;
    for (size_t i = 0; i < keypoints.size(); i++)
    {
        const Point2f p = keypoints[i].pt;
        if (p.x >= 0 && p.y >= 0 && p.x < imageSize.width && p.y < imageSize.height)
            inside.push_back(unsigned(i));
    }
    return inside;
}

// Order of keypoints by descending response. A hash breaks the ties of responses, which many detectors leave equal:
// raster order would prefer the top.
static Indices orderByResponse(const std::vector<KeyPoint>& keypoints)
{
    std::vector<uint64> keys;
    for (size_t i = 0; i < keypoints.size(); i++)
        keys.push_back(uint64(descendingKey(sortKey(keypoints[i].response))) << 32 |
                       unsigned(i) * 0x9e3779b1u);
    return sortIndices(keys);
}

// Responses in units of the highest one: the result does not depend on their unit.
static std::vector<float> relativeStrengths(const std::vector<KeyPoint>& keypoints,
                                            const Indices& representatives)
{
    const float MIN_STRENGTH = std::numeric_limits<float>::denorm_min();
    double highest = 0;
    for (const KeyPoint& keypoint : keypoints)
        if (std::isfinite(keypoint.response))
            highest = std::max(highest, double(keypoint.response));
    std::vector<float> strengths;
    for (unsigned index : representatives)
    {
        const float response = keypoints[index].response;
        strengths.push_back(response > 0 && std::isfinite(response)
                                ? std::max(float(std::ldexp(response / highest, 127)), MIN_STRENGTH)
                                : response);
    }
    return strengths;
}

// The best keypoints: representatives of leaves in the order of the rule, then the others by response.
static Indices mostUniform(const std::vector<KeyPoint>& keypoints, Size imageSize, int npoints)
{
    // Positions are not bound to pixels, so leaves may be smaller than a pixel.
    const LeafGrid grid = rankedGrid(Size(INT_MAX, INT_MAX), 1, npoints);
    const Indices byResponse = orderByResponse(keypoints);
    std::vector<LeafPoint> points;
    for (const KeyPoint& keypoint : keypoints)
        points.push_back({leafOf(keypoint.pt.x, keypoint.pt.y, imageSize, grid), 0});
    for (size_t i = 0; i < byResponse.size(); i++)
        points[byResponse[i]].key = -int(i);
    Indices representatives = findRepresentatives(points, grid);
    std::sort(representatives.begin(), representatives.end(),
              [&](unsigned a, unsigned b) { return points[a].key > points[b].key; });
    Indices leaves;
    for (unsigned index : representatives)
        leaves.push_back(points[index].leaf);
    // More uniform than the detector's defaults, because all keypoints are on one level.
    const double RADIUS = 1, WEIGHT = 0.15;
    const RankRule rule = {imageSize, grid, 1, std::max(npoints, 1), RADIUS, WEIGHT};
    const std::vector<float> strengths = relativeStrengths(keypoints, representatives);
    Indices order;
    std::vector<uchar> isListed(keypoints.size());
    for (unsigned index : orderRepresentatives(leaves, strengths, rule, std::vector<uchar>()))
    {
        order.push_back(representatives[index]);
        isListed[order.back()] = 1;
    }
    for (unsigned index : byResponse)
        if (!isListed[index])
            order.push_back(index);
    order.resize(npoints);
    return order;
}

void retainUniform(std::vector<KeyPoint>& keypoints, Size imageSize, int npoints)
{
    CV_TRACE_FUNCTION();
    checkImageSize(imageSize);
    if (npoints < 0)
        CV_Error_(Error::StsOutOfRange, ("npoints must be at least 0, got %d", npoints));
    Indices kept = keypointsInside(keypoints, imageSize);
    if (kept.size() > size_t(npoints))
    {
        // From top to bottom, so that ties do not depend on the order of the caller's keypoints.
        std::sort(kept.begin(), kept.end(),
                  [&](unsigned a, unsigned b)
                  {
                      const Point2f &p = keypoints[a].pt, &q = keypoints[b].pt;
                      return p.y != q.y ? p.y < q.y : p.x != q.x ? p.x < q.x : a < b;
                  });
        std::vector<KeyPoint> inside;
        for (unsigned index : kept)
            inside.push_back(keypoints[index]);
        Indices best = mostUniform(inside, imageSize, npoints);
        for (unsigned& index : best)
            index = kept[index];
        kept.swap(best);
    }
    std::sort(kept.begin(), kept.end());
    for (size_t i = 0; i < kept.size(); i++)
        keypoints[i] = keypoints[kept[i]];
    keypoints.resize(kept.size());
}

}  // namespace aqorb
}  // namespace cv
