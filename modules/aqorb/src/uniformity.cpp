// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// Functions for keypoints of any detector: uniformity of their distribution, and uniform selection.

#include "precomp.hpp"

#include "arguments.hpp"
#include "selection.hpp"

#include <opencv2/aqorb.hpp>

namespace cv
{
namespace aqorb
{

double distributionUniformity(const std::vector<KeyPoint>& keypoints, Size imageSize)
{
    checkImageSize(imageSize);
    const double W = imageSize.width, H = imageSize.height;
    const int HALVINGS = 5;
    int64 first[HALVINGS] = {};  // keypoints in the first region of each halving
    int64 count = 0;
    for (size_t i = 0; i < keypoints.size(); i++)
    {
        const double x = keypoints[i].pt.x, y = keypoints[i].pt.y;
        if (!std::isfinite(x) || !std::isfinite(y))
            continue;
        count++;
        first[0] += x <= W / 2;
        first[1] += y <= H / 2;
        first[2] += y * W - x * H < 0;          // above the main diagonal
        first[3] += y * W + x * H - W * H < 0;  // above the other diagonal
        // in the centred rectangle of half the area
        first[4] +=
            std::abs(x - W / 2) <= W / (2 * std::sqrt(2.)) && std::abs(y - H / 2) <= H / (2 * std::sqrt(2.));
    }
    // Both counts of a halving deviate equally from their mean, count / 2.
    double squares = 0;
    for (int i = 0; i < HALVINGS; i++)
    {
        const double deviation = first[i] - count / 2.;
        squares += deviation * deviation;
    }
    const double sigma = std::sqrt(squares / HALVINGS);
    return 101 * std::log10(std::max(sigma, 1.));
}

double distributionOccupancy(const std::vector<KeyPoint>& keypoints, Size imageSize, Size grid)
{
    checkImageSize(imageSize);
    if (grid.width <= 0 || grid.height <= 0 || int64(grid.width) * grid.height > (1 << 24))
        CV_Error_(Error::StsOutOfRange, ("grid must be positive and have at most 2^24 cells, got %d x %d",
                                         grid.width, grid.height));
    std::vector<uchar> occupied(size_t(grid.width) * grid.height, uchar(0));
    size_t cells = 0;
    for (size_t i = 0; i < keypoints.size(); i++)
    {
        const double x = keypoints[i].pt.x, y = keypoints[i].pt.y;
        if (!(x >= 0 && y >= 0 && x < imageSize.width && y < imageSize.height))
            continue;
        const int column = int(x * grid.width / imageSize.width);
        const int row = int(y * grid.height / imageSize.height);
        uchar& cell = occupied[size_t(row) * grid.width + column];
        cells += !cell;
        cell = 1;
    }
    return double(cells) / double(occupied.size());
}

void retainUniform(std::vector<KeyPoint>& keypoints, Size imageSize, int npoints)
{
    CV_TRACE_FUNCTION();
    checkImageSize(imageSize);
    if (npoints < 0)
        CV_Error_(Error::StsOutOfRange, ("npoints must be at least 0, got %d", npoints));

    std::vector<unsigned> inside, order;  // keypoints inside the image, in the order that breaks ties
    for (size_t i = 0; i < keypoints.size(); i++)
    {
        const Point2f p = keypoints[i].pt;
        if (p.x >= 0 && p.y >= 0 && p.x < imageSize.width && p.y < imageSize.height)
            inside.push_back(unsigned(i));
    }
    if (inside.size() > size_t(npoints))
    {
        std::sort(inside.begin(), inside.end(),
                  [&](unsigned a, unsigned b)
                  {
                      const Point2f &p = keypoints[a].pt, &q = keypoints[b].pt;
                      return p.y != q.y ? p.y < q.y : p.x != q.x ? p.x < q.x : a < b;
                  });
        // Positions are not bound to pixels, so leaves may be smaller than a pixel.
        const LeafGrid grid = rankedGrid(Size(INT_MAX, INT_MAX), 1, npoints);
        // A hash breaks the ties of responses, which many detectors leave equal: raster order would prefer the top.
        std::vector<LeafPoint> points;
        std::vector<uint64> keys;
        for (size_t i = 0; i < inside.size(); i++)
        {
            const KeyPoint& keypoint = keypoints[inside[i]];
            points.push_back({leafOf(keypoint.pt.x, keypoint.pt.y, imageSize, grid), 0});
            keys.push_back(uint64(descendingKey(sortKey(keypoint.response))) << 32 |
                           unsigned(i) * 0x9e3779b1u);
        }
        const std::vector<unsigned> byResponse = sortIndices(keys);
        for (size_t i = 0; i < byResponse.size(); i++)
            points[byResponse[i]].key = -int(i);
        std::vector<unsigned> representatives = findRepresentatives(points, grid);
        std::sort(representatives.begin(), representatives.end(),
                  [&](unsigned a, unsigned b) { return points[a].key > points[b].key; });
        std::vector<unsigned> leaves;
        std::vector<float> strengths;
        const float MIN_STRENGTH = std::numeric_limits<float>::denorm_min();
        // Dividing by the highest response makes the result independent of the responses' unit.
        double highest = 0;
        for (unsigned index : inside)
            if (std::isfinite(keypoints[index].response))
                highest = std::max(highest, double(keypoints[index].response));
        for (unsigned index : representatives)
        {
            const float response = keypoints[inside[index]].response;
            leaves.push_back(points[index].leaf);
            strengths.push_back(response > 0 && std::isfinite(response)
                                    ? std::max(float(std::ldexp(response / highest, 127)), MIN_STRENGTH)
                                    : response);
        }
        // More uniform than the detector's defaults, because all keypoints are on one level.
        const double RADIUS = 1, WEIGHT = 0.15;
        const RankRule rule = {imageSize, grid, 1, std::max(npoints, 1), RADIUS, WEIGHT};
        std::vector<uchar> isListed(keypoints.size());
        for (unsigned index : orderRepresentatives(leaves, strengths, rule, std::vector<uchar>()))
        {
            order.push_back(inside[representatives[index]]);
            isListed[order.back()] = 1;
        }
        // After the representatives, the other keypoints follow by response.
        for (unsigned index : byResponse)
        {
            if (!isListed[inside[index]])
                order.push_back(inside[index]);
        }
        order.resize(npoints);
        inside.swap(order);
    }
    std::sort(inside.begin(), inside.end());
    for (size_t i = 0; i < inside.size(); i++)
        keypoints[i] = keypoints[inside[i]];
    keypoints.resize(inside.size());
}

}  // namespace aqorb
}  // namespace cv
