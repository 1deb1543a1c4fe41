// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// What an object keeps between calls: the tables of its parameters, and memory, which calls borrow.

#ifndef OPENCV_AQORB_WORKSPACE_HPP
#define OPENCV_AQORB_WORKSPACE_HPP

#include "corners.hpp"
#include "keypoints.hpp"
#include "pyramid.hpp"
#include "selection.hpp"

namespace cv
{
namespace aqorb
{

//! What follows from the parameters alone.
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

//! The large buffers of a call. They are kept for later calls.
struct Workspace
{
    std::vector<uchar> gray;  //!< the image, where the caller's has colours
    PyramidSpace pyramid;
    CornerSpace corners;
    std::vector<DescriptionScratch> descriptions;  //!< of each thread
};

//! The work spaces of an object. A call borrows one, so that several threads can use the object at once.
class Workspaces
{
public:
    class Loan
    {
    public:
        explicit Loan(Workspaces& lender_) : lender(lender_), lent(lender.take()) {}
        Loan(const Loan&) = delete;
        ~Loan() { lender.give(lent); }
        Workspace& operator*() const { return *lent; }

    private:
        Workspaces& lender;
        const Ptr<Workspace> lent;
    };
    //! Frees those that are not lent.
    void clear()
    {
        const AutoLock lock(mutex);
        idle.clear();
    }

private:
    Ptr<Workspace> take()
    {
        const AutoLock lock(mutex);
        idle.reserve(idle.size() + lentCount + 1);  // so that giving back cannot fail
        const Ptr<Workspace> taken = idle.empty() ? makePtr<Workspace>() : idle.back();
        if (!idle.empty())
            idle.pop_back();
        lentCount++;
        return taken;
    }
    // As many are kept as there are CPUs.
    void give(const Ptr<Workspace>& lent)
    {
        const AutoLock lock(mutex);
        lentCount--;
        if (idle.size() < size_t(std::max(getNumberOfCPUs(), 1)))
            idle.push_back(lent);
    }

    Mutex mutex;
    size_t lentCount = 0;
    std::vector<Ptr<Workspace>> idle;
};

}  // namespace aqorb
}  // namespace cv

#endif
