// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "precomp.hpp"

#include "selection.hpp"

namespace cv
{
namespace aqorb
{
namespace stages
{

namespace
{

// Keypoints in buckets, so that those near a point of the input image are found fast.
class KeypointGrid
{
public:
    void clear(Size imageSize)
    {
        entries.clear();
        columns = imageSize.width / SIDE + 1;
        rows = imageSize.height / SIDE + 1;
        heads.assign(size_t(columns) * rows, -1);
    }
    void insert(Point2d p)
    {
        int& head = heads[size_t(row(p.y)) * columns + column(p.x)];
        const Entry entry = {p, head};
        head = int(entries.size());
        entries.push_back(entry);
    }
    // Whether a keypoint is strictly nearer than radius.
    bool isNear(Point2d p, double radius) const
    {
        const double squaredRadius = radius * radius;
        const int top = row(p.y - radius), bottom = row(p.y + radius);
        const int left = column(p.x - radius), right = column(p.x + radius);
        for (int r = top; r <= bottom; r++)
        {
            for (int c = left; c <= right; c++)
            {
                for (int i = heads[size_t(r) * columns + c]; i >= 0; i = entries[i].next)
                {
                    const Point2d d = entries[i].position - p;
                    if (d.x * d.x + d.y * d.y < squaredRadius)
                        return true;
                }
            }
        }
        return false;
    }

private:
    struct Entry
    {
        Point2d position;
        int next;
    };
    static int bucket(double coordinate, int count)
    {
        return int(std::min(std::max(coordinate, 0.) * (1. / SIDE), count - 1.));
    }
    int column(double x) const { return bucket(x, columns); }
    int row(double y) const { return bucket(y, rows); }

    static const int SIDE = 8;  // of a bucket; smaller ones would cost more to clear than they save
    int columns, rows;
    std::vector<int> heads;
    std::vector<Entry> entries;
};

}  // namespace

class FeatureSelector::Impl
{
public:
    Impl() : octaveSuppression(0), reach(0), levelCount(0), step(0), asked(0), wanted(0), list(points) {}

    void begin(Size imageSize_, double octaveSuppression_, int suppressionReach)
    {
        reach = suppressionReach;
        imageSize = imageSize_;
        octaveSuppression = octaveSuppression_;
        levelCount = 0;
        step = 0;
        wanted = 0;
    }

    void addLevel(const SelectionLevel& added)
    {
        if (size_t(levelCount) == levels.size())
            levels.push_back(LevelState());
        LevelState& level = levels[levelCount++];
        level.given = added;
        level.hasBegun = false;
        level.chosen.clear();
    }

    int wantsOf(int level)
    {
        asked = level;
        wanted += levels[level].given.quota;
        return wanted;
    }

    bool wants(CornerRequest& request)
    {
        // What to take from the levels, from fine to coarse, when their quotas have been taken.
        static const CornerSet PASSES[] = {
            SEQUENCE_CORNERS,    // as many as are still missing after the finest level
            KEPT_CORNERS,        // nothing is left of the sequences but what octave suppression passed over
            SUPPRESSED_CORNERS,  // what other rules passed over
            WEAK_CORNERS};
        const int passes = int(sizeof(PASSES) / sizeof(PASSES[0]));
        if (wanted <= 0 || step == passes * levelCount)
            return false;
        asked = request.level = step % levelCount;
        request.set = PASSES[step / levelCount];
        step++;
        return true;
    }

    void offer(PointSequence& sequence)
    {
        LevelState& level = levels[asked];
        const bool again = level.hasBegun;
        // A sequence that has begun must get the same answers again, and finer levels have new keypoints.
        findOthers(again ? asked + 1 : asked - reach, asked + reach, others);
        if (again)
            findOthers(asked - reach, asked - 1, finer);
        const NotSuppressed filter(*this, others), now(*this, finer);
        level.hasBegun = true;
        const size_t before = level.chosen.size();
        sequence.willTake(size_t(wanted));
        LeafPoint point;
        while (level.chosen.size() < before + wanted && sequence.next(point, &filter))
        {
            // Finer levels may have chosen keypoints since the sequence began.
            if (again && !now.accepts(point))
                continue;
            const RankedCorner corner = {int(point.x), int(point.y), point.response};
            level.chosen.push_back(corner);
        }
        wanted -= int(level.chosen.size() - before);
    }

    void offer(const std::vector<RankedCorner>& offered)
    {
        LevelState& level = levels[asked];
        chosen(asked, 0, taken);
        corners.clear();
        std::set_difference(offered.begin(), offered.end(), taken.begin(), taken.end(),
                            std::back_inserter(corners), InRasterOrder());
        if (corners.size() <= size_t(wanted))
        {
            level.chosen.insert(level.chosen.end(), corners.begin(), corners.end());
            wanted -= int(corners.size());
            return;
        }
        PointSequence& filling = order(corners, level.given.order);
        LeafPoint point;
        for (; wanted > 0 && filling.next(point); wanted--)
            level.chosen.push_back(corners[point.index]);
    }

    size_t count(int level) const { return levels[level].chosen.size(); }

    // Sorts by counting, as a level has many rows with few corners each.
    void chosen(int index, size_t first, std::vector<RankedCorner>& sorted)
    {
        const LevelState& level = levels[index];
        const int rows = level.given.size.height;
        rowStarts.assign(size_t(rows) + 1, 0);
        for (size_t i = first; i < level.chosen.size(); i++)
            rowStarts[level.chosen[i].y + 1]++;
        std::partial_sum(rowStarts.begin(), rowStarts.end(), rowStarts.begin());
        sorted.resize(level.chosen.size() - first);
        for (size_t i = first; i < level.chosen.size(); i++)
            sorted[rowStarts[level.chosen[i].y]++] = level.chosen[i];
        size_t begin = 0;
        for (int y = 0; y < rows; begin = rowStarts[y++])  // row y now ends there
        {
            if (rowStarts[y] - begin > 1)
                std::sort(sorted.begin() + begin, sorted.begin() + rowStarts[y], InRasterOrder());
        }
    }

private:
    struct LevelState
    {
        SelectionLevel given;
        bool hasBegun;  // whether corners were taken from its sequence
        std::vector<RankedCorner> chosen;
    };

    // Octave suppression.
    class NotSuppressed : public PointFilter
    {
    public:
        NotSuppressed(const Impl& impl_, const KeypointGrid& others_)
            : impl(impl_),
              others(others_),
              radius(impl.octaveSuppression * impl.levels[impl.asked].given.scale)
        {
        }
        bool accepts(const LeafPoint& point) const CV_OVERRIDE
        {
            return !(radius > 0 && others.isNear(impl.position(impl.asked, point.x, point.y), radius));
        }

    private:
        const Impl& impl;
        const KeypointGrid& others;
        double radius;
    };

    // Puts the keypoints of the levels first .. last into buckets. If the level asked for is among them, it has none yet.
    void findOthers(int first, int last, KeypointGrid& found) const
    {
        if (octaveSuppression == 0)
            return;  // none will be looked for
        found.clear(imageSize);
        for (int i = std::max(first, 0); i <= std::min(last, levelCount - 1); i++)
        {
            for (const RankedCorner& corner : levels[i].chosen)
                found.insert(position(i, float(corner.x), float(corner.y)));
        }
    }

    // The exact position in the image, by pixel centres, so that positions on coarse levels are not shifted against
    // those on fine ones.
    static double position(int pixel, int levelLength, int imageLength)
    {
        return (pixel + 0.5) * imageLength / levelLength - 0.5;
    }
    Point2d position(int level, float x, float y) const
    {
        const Size size = levels[level].given.size;
        return Point2d(position(int(x), size.width, imageSize.width),
                       position(int(y), size.height, imageSize.height));
    }

    PointSequence& order(const std::vector<RankedCorner>& unordered, const OrderRule& rule)
    {
        if (!rule.isRanked)
        {
            leafPoints(unordered, rule.root, rule.depth, scratch, points);
            balanced.begin(points, rule.depth);
            return balanced;
        }
        numberLeaves(rule.root.size(), rule.depth, scratch);
        points.resize(unordered.size());
        for (size_t i = 0; i < unordered.size(); i++)
        {
            const RankedCorner& corner = unordered[i];
            const unsigned leaf =
                scratch.columns[corner.x - rule.root.x] + scratch.rows[corner.y - rule.root.y];
            const LeafPoint point = {leaf, corner.response, float(corner.x), float(corner.y), int(i)};
            points[i] = point;
        }
        list.sort();
        ranked.begin(rule.depth, list, rankedScratch);
        ranked.addAll();
        ranked.findRepresentatives();
        ranked.rank(rule.rank, 1, std::vector<uchar>());
        return ranked;
    }

    Size imageSize;
    double octaveSuppression;
    int reach;                       // of octave suppression, in levels
    std::vector<LevelState> levels;  // it never shrinks, so that levels keep their memory
    int levelCount;                  // of this image
    int step;                        // the next pass and level to ask for, after the finest level
    int asked;                       // the level of the last request
    int wanted;                      // features that are still missing
    KeypointGrid others, finer;
    BalancedSequence balanced;  // to fill up from
    RankedSequence ranked;      // to fill up from
    RankedScratch rankedScratch;
    std::vector<RankedCorner> corners;  // to fill up from
    std::vector<RankedCorner> taken;    // what the level has before
    LeafScratch scratch;
    std::vector<LeafPoint> points;
    PointList list;  // of the points
    std::vector<size_t> rowStarts;
};

FeatureSelector::FeatureSelector() : impl(makePtr<Impl>())
{
}

void FeatureSelector::begin(Size imageSize, double octaveSuppression, int suppressionReach)
{
    impl->begin(imageSize, octaveSuppression, suppressionReach);
}

void FeatureSelector::addLevel(const SelectionLevel& level)
{
    impl->addLevel(level);
}

int FeatureSelector::wantsOf(int level)
{
    return impl->wantsOf(level);
}

bool FeatureSelector::wants(CornerRequest& request)
{
    return impl->wants(request);
}

void FeatureSelector::offer(PointSequence& sequence)
{
    impl->offer(sequence);
}

void FeatureSelector::offer(const std::vector<RankedCorner>& corners)
{
    impl->offer(corners);
}

size_t FeatureSelector::count(int level) const
{
    return impl->count(level);
}

void FeatureSelector::chosen(int level, size_t first, std::vector<RankedCorner>& corners)
{
    impl->chosen(level, first, corners);
}

}  // namespace stages
}  // namespace aqorb
}  // namespace cv
