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

// What a call needs beside its outputs; kept for the next call.
struct Workspace
{
    std::vector<stages::Level> pyramid;
    std::vector<stages::LevelCorners> corners;
    std::vector<std::vector<stages::RankedCorner>> ranked, chosen;
    stages::FeatureSelector selector;
    std::vector<Mat> blurred;
    std::vector<LevelFeatures> features;

    void resize(size_t levels)
    {
        corners.resize(std::max(levels, corners.size()));
        ranked.resize(std::max(levels, ranked.size()));
        blurred.resize(std::max(levels, blurred.size()));
        features.resize(std::max(levels, features.size()));
    }
};

// Lends work spaces, one to each call that is under way.
class WorkspacePool
{
public:
    class Lease
    {
    public:
        explicit Lease(WorkspacePool& pool_) : pool(pool_), workspace(pool.take()) {}
        ~Lease()
        {
            // The input image is the caller's.
            for (size_t i = 0; i < workspace->pyramid.size(); i++)
            {
                stages::Level& level = workspace->pyramid[i];
                level.mask.release();
                if (level.isInput)
                    level.image.release();
            }
            pool.give(workspace);
        }
        Workspace& operator*() const { return *workspace; }

    private:
        Lease(const Lease&);
        Lease& operator=(const Lease&);

        WorkspacePool& pool;
        Ptr<Workspace> workspace;
    };

private:
    Ptr<Workspace> take()
    {
        AutoLock lock(mutex);
        if (idle.empty())
            return makePtr<Workspace>();
        const Ptr<Workspace> workspace = idle.back();
        idle.pop_back();
        return workspace;
    }
    void give(const Ptr<Workspace>& workspace)
    {
        AutoLock lock(mutex);
        idle.push_back(workspace);
    }

    Mutex mutex;
    std::vector<Ptr<Workspace>> idle;
};

}  // namespace aqorb
}  // namespace cv

#endif
