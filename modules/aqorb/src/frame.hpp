// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#ifndef OPENCV_AQORB_FRAME_HPP
#define OPENCV_AQORB_FRAME_HPP

#include "parameters.hpp"
#include "tasks.hpp"
#include "workspace.hpp"

namespace cv
{
namespace aqorb
{

//! What follows from the parameters alone.
struct Tables
{
    explicit Tables(const Parameters& parameters);

    stages::OrientationPatch patch;
    stages::OrientationPatch strengthPatch;  //!< the same with fewer rows
    stages::DescriptorTests tests;
    std::vector<int> quotas;  //!< by level, of BALANCED_SELECTION
};

/** Finds or describes the features of the input of a workspace. The work is divided into tasks:

 | task | of | when |
 |---|---|---|
 | measure | the image | at once: the thresholds |
 | make | a level | when the level before is made |
 | search | a band of a level | when the level is made and the thresholds are known |
 | order | a level | when its bands are searched |
 | select | a level | when it is ordered and features of the next coarser level are selected |
 | describe | some features of a level | when they are selected |

 Coarse levels come first, so that their features are described while finer levels are still searched. */
class Frame : private TaskRunner
{
public:
    Frame(const Parameters& parameters, const Tables& tables, Workspace& workspace);
    ~Frame();
    //! Finds features and, if they are wanted, their descriptors.
    void detect(bool withDescriptors);
    //! Takes given keypoints as cv::ORB::compute does, and describes them.
    void describeGiven(const std::vector<KeyPoint>& given);
    //! The number of features.
    size_t count() const;
    //! Gives the features in the order of the output: by level, in a level by response, or as they were given, or in
    //! raster order.
    //! @param descriptors of count() rows; an empty one if they are not wanted
    void output(std::vector<KeyPoint>& keypoints, Mat& descriptors) const;

protected:
    // In the order of their priority, see put. Protected, because a tool records the tasks.
    enum Kind
    {
        MEASURE,
        MAKE,
        SELECT,
        ORDER,
        SEARCH,
        DESCRIBE
    };
    void run(const Task& task, int worker) CV_OVERRIDE;

private:
    void put(Kind kind, int level, int part = 0);
    void runTasks();

    void planLevels();
    void measure();
    void make(int level);
    void completeMasks();
    void searchWhenReady(int level);
    void search(int level, int band, WorkerScratch& scratch);
    void order(int level, WorkerScratch& scratch);
    void selectWhenReady(int level);
    void select(int level, WorkerScratch& scratch);
    void fillUp(WorkerScratch& scratch);
    void collect(int level, int batch, WorkerScratch& scratch);
    void putRanges(int level, int batch);
    void describe(int level, int part, WorkerScratch& scratch);
    stages::DescriptionRules rulesOf(int level) const;
    size_t featuresOfRange() const;

    const Parameters& parameters;
    const Tables& tables;
    Workspace& workspace;
    std::deque<LevelWork>& levels;
    const int threads;
    bool areGiven, withDescriptors;
};

}  // namespace aqorb
}  // namespace cv

#endif
