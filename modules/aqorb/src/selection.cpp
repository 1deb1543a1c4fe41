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
    KeypointGrid(Size imageSize, double largestRadius)
    {
        const double MIN_SIDE = 8;  // smaller buckets cost more to clear than they save
        const double longest = std::max(imageSize.width, imageSize.height) + 1.;
        side = std::min(std::max(largestRadius, MIN_SIDE), std::max(longest, MIN_SIDE));
        columns = int(imageSize.width / side) + 1;
        rows = int(imageSize.height / side) + 1;
        heads.assign(size_t(columns) * rows, -1);
    }
    void insert(Point2d p, int level)
    {
        int& head = heads[size_t(row(p.y)) * columns + column(p.x)];
        const Entry entry = {p, level, head};
        head = int(entries.size());
        entries.push_back(entry);
    }
    // Whether a keypoint of another level is strictly nearer than radius (at most largestRadius).
    bool isNear(Point2d p, double radius, int exceptLevel) const
    {
        const double squaredRadius = radius * radius;
        for (int r = row(p.y - side); r <= row(p.y + side); r++)
        {
            for (int c = column(p.x - side); c <= column(p.x + side); c++)
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
    int column(double x) const { return std::min(std::max(int(x / side), 0), columns - 1); }
    int row(double y) const { return std::min(std::max(int(y / side), 0), rows - 1); }

    double side;
    int columns, rows;
    std::vector<int> heads;
    std::vector<Entry> entries;
};

class Selector
{
public:
    Selector(const std::vector<SelectionLevel>& levels_, Size imageSize_, double octaveSuppression,
             CornerSource& source_, std::vector<std::vector<RankedCorner> >& chosen_)
        : levels(levels_),
          imageSize(imageSize_),
          source(source_),
          chosen(chosen_),
          states(levels.size()),
          grid(imageSize, largestRadius(levels_, octaveSuppression))
    {
        chosen.assign(levels.size(), std::vector<RankedCorner>());
        for (size_t i = 0; i < levels.size(); i++)
            states[i].radius = octaveSuppression * levels[i].scale;
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
        std::vector<RankedCorner> corners;
        for (int level = 0; level < int(levels.size()) && wanted > 0; level++)
        {
            source.corners(level, set, corners);
            wanted -= fill(level, corners, wanted);
        }
        return wanted;
    }

private:
    struct LevelState
    {
        LevelState() : begun(false), radius(0) {}
        bool begun;
        double radius;  // of octave suppression, in pixels of the input image
        std::vector<RankedCorner> corners;  // those that the sequence gives the indices of
        BalancedSequence sequence;
        std::vector<RankedCorner> passedOver;
    };

    static double largestRadius(const std::vector<SelectionLevel>& levels, double octaveSuppression)
    {
        double largest = 0;
        for (size_t i = 0; i < levels.size(); i++)
            largest = std::max(largest, octaveSuppression * levels[i].scale);
        return largest;
    }

    // By pixel centres, exactly; coarse positions must not be shifted against fine ones.
    Point2d position(int level, const RankedCorner& corner) const
    {
        const Size size = levels[level].size;
        return Point2d((corner.x + 0.5) * imageSize.width / size.width - 0.5,
                       (corner.y + 0.5) * imageSize.height / size.height - 0.5);
    }

    bool isSuppressed(int level, const RankedCorner& corner) const
    {
        const double radius = states[level].radius;
        return radius > 0 && grid.isNear(position(level, corner), radius, level);
    }

    BalancedSequence sequenceOf(int level, const std::vector<RankedCorner>& corners) const
    {
        const SelectionLevel& l = levels[level];
        const int64 leaves = int64(1) << l.depth;
        std::vector<LeafPoint> points(corners.size());
        for (size_t i = 0; i < corners.size(); i++)
        {
            const RankedCorner& c = corners[i];
            const LeafPoint point = {leafCode(unsigned((c.x - l.root.x) * leaves / l.root.width),
                                              unsigned((c.y - l.root.y) * leaves / l.root.height)),
                                     c.response, float(c.x), float(c.y), int(i)};
            points[i] = point;
        }
        return BalancedSequence(points, l.depth);
    }

    void begin(int level)
    {
        LevelState& state = states[level];
        std::vector<RankedCorner> corners;
        source.corners(level, KEPT_CORNERS, corners);
        for (size_t i = 0; i < corners.size(); i++)
            (isSuppressed(level, corners[i]) ? state.passedOver : state.corners).push_back(corners[i]);
        state.sequence = sequenceOf(level, state.corners);
        state.begun = true;
    }

    int choose(int level, int wanted)
    {
        LevelState& state = states[level];
        const bool first = !state.begun;
        if (first)
            begin(level);
        const size_t before = chosen[level].size();
        LeafPoint point;
        while (chosen[level].size() < before + wanted && state.sequence.next(point))
        {
            const RankedCorner& corner = state.corners[point.index];
            // finer levels may have chosen keypoints since the sequence was begun
            if (!first && isSuppressed(level, corner))
                state.passedOver.push_back(corner);
            else
                chosen[level].push_back(corner);
        }
        for (size_t i = before; i < chosen[level].size(); i++)
            grid.insert(position(level, chosen[level][i]), level);
        return int(chosen[level].size() - before);
    }

    int fill(int level, const std::vector<RankedCorner>& corners, int wanted)
    {
        BalancedSequence sequence = sequenceOf(level, corners);
        LeafPoint point;
        int filled = 0;
        for (; filled < wanted && sequence.next(point); filled++)
            chosen[level].push_back(corners[point.index]);
        return filled;
    }

    const std::vector<SelectionLevel>& levels;
    const Size imageSize;
    CornerSource& source;
    std::vector<std::vector<RankedCorner> >& chosen;
    std::vector<LevelState> states;
    KeypointGrid grid;
};

}  // namespace

void selectFeatures(const std::vector<SelectionLevel>& levels, Size imageSize, double octaveSuppression,
                    CornerSource& source, std::vector<std::vector<RankedCorner> >& chosen)
{
    CV_TRACE_FUNCTION();
    Selector selector(levels, imageSize, octaveSuppression, source, chosen);
    int wanted = selector.chooseQuotas();
    wanted = selector.chooseMore(wanted);
    wanted = selector.fillFromPassedOver(wanted);
    wanted = selector.fillFrom(SUPPRESSED_CORNERS, wanted);
    selector.fillFrom(CELL_REJECTS, wanted);
}

}  // namespace stages
}  // namespace aqorb
}  // namespace cv
