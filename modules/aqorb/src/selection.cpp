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

namespace
{

// The chosen keypoints of all levels in buckets, to ask for those near a point of the input image.
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
    void insert(Point2d p, int level)
    {
        int& head = heads[size_t(row(p.y)) * columns + column(p.x)];
        const Entry entry = {p, level, head};
        head = int(entries.size());
        entries.push_back(entry);
    }
    // Whether a keypoint of another level is strictly nearer than radius.
    bool isNear(Point2d p, double radius, int exceptLevel) const
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
                    if (entries[i].level != exceptLevel && d.x * d.x + d.y * d.y < squaredRadius)
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
        int level, next;
    };
    static int bucket(double coordinate, int count)
    {
        return int(std::min(std::max(coordinate, 0.) * (1. / SIDE), count - 1.));
    }
    int column(double x) const { return bucket(x, columns); }
    int row(double y) const { return bucket(y, rows); }

    static const int SIDE = 8;  // of a bucket; smaller ones cost more to clear than they save
    int columns, rows;
    std::vector<int> heads;
    std::vector<Entry> entries;
};

}  // namespace

class FeatureSelector::Impl
{
public:
    void begin(const std::vector<SelectionLevel>& levels_, Size imageSize_, double octaveSuppression,
               CornerSource& source_, std::vector<std::vector<RankedCorner>>& chosen_)
    {
        levels = levels_;
        imageSize = imageSize_;
        source = &source_;
        chosen = &chosen_;
        chosen->resize(levels.size());
        states.resize(std::max(states.size(), levels.size()));
        for (size_t i = 0; i < levels.size(); i++)
        {
            (*chosen)[i].clear();
            states[i].begun = false;
            states[i].radius = octaveSuppression * levels[i].scale;
        }
        grid.clear(imageSize);
    }

    // Coarse to fine: unmet quota goes to the next finer level. Returns what remains after the finest.
    int chooseQuotas()
    {
        int wanted = 0;
        for (int level = int(levels.size()) - 1; level >= 0; level--)
        {
            wanted += levels[level].quota;
            if (wanted > 0)
                wanted -= choose(level, wanted);
        }
        return wanted;
    }
    // Fine to coarse: each level goes on in its sequence.
    int chooseMore(int wanted)
    {
        for (int level = 0; level < int(levels.size()) && wanted > 0; level++)
            wanted -= choose(level, wanted);
        return wanted;
    }
    // Fine to coarse, from the corners that octave suppression passed over.
    int fillFromPassedOver(int wanted)
    {
        for (int level = 0; level < int(levels.size()) && wanted > 0; level++)
            wanted -= fill(level, states[level].passedOver, wanted);
        return wanted;
    }
    // Fine to coarse, from corners that other rules passed over.
    int fillFrom(CornerSet set, int wanted)
    {
        for (int level = 0; level < int(levels.size()) && wanted > 0; level++)
        {
            source->corners(level, set, corners);
            wanted -= fill(level, corners, wanted);
        }
        return wanted;
    }

private:
    struct Line  // a column or row of a level
    {
        double position;  // in the input image
        unsigned leaf;    // its part of the code of the quadtree's leaves
    };

    struct LevelState
    {
        LevelState() : begun(false), radius(0) {}
        bool begun;
        double radius;  // of octave suppression, in pixels of the input image
        std::vector<Line> columns, rows;
        std::vector<RankedCorner> candidates;  // those that the sequence gives the indices of
        BalancedSequence sequence;
        std::vector<RankedCorner> passedOver;
    };

    Point2d position(int level, const RankedCorner& corner) const
    {
        return Point2d(states[level].columns[corner.x].position, states[level].rows[corner.y].position);
    }

    bool isSuppressed(int level, const RankedCorner& corner) const
    {
        const double radius = states[level].radius;
        return radius > 0 && grid.isNear(position(level, corner), radius, level);
    }

    void beginSequence(BalancedSequence& sequence, int level, const std::vector<RankedCorner>& of)
    {
        const LevelState& state = states[level];
        points.resize(of.size());
        for (size_t i = 0; i < of.size(); i++)
        {
            const RankedCorner& c = of[i];
            const LeafPoint point = {state.columns[c.x].leaf | state.rows[c.y].leaf << 1, c.response,
                                     float(c.x), float(c.y), int(i)};
            points[i] = point;
        }
        sequence.begin(points, levels[level].depth);
    }

    // Tables of a level's columns or rows. Positions are by pixel centres, exactly: those of coarse
    // levels must not be shifted against those of fine ones.
    static void tabulate(int levelLength, int imageLength, int rootBegin, int rootLength, int depth,
                         std::vector<Line>& lines)
    {
        lines.resize(levelLength);
        for (int i = 0; i < levelLength; i++)
        {
            lines[i].position = (i + 0.5) * imageLength / levelLength - 0.5;
            const bool inRoot = i >= rootBegin && i < rootBegin + rootLength;
            lines[i].leaf = inRoot ? leafCode(unsigned((int64(i - rootBegin) << depth) / rootLength), 0) : 0;
        }
    }

    void beginLevel(int level)
    {
        const SelectionLevel& l = levels[level];
        LevelState& state = states[level];
        tabulate(l.size.width, imageSize.width, l.root.x, l.root.width, l.depth, state.columns);
        tabulate(l.size.height, imageSize.height, l.root.y, l.root.height, l.depth, state.rows);
        state.candidates.clear();
        state.passedOver.clear();
        source->corners(level, KEPT_CORNERS, corners);
        for (size_t i = 0; i < corners.size(); i++)
            (isSuppressed(level, corners[i]) ? state.passedOver : state.candidates).push_back(corners[i]);
        beginSequence(state.sequence, level, state.candidates);
        state.begun = true;
    }

    int choose(int level, int wanted)
    {
        LevelState& state = states[level];
        const bool first = !state.begun;
        if (first)
            beginLevel(level);
        std::vector<RankedCorner>& ofLevel = (*chosen)[level];
        const size_t before = ofLevel.size();
        LeafPoint point;
        while (ofLevel.size() < before + wanted && state.sequence.next(point))
        {
            const RankedCorner& corner = state.candidates[point.index];
            // finer levels may have chosen keypoints since the sequence was begun
            if (!first && isSuppressed(level, corner))
                state.passedOver.push_back(corner);
            else
                ofLevel.push_back(corner);
        }
        for (size_t i = before; i < ofLevel.size(); i++)
            grid.insert(position(level, ofLevel[i]), level);
        return int(ofLevel.size() - before);
    }

    int fill(int level, const std::vector<RankedCorner>& from, int wanted)
    {
        beginSequence(filling, level, from);
        LeafPoint point;
        int filled = 0;
        for (; filled < wanted && filling.next(point); filled++)
            (*chosen)[level].push_back(from[point.index]);
        return filled;
    }

    std::vector<SelectionLevel> levels;
    Size imageSize;
    CornerSource* source;
    std::vector<std::vector<RankedCorner>>* chosen;
    std::vector<LevelState> states;
    KeypointGrid grid;
    BalancedSequence filling;
    std::vector<RankedCorner> corners;  // of a level, as they come from the source
    std::vector<LeafPoint> points;
};

FeatureSelector::FeatureSelector() : impl(makePtr<Impl>())
{
}

void FeatureSelector::select(const std::vector<SelectionLevel>& levels, Size imageSize,
                             double octaveSuppression, CornerSource& source,
                             std::vector<std::vector<RankedCorner>>& chosen)
{
    CV_TRACE_FUNCTION();
    impl->begin(levels, imageSize, octaveSuppression, source, chosen);
    int wanted = impl->chooseQuotas();
    wanted = impl->chooseMore(wanted);
    wanted = impl->fillFromPassedOver(wanted);
    wanted = impl->fillFrom(SUPPRESSED_CORNERS, wanted);
    impl->fillFrom(CELL_REJECTS, wanted);
}

}  // namespace stages
}  // namespace aqorb
}  // namespace cv
