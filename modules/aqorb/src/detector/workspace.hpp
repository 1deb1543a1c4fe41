// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// State that an object keeps between calls: tables of its parameters, and a pool of work spaces.

#ifndef OPENCV_AQORB_WORKSPACE_HPP
#define OPENCV_AQORB_WORKSPACE_HPP

#include "detector/corners.hpp"
#include "detector/keypoints.hpp"
#include "detector/pyramid.hpp"
#include "detector/selection.hpp"

namespace cv
{
namespace aqorb
{

//! Tables computed from the parameters.
struct Tables
{
    explicit Tables(const Parameters& parameters)
        : patch(circularPatch(parameters.patchSize)),
          strengthPatch(patchForStrength(parameters.patchSize)),
          tests(descriptorPattern(parameters.patchSize, parameters.WTA_K), parameters.WTA_K)
    {
    }

    OrientationPatch patch, strengthPatch;
    DescriptorTests tests;
};

//! Large buffers of a call, kept for later calls.
struct Workspace
{
    std::vector<uchar> gray;  //!< grey copy of a colour image
    PyramidSpace pyramid;
    CornerSpace corners;
    std::vector<DescriptionSpace> descriptions;  //!< one for each thread
};

//! Pool of an object's work spaces. Each call takes its own, so several threads can use the object at once.
class Workspaces
{
public:
    //! Takes a work space from the pool, and returns it at the end of the scope.
    class Handle
    {
    public:
        explicit Handle(Workspaces& pool_) : pool(pool_), workspace(pool.take()) {}
        Handle(const Handle&) = delete;
        ~Handle() { pool.give(workspace); }
        Workspace& operator*() const { return *workspace; }

    private:
        Workspaces& pool;
        const Ptr<Workspace> workspace;
    };
    //! Frees the idle work spaces.
    void clear()
    {
        const AutoLock lock(mutex);
        idle.clear();
    }

private:
    Ptr<Workspace> take()
    {
        const AutoLock lock(mutex);
        idle.reserve(idle.size() + inUse + 1);  // so that give() cannot fail
        const Ptr<Workspace> taken = idle.empty() ? makePtr<Workspace>() : idle.back();
        if (!idle.empty())
            idle.pop_back();
        inUse++;
        return taken;
    }
    // Keeps at most one idle work space for each CPU.
    void give(const Ptr<Workspace>& workspace)
    {
        const AutoLock lock(mutex);
        inUse--;
        if (idle.size() < size_t(std::max(getNumberOfCPUs(), 1)))
            idle.push_back(workspace);
    }

    Mutex mutex;
    size_t inUse = 0;
    std::vector<Ptr<Workspace>> idle;
};

}  // namespace aqorb
}  // namespace cv

#endif
