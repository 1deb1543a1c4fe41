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
    // Whether a keypoint of another level, or of a coarser one, is strictly nearer than radius.
    bool isNear(Point2d p, double radius, int level, bool onlyCoarser) const
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
                    const bool counts = onlyCoarser ? entries[i].level > level : entries[i].level != level;
                    if (counts && d.x * d.x + d.y * d.y < squaredRadius)
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
    void begin(const std::vector<SelectionLevel>& levels_, Size imageSize_, double octaveSuppression_,
               CornerSource& source_, std::vector<std::vector<RankedCorner>>& chosen_)
    {
        levels = &levels_;
        imageSize = imageSize_;
        octaveSuppression = octaveSuppression_;
        source = &source_;
        chosen = &chosen_;
        // Never fewer, to keep their memory.
        chosen->resize(std::max(chosen->size(), levels->size()));
        for (size_t i = 0; i < chosen->size(); i++)
            (*chosen)[i].clear();
        begun.assign(levels->size(), uchar(0));
        grid.clear(imageSize);
    }

    // Coarse to fine: unmet quota goes to the next finer level. Returns what remains after the finest.
    int chooseQuotas()
    {
        int wanted = 0;
        for (int level = int(levels->size()) - 1; level >= 0; level--)
        {
            wanted += (*levels)[level].quota;
            if (wanted > 0)
                wanted -= choose(level, wanted);
        }
        return wanted;
    }
    // Fine to coarse: each level goes on in its sequence.
    int chooseMore(int wanted)
    {
        for (int level = 0; level < int(levels->size()) && wanted > 0; level++)
            wanted -= choose(level, wanted);
        return wanted;
    }
    // Fine to coarse, from the corners that octave suppression passed over: as nothing else is left of the
    // sequences, all that are not chosen.
    int fillFromPassedOver(int wanted)
    {
        for (int level = 0; level < int(levels->size()) && wanted > 0; level++)
        {
            std::vector<RankedCorner> taken = (*chosen)[level];
            std::sort(taken.begin(), taken.end(), InRasterOrder());
            source->corners(level, KEPT_CORNERS, corners);
            corners.erase(std::remove_if(corners.begin(), corners.end(),
                                         [&](const RankedCorner& c) {
                                             return std::binary_search(taken.begin(), taken.end(), c,
                                                                       InRasterOrder());
                                         }),
                          corners.end());
            wanted -= fill(level, wanted);
        }
        return wanted;
    }
    // Fine to coarse, from corners that other rules passed over.
    int fillFrom(CornerSet set, int wanted)
    {
        for (int level = 0; level < int(levels->size()) && wanted > 0; level++)
        {
            source->corners(level, set, corners);
            wanted -= fill(level, wanted);
        }
        return wanted;
    }

private:
    // Octave suppression.
    class NotSuppressed : public PointFilter
    {
    public:
        NotSuppressed(const Impl& impl_, int level_, bool byCoarser_)
            : impl(impl_), level(level_), byCoarser(byCoarser_)
        {
        }
        bool accepts(const LeafPoint& point) const CV_OVERRIDE
        {
            const double radius = impl.octaveSuppression * (*impl.levels)[level].scale;
            return !(radius > 0 &&
                     impl.grid.isNear(impl.position(level, point.x, point.y), radius, level, byCoarser));
        }

    private:
        const Impl& impl;
        int level;
        bool byCoarser;  // only, as keypoints of finer levels came later
    };

    // By pixel centres, exactly: positions of coarse levels must not be shifted against those of fine ones.
    static double position(int pixel, int levelLength, int imageLength)
    {
        return (pixel + 0.5) * imageLength / levelLength - 0.5;
    }
    Point2d position(int level, float x, float y) const
    {
        const Size size = (*levels)[level].size;
        return Point2d(position(int(x), size.width, imageSize.width),
                       position(int(y), size.height, imageSize.height));
    }

    int choose(int level, int wanted)
    {
        const bool again = begun[level] != 0;
        const NotSuppressed filter(*this, level, again), now(*this, level, false);
        begun[level] = 1;
        BalancedSequence& sequence = source->sequence(level);
        std::vector<RankedCorner>& ofLevel = (*chosen)[level];
        const size_t before = ofLevel.size();
        LeafPoint point;
        while (ofLevel.size() < before + wanted && sequence.next(point, &filter))
        {
            // Finer levels may have chosen keypoints since the sequence was begun.
            if (!again || now.accepts(point))
                ofLevel.push_back(cornerAt(point));
        }
        for (size_t i = before; i < ofLevel.size(); i++)
            grid.insert(position(level, float(ofLevel[i].x), float(ofLevel[i].y)), level);
        return int(ofLevel.size() - before);
    }

    int fill(int level, int wanted)
    {
        leafPoints(corners, (*levels)[level].root, (*levels)[level].depth, scratch, points);
        filling.begin(points, (*levels)[level].depth);
        LeafPoint point;
        int filled = 0;
        for (; filled < wanted && filling.next(point); filled++)
            (*chosen)[level].push_back(cornerAt(point));
        return filled;
    }

    static RankedCorner cornerAt(const LeafPoint& point)
    {
        const RankedCorner corner = {int(point.x), int(point.y), point.response};
        return corner;
    }

    const std::vector<SelectionLevel>* levels;
    Size imageSize;
    double octaveSuppression;
    CornerSource* source;
    std::vector<std::vector<RankedCorner>>* chosen;
    std::vector<uchar> begun;  // by level
    KeypointGrid grid;
    BalancedSequence filling;
    std::vector<RankedCorner> corners;  // to fill from
    LeafScratch scratch;
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
