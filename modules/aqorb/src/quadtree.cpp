// This file is part of the aqorb project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.

#include "precomp.hpp"

namespace cv
{
namespace aqorb
{
namespace stages
{

int quadtreeDepth(int quota)
{
    int depth = 0;
    while (depth < MAX_QUADTREE_DEPTH && (int64(1) << (2 * depth)) < quota)
        depth++;
    return depth;
}

static unsigned spreadBits(unsigned v)  // abcd -> 0a0b0c0d
{
    v = (v | (v << 8)) & 0x00ff00ffu;
    v = (v | (v << 4)) & 0x0f0f0f0fu;
    v = (v | (v << 2)) & 0x33333333u;
    return (v | (v << 1)) & 0x55555555u;
}

unsigned leafCode(unsigned column, unsigned row)
{
    return spreadBits(column) | (spreadBits(row) << 1);
}

// Total order by response, so that the result does not depend on the order of the points.
static bool better(const LeafPoint& a, const LeafPoint& b)
{
    const bool aIsNaN = a.response != a.response, bIsNaN = b.response != b.response;
    if (aIsNaN != bIsNaN)
        return bIsNaN;
    if (!aIsNaN && a.response != b.response)
        return a.response > b.response;
    if (a.y != b.y)
        return a.y < b.y;
    return a.x != b.x ? a.x < b.x : a.index < b.index;
}

// A point with what sorts it before `better` does.
struct SequencePoint
{
    unsigned group, rank;
    LeafPoint point;
    bool operator<(const SequencePoint& other) const
    {
        if (group != other.group)
            return group < other.group;
        return rank != other.rank ? rank < other.rank : better(point, other.point);
    }
};

// Sorts, then replaces each point's rank by its place among those of its group.
static void rankInGroups(std::vector<SequencePoint>& points)
{
    std::sort(points.begin(), points.end());
    for (size_t i = 0, first = 0; i < points.size(); i++)
    {
        if (points[i].group != points[first].group)
            first = i;
        points[i].rank = unsigned(i - first);
    }
}

void balancedSequence(std::vector<LeafPoint>& points, int depth)
{
    const int levelsUp = std::min(depth, 2);
    std::vector<SequencePoint> sequence(points.size());
    for (size_t i = 0; i < points.size(); i++)
    {
        sequence[i].group = points[i].leaf;
        sequence[i].rank = 0;
        sequence[i].point = points[i];
    }
    rankInGroups(sequence);  // in its leaf
    for (size_t i = 0; i < sequence.size(); i++)
        sequence[i].group = sequence[i].point.leaf >> (2 * levelsUp);
    rankInGroups(sequence);  // in the group of leaves
    for (size_t i = 0; i < sequence.size(); i++)
        sequence[i].group = 0;
    rankInGroups(sequence);  // in the whole tree
    for (size_t i = 0; i < points.size(); i++)
        points[i] = sequence[i].point;
}

}  // namespace stages

void retainUniform(std::vector<KeyPoint>& keypoints, Size imageSize, int npoints)
{
    using namespace stages;
    CV_TRACE_FUNCTION();
    checkImageSize(imageSize);
    if (npoints < 0)
        CV_Error_(Error::StsOutOfRange, ("npoints: got %d; >= 0 is accepted", npoints));

    const int depth = quadtreeDepth(npoints);
    const double leaves = double(1 << depth);
    std::vector<LeafPoint> points;
    points.reserve(keypoints.size());
    for (size_t i = 0; i < keypoints.size(); i++)
    {
        const Point2f p = keypoints[i].pt;
        if (!(p.x >= 0 && p.y >= 0 && p.x < imageSize.width && p.y < imageSize.height))
            continue;
        const LeafPoint point = {leafCode(unsigned(p.x * leaves / imageSize.width),
                                          unsigned(p.y * leaves / imageSize.height)),
                                 keypoints[i].response, p.x, p.y, int(i)};
        points.push_back(point);
    }
    if (points.size() > size_t(npoints))
    {
        balancedSequence(points, depth);
        points.resize(npoints);
    }
    std::vector<uchar> keep(keypoints.size(), uchar(0));
    for (size_t i = 0; i < points.size(); i++)
        keep[points[i].index] = 1;
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
