// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#ifndef OPENCV_AQORB_WORKSPACE_HPP
#define OPENCV_AQORB_WORKSPACE_HPP

#include "description.hpp"
#include "detection.hpp"
#include "given.hpp"
#include "levels.hpp"
#include "output.hpp"
#include "selection.hpp"
#include "tasks.hpp"

namespace cv
{
namespace aqorb
{

//! What a frame needs for one level.
struct LevelWork
{
    LevelPlan plan;
    LevelDetection detection;
    LevelFeatures features;
    int bandsLeft = 0, inputsOfSearch = 0, inputsOfSelection = 0;  //!< what tasks still wait for
};

//! Work space of a thread that does tasks.
struct WorkerScratch
{
    DetectionScratch detection;
    DescriptionScratch description;
    std::vector<CornerResponse> corners;
};

//! What a call needs beside its outputs. It is kept for later calls.
struct Workspace
{
    std::vector<uchar> gray;  //!< the image, where the caller's has colours
    Levels levels;
    std::deque<LevelWork> work;  //!< of the levels; it never shrinks and never moves them
    std::vector<LevelRegion> regions;
    std::vector<int> rankedQuotas;  //!< of the levels, for RANKED_SELECTION
    FeatureSelector selector;
    TaskQueue queue;
    std::vector<WorkerScratch> workers;
    std::vector<int> maskColumns;  //!< work space of maskPositions
    GivenScratch given;
    OutputScratch output;
};

}  // namespace aqorb
}  // namespace cv

#endif
