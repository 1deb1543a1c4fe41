// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "precomp.hpp"

#include "input.hpp"
#include "selection.hpp"

#include <opencv2/aqorb.hpp>

namespace cv
{
namespace aqorb
{

void retainUniform(std::vector<KeyPoint>& keypoints, Size imageSize, int npoints)
{
    CV_TRACE_FUNCTION();
    checkImageSize(imageSize);
    if (npoints < 0)
        CV_Error_(Error::StsOutOfRange, ("npoints must be at least 0, got %d", npoints));

    std::vector<unsigned> inside, order;  // keypoints in the image, in the order that breaks ties
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
        // Positions are not bound to pixels, so leaves may be smaller.
        const int depth = rankedDepth(Size(INT_MAX, INT_MAX), 1, npoints);
        std::vector<LeafPoint> points;
        OrderScratch scratch;
        for (unsigned index : inside)
        {
            const Point2f p = keypoints[index].pt;
            points.push_back({LeafGrid::index(p.x, imageSize.width, depth) |
                                  LeafGrid::index(p.y, imageSize.height, depth) << depth,
                              sortKey(keypoints[index].response)});
        }
        const std::vector<unsigned> representatives = findRepresentatives(points, depth, scratch);
        std::vector<unsigned> leaves;
        std::vector<float> strengths;
        for (unsigned index : representatives)
        {
            leaves.push_back(points[index].leaf);
            strengths.push_back(keypoints[inside[index]].response);
        }
        // More even than the defaults of the detector: here all keypoints are of one level.
        const double RADIUS = 1, WEIGHT = 0.15;
        const RankRule rule = {imageSize, depth, 1, std::max(npoints, 1), RADIUS, WEIGHT};
        for (unsigned index : orderRepresentatives(leaves, strengths, rule, std::vector<uchar>()))
            order.push_back(representatives[index]);
        const std::vector<unsigned> others = orderOthers(points, representatives);
        order.insert(order.end(), others.begin(), others.end());
        order.resize(npoints);
        for (unsigned& index : order)
            index = inside[index];
        inside.swap(order);
    }
    std::sort(inside.begin(), inside.end());
    for (size_t i = 0; i < inside.size(); i++)
        keypoints[i] = keypoints[inside[i]];
    keypoints.resize(inside.size());
}

}  // namespace aqorb
}  // namespace cv
