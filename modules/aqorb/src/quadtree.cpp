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
bool better(const LeafPoint& a, const LeafPoint& b)
{
    const unsigned ra = orderedResponse(a.response), rb = orderedResponse(b.response);
    if (ra != rb)
        return ra > rb;
    if (a.y != b.y)
        return a.y < b.y;
    return a.x != b.x ? a.x < b.x : a.index < b.index;
}

// Stable, by 8 bits at a time.
void sortByLeaf(std::vector<LeafPoint>& points, int depth, std::vector<LeafPoint>& sorted)
{
    const int DIGIT = 8, VALUES = 1 << DIGIT;
    sorted.resize(points.size());
    for (int shift = 0; shift < 2 * depth; shift += DIGIT)
    {
        size_t starts[VALUES + 1] = {0};
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
                const Group group = {leaves.size(), leaves.size(), 0, 0, 0};
                groups.push_back(group);
            }
            const Leaf newLeaf = {i, i};
            leaves.push_back(newLeaf);
            groups.back().endLeaf++;
        }
        leaves.back().end++;
    }
    for (size_t i = 0; i < groups.size(); i++)
        groups[i].list = leaves[groups[i].firstLeaf].begin;
    lists.resize(points.size());
}

// Puts the best of what remains of a leaf first, where its last was taken before.
void BalancedSequence::bringUpNext(Leaf& leaf, size_t taken)
{
    // Selection pays for the first few; who asks for more gets the rest sorted.
    const size_t SELECTED = 4;
    if (taken < SELECTED)
        std::iter_swap(
            points.begin() + leaf.begin + taken,
            std::min_element(points.begin() + leaf.begin + taken, points.begin() + leaf.end, better));
    else if (taken == SELECTED)
        std::sort(points.begin() + leaf.begin + taken, points.begin() + leaf.end, better);
}

// Appends the next best of each of the group's leaves to its list. False: there are none.
bool BalancedSequence::extend(Group& group)
{
    const size_t before = group.listed;
    for (size_t i = group.firstLeaf; i < group.endLeaf; i++)
    {
        Leaf& leaf = leaves[i];
        if (leaf.end - leaf.begin <= group.rounds)
            continue;
        bringUpNext(leaf, group.rounds);
        lists[group.list + group.listed++] = points[leaf.begin + group.rounds];
    }
    std::sort(lists.begin() + group.list + before, lists.begin() + group.list + group.listed, better);
    group.rounds++;
    return group.listed > before;
}

bool BalancedSequence::next(LeafPoint& point)
{
    if (given == offers.size())
    {
        offers.clear();
        given = 0;
        size_t left = 0;  // groups that are not exhausted
        for (size_t i = 0; i < groups.size(); i++)
        {
            if (round == groups[i].listed && !extend(groups[i]))
                continue;
            offers.push_back(lists[groups[i].list + round]);
            groups[left++] = groups[i];
        }
        groups.resize(left);
        if (offers.empty())
            return false;
        std::sort(offers.begin(), offers.end(), better);
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
