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

// The leaves' part of the code along one axis: of a root of the given length, by pixel.
static void leafCodes(int length, int depth, std::vector<unsigned>& codes)
{
    codes.resize(length);
    const int64 leaves = int64(1) << depth;
    int64 leaf = 0, rest = 0;  // pixel * leaves = leaf * length + rest
    unsigned code = leafCode(0, 0);
    for (int i = 0; i < length; i++)
    {
        codes[i] = code;
        rest += leaves;
        if (rest >= length)
        {
            leaf += rest / length;
            rest %= length;
            code = leafCode(unsigned(leaf), 0);
        }
    }
}

void leafPoints(const std::vector<RankedCorner>& corners, const Rect& root, int depth, LeafScratch& scratch,
                std::vector<LeafPoint>& points)
{
    CV_TRACE_FUNCTION();
    leafCodes(root.width, depth, scratch.columns);
    leafCodes(root.height, depth, scratch.rows);
    points.resize(corners.size());
    for (size_t i = 0; i < corners.size(); i++)
    {
        const RankedCorner& c = corners[i];
        const LeafPoint point = {scratch.columns[c.x - root.x] | scratch.rows[c.y - root.y] << 1, c.response,
                                 float(c.x), float(c.y), int(i)};
        points[i] = point;
    }
}

namespace
{

// Orders responses as whole numbers do; NaN comes before all.
unsigned orderedResponse(float response)
{
    if (cvIsNaN(response))
        return 0;
    Cv32suf bits;
    bits.f = response + 0.f;  // -0 is 0
    return bits.u & 0x80000000u ? ~bits.u : bits.u | 0x80000000u;
}

// Total order by response, so that the result does not depend on the order of the points.
struct Better
{
    bool operator()(const LeafPoint& a, const LeafPoint& b) const
    {
        if (a.response > b.response)
            return true;
        if (a.response < b.response)
            return false;
        const unsigned ra = orderedResponse(a.response), rb = orderedResponse(b.response);
        if (ra != rb)
            return ra > rb;
        if (a.y != b.y)
            return a.y < b.y;
        return a.x != b.x ? a.x < b.x : a.index < b.index;
    }
};

// Stable, by several bits at a time.
void sortByLeaf(std::vector<LeafPoint>& points, int depth, std::vector<LeafPoint>& sorted)
{
    const int DIGIT = 11, VALUES = 1 << DIGIT;
    sorted.resize(points.size());
    for (int shift = 0; shift < 2 * depth; shift += DIGIT)
    {
        unsigned starts[VALUES + 1] = {0};
        for (size_t i = 0; i < points.size(); i++)
            starts[((points[i].leaf >> shift) & (VALUES - 1)) + 1]++;
        for (int i = 0; i < VALUES; i++)
            starts[i + 1] += starts[i];
        for (size_t i = 0; i < points.size(); i++)
            sorted[starts[(points[i].leaf >> shift) & (VALUES - 1)]++] = points[i];
        points.swap(sorted);
    }
}

}  // namespace

// Work is done as the sequence is asked for: as a rule a level needs little more than the best of each
// leaf, while it has many times as many corners.

void BalancedSequence::begin(std::vector<LeafPoint>& points_, int depth)
{
    CV_TRACE_FUNCTION();
    points.swap(points_);
    leaves.clear();
    groups.clear();
    round = 0;
    offers.clear();
    given = 0;
    sortByLeaf(points, depth, lists);
    const int groupShift = 2 * std::min(depth, 2);
    for (size_t i = 0; i < points.size(); i++)
    {
        const unsigned leaf = points[i].leaf;
        if (i == 0 || leaf != points[i - 1].leaf)
        {
            if (i == 0 || leaf >> groupShift != points[i - 1].leaf >> groupShift)
            {
                const Group group = {leaves.size(), leaves.size(), i, 0};
                groups.push_back(group);
            }
            const Leaf newLeaf = {i, i, 0};
            leaves.push_back(newLeaf);
            groups.back().endLeaf++;
        }
        leaves.back().end++;
    }
    // Here rather than as it is asked for: sequences are begun side by side, but taken from one by one.
    for (size_t i = 0; i < leaves.size(); i++)
        bringBestToFront(leaves[i]);
    lists.resize(points.size());
}

void BalancedSequence::bringBestToFront(const Leaf& leaf)
{
    const std::vector<LeafPoint>::iterator begin = points.begin() + leaf.begin,
                                           end = points.begin() + leaf.end;
    std::iter_swap(begin, std::min_element(begin, end, Better()));
}

// Takes the best point off a leaf that the filter lets pass. False: there is none.
bool BalancedSequence::takeBest(Leaf& leaf, const PointFilter* filter, LeafPoint& best)
{
    // Selection pays for the first few; who asks for more gets the rest sorted.
    const int SELECTED = 4;
    while (leaf.begin < leaf.end)
    {
        if (leaf.taken > 0 && leaf.taken < SELECTED)
            bringBestToFront(leaf);
        else if (leaf.taken == SELECTED)
            std::sort(points.begin() + leaf.begin, points.begin() + leaf.end, Better());
        leaf.taken++;
        best = points[leaf.begin++];
        if (!filter || filter->accepts(best))
            return true;
    }
    return false;
}

// Appends the next best of each of the group's leaves to its list. False: there are none.
bool BalancedSequence::extend(Group& group, const PointFilter* filter)
{
    const std::vector<LeafPoint>::iterator begin = lists.begin() + group.list + group.listed;
    std::vector<LeafPoint>::iterator end = begin;
    LeafPoint best;
    for (size_t i = group.firstLeaf; i < group.endLeaf; i++)
    {
        if (takeBest(leaves[i], filter, best))
            *end++ = best;
    }
    std::sort(begin, end, Better());
    group.listed += end - begin;
    return begin != end;
}

bool BalancedSequence::next(LeafPoint& point, const PointFilter* filter)
{
    if (given == offers.size())
    {
        offers.clear();
        given = 0;
        size_t left = 0;  // groups that are not exhausted
        for (size_t i = 0; i < groups.size(); i++)
        {
            if (round == groups[i].listed && !extend(groups[i], filter))
                continue;
            offers.push_back(lists[groups[i].list + round]);
            groups[left++] = groups[i];
        }
        groups.resize(left);
        if (offers.empty())
            return false;
        std::sort(offers.begin(), offers.end(), Better());
        round++;
    }
    point = offers[given++];
    return true;
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
        const LeafPoint point = {
            leafCode(unsigned(p.x * leaves / imageSize.width), unsigned(p.y * leaves / imageSize.height)),
            keypoints[i].response, p.x, p.y, int(i)};
        points.push_back(point);
    }
    if (points.size() > size_t(npoints))
    {
        BalancedSequence sequence;
        sequence.begin(points, depth);
        points.resize(npoints);
        for (int i = 0; i < npoints; i++)
            sequence.next(points[i]);
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
