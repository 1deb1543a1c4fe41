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

// The features of a level.
struct LevelFeatures
{
    std::vector<KeyPoint> keypoints;
    std::vector<stages::DescriptorPoint> points;  // where they were found
};

// What a call needs beside its outputs.
struct Workspace
{
    std::vector<stages::Level> pyramid;
    std::vector<stages::LevelCorners> corners;
    std::vector<stages::BalancedSequence> sequences;
    std::vector<uchar> ready;  // whether the level's corners and sequence are
    std::vector<stages::SelectionLevel> selectionLevels;
    std::vector<std::vector<stages::RankedCorner>> chosen;
    stages::FeatureSelector selector;
    std::vector<LevelFeatures> features;

    void resize(size_t levels)
    {
        corners.resize(std::max(levels, corners.size()));
        sequences.resize(std::max(levels, sequences.size()));
        features.resize(std::max(levels, features.size()));
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

// What work on one level needs only as long as it lasts, so that levels one after the other share it.
struct LevelScratch
{
    stages::CornerScratch corners;
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
