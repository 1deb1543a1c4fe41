// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "precomp.hpp"

#include "input.hpp"
#include "parameters.hpp"
#include "ranked_sequence.hpp"

#include <opencv2/aqorb.hpp>

namespace cv
{
namespace aqorb
{

void retainUniform(std::vector<KeyPoint>& keypoints, Size imageSize, int npoints)
{
    using namespace stages;
    CV_TRACE_FUNCTION();
    checkImageSize(imageSize);
    if (npoints < 0)
        CV_Error_(Error::StsOutOfRange, ("npoints: got %d; >= 0 is accepted", npoints));

    // Positions are not bound to pixels, so leaves may be smaller.
    const Size LARGE(INT_MAX, INT_MAX);
    const int depth = rankedDepth(LARGE, 1, npoints);
    const double leaves = double(1 << depth);
    std::vector<uchar> keep(keypoints.size(), uchar(0));
    std::vector<LeafPoint> points;
    points.reserve(keypoints.size());
    for (size_t i = 0; i < keypoints.size(); i++)
    {
        const Point2f p = keypoints[i].pt;
        if (!(p.x >= 0 && p.y >= 0 && p.x < imageSize.width && p.y < imageSize.height))
            continue;
        const unsigned leaf = leafColumn(int(p.x * leaves / imageSize.width)) +
                              leafRow(int(p.y * leaves / imageSize.height), depth);
        const LeafPoint point = {leaf, keypoints[i].response, p.x, p.y, int(i)};
        points.push_back(point);
    }
    if (points.size() > size_t(npoints))
    {
        const Parameters defaults;
        const RankRule rule = {imageSize, 1, std::max(npoints, 1), defaults.rankRadius,
                               defaults.strengthWeight};
        PointList list(points);
        list.sort();
        RankedScratch scratch;
        RankedSequence sequence;
        sequence.begin(depth, list, scratch);
        sequence.addAll();
        sequence.findRepresentatives();
        sequence.rank(rule, 1, std::vector<uchar>());
        LeafPoint point;
        for (int i = 0; i < npoints && sequence.next(point); i++)
            keep[point.index] = 1;
    }
    else
    {
        for (size_t i = 0; i < points.size(); i++)
            keep[points[i].index] = 1;
    }
    size_t kept = 0;
    for (size_t i = 0; i < keypoints.size(); i++)
    {
        if (keep[i])
            keypoints[kept++] = keypoints[i];
    }
    keypoints.resize(kept);
}

}  // namespace aqorb
}  // namespace cv
