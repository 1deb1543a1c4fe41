// This file is part of the aqorb project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.

#ifndef OPENCV_AQORB_WORKSPACE_HPP
#define OPENCV_AQORB_WORKSPACE_HPP

#include "stages.hpp"

#include <opencv2/core/utility.hpp>

namespace cv
{
namespace aqorb
{

// A band of a level whose corners are found by themselves.
struct CornerBand
{
    int level;
    Rect rect;
    stages::CornerBlocks blocks;
    bool isRanked;
    std::vector<stages::Corner> corners;       // kept
    std::vector<stages::RankedCorner> ranked;  // the same
};

// Features of a level that are described by themselves.
struct Stripe
{
    int level;
    size_t begin, end;  // among the level's
};

// What a call needs beside its outputs.
struct Workspace
{
    std::vector<stages::Level> pyramid;
    stages::PyramidScratch resizing;
    std::vector<stages::SelectionLevel> selectionLevels;
    std::vector<CornerBand> bands;           // never fewer, to keep their memory
    std::vector<stages::ScorePlane> planes;  // by level, for its bands
    std::vector<stages::BalancedSequence> sequences;
    std::vector<uchar> ready;  // whether the level's corners and sequence are
    stages::FeatureSelector selector;
    std::vector<std::vector<stages::RankedCorner>> chosen;
    std::vector<size_t> rowStarts;                             // to sort them
    std::vector<stages::RankedCorner> sorted;                  // likewise
    std::vector<std::vector<stages::DescriptorPoint>> points;  // by level: where the features were found
    std::vector<Stripe> stripes;
    std::vector<size_t> firsts;  // of each level's features among all
    std::vector<KeyPoint> keypoints;

    void resize(size_t levels)
    {
        planes.resize(std::max(levels, planes.size()));
        sequences.resize(std::max(levels, sequences.size()));
        points.resize(std::max(levels, points.size()));
    }
    // Before it is put away: the input image is the caller's.
    void rest()
    {
        for (size_t i = 0; i < pyramid.size(); i++)
        {
            pyramid[i].mask.release();
            if (pyramid[i].isInput)
                pyramid[i].image.release();
        }
    }
};

// What a task needs only as long as it lasts, so that tasks one after the other share it.
struct TaskScratch
{
    stages::FastScanner scanner;
    std::vector<stages::RankedCorner> ranked;
    stages::LeafScratch leaves;
    std::vector<stages::LeafPoint> points;
    stages::BlurRegion blurRegion;
    stages::BlurScratch blur;
    std::vector<ushort> blurred;

    void rest() {}
};

// Lends objects, each to one user at a time, and keeps them with their memory.
template <typename T> class Pool
{
public:
    Pool() : made(0) {}

    class Lease
    {
    public:
        explicit Lease(Pool& pool_) : pool(pool_), lent(pool.take()) {}
        ~Lease()
        {
            lent->rest();
            pool.give(lent);
        }
        T& operator*() const { return *lent; }

    private:
        Lease(const Lease&);
        Lease& operator=(const Lease&);

        Pool& pool;
        Ptr<T> lent;
    };

private:
    Ptr<T> take()
    {
        AutoLock lock(mutex);
        if (idle.empty())
        {
            idle.reserve(++made);  // a destructor gives it back: there must be room
            return makePtr<T>();
        }
        const Ptr<T> lent = idle.back();
        idle.pop_back();
        return lent;
    }
    void give(const Ptr<T>& lent)
    {
        AutoLock lock(mutex);
        idle.push_back(lent);
    }

    Mutex mutex;
    size_t made;
    std::vector<Ptr<T>> idle;
};

}  // namespace aqorb
}  // namespace cv

#endif
