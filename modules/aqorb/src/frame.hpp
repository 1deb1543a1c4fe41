// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#ifndef OPENCV_AQORB_FRAME_HPP
#define OPENCV_AQORB_FRAME_HPP

#include "parameters.hpp"
#include "tables.hpp"
#include "tasks.hpp"
#include "workspace.hpp"

namespace cv
{
namespace aqorb
{

/** Finds or describes the features of the image with which the levels were begun. The work is divided into tasks:

 | task | of | when |
 |---|---|---|
 | measure | the image | at once; it finds the thresholds |
 | make | a level | when the level before is made |
 | search | a band of a level | when the thresholds are known and the level is made; with a mask, when all levels are |
 | order | a level | when its bands are searched |
 | select | a level | when it is in order and features of the next coarser level are selected |
 | describe | some features of a level | when they are selected, or given and the level is made |

 Coarse levels come first, so that their features are described while finer levels are still searched. */
class Frame : private TaskRunner
{
public:
    Frame(const Parameters& parameters, const Tables& tables, Workspace& workspace);
    //! Forgets the tasks that are left, and the levels.
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

private:
    enum Kind  // in the order of their priority; with one thread DESCRIBE comes first
    {
        MEASURE,
        MAKE,
        SELECT,
        ORDER,
        SEARCH,
        DESCRIBE
    };
    enum Choice  // when the features of a list were chosen
    {
        BY_QUOTA,
        FILLED
    };
    //! @param part the band that is to be searched, or the list of features of which a range is to be described
    void put(Kind kind, int level, int part = 0, const Range& range = Range());
    void prepareWork(int count);
    void run();
    void run(const Task& task, int worker) CV_OVERRIDE;

    void plan();
    void measure();
    void make(int level);
    void completeMasks();
    void searchWhenReady(int level);
    void search(int level, int band, WorkerScratch& scratch);
    void order(int level, WorkerScratch& scratch);
    void selectWhenReady(int level);
    void select(int level, WorkerScratch& scratch);
    void take(int level, WorkerScratch& scratch);
    void fillUp(WorkerScratch& scratch);
    void collect(int level, Choice choice, WorkerScratch& scratch);
    void putRanges(int level, Choice choice);
    void describe(const Task& task, WorkerScratch& scratch);
    FeatureList& listOf(int level, int choice);
    DescriptionRules rulesOf(int level) const;

    const Parameters& parameters;
    const Tables& tables;
    Workspace& workspace;
    Levels& levels;
    std::deque<LevelWork>& work;
    const int threads;
    const bool isRanked;
    int levelCount = 0;
    bool areGiven = false, withDescriptors = true;
};

}  // namespace aqorb
}  // namespace cv

#endif
