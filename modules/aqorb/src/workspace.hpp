// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#ifndef OPENCV_AQORB_WORKSPACE_HPP
#define OPENCV_AQORB_WORKSPACE_HPP

#include "description.hpp"
#include "detection.hpp"
#include "pyramid.hpp"
#include "selection.hpp"
#include "tasks.hpp"
#include "types.hpp"

#include <deque>

namespace cv
{
namespace aqorb
{

//! What an image needs for one level of its pyramid.
struct LevelWork
{
    LevelWork() : bandsLeft(0), inputsOfSearch(0), inputsOfSelection(0) {}

    stages::Level level;
    AlignedVector<uchar> pixels;         //!< of the level, if they do not become the caller's
    Ptr<stages::ResizeTables> resizing;  //!< to make the level
    stages::SelectionLevel selection;    //!< what the level is to contribute
    stages::LevelDetection detection;
    //! The features that were chosen by the level's quota, and those that were chosen to fill up.
    stages::FeatureBatch batches[2];
    int bandsLeft, inputsOfSearch, inputsOfSelection;  //!< what tasks still wait for
};

//! Work space of a thread that does tasks.
struct WorkerScratch
{
    stages::DetectionScratch detection;
    stages::DescriptionScratch description;
    std::vector<stages::RankedCorner> corners;
};

//! A keypoint that is given to be described.
struct GivenFeature
{
    stages::FeaturePoint point;
    int octave;
    unsigned index;  //!< of the keypoint
};

//! What a call needs beside its outputs. It is kept for later calls.
struct Workspace
{
    Workspace() : levelCount(0), givesLevels(false) {}

    stages::Level input;      //!< the image itself, of the caller
    std::vector<uchar> gray;  //!< the image, where the caller's has colours
    std::deque<LevelWork>
        levels;                 //!< it never shrinks, so that levels keep their memory, and never moves them
    int levelCount;             //!< levels of this image
    bool givesLevels;           //!< whether the levels become the caller's
    std::vector<Size> regions;  //!< of the levels: where they may have keypoints
    std::vector<int> areaQuotas;  //!< of the levels, for RANKED_SELECTION
    stages::KeptCount keptCount;
    stages::FeatureSelector selector;
    TaskQueue queue;
    std::vector<WorkerScratch> scratches;  //!< of the workers
    std::vector<int> maskColumns;          //!< work space of maskPositions
    // Work space of given keypoints.
    std::vector<KeyPoint> given;
    std::vector<GivenFeature> givenFeatures;
    // Work space of the output.
    std::vector<uint64> numbers;
    std::vector<unsigned> rasterOrder, places;
    SortScratch sorting;

    //! Prepares the levels of the input's pyramid: nlevels, or fewer if a side would be shorter than minSide.
    void layOutLevels(int nlevels, int firstLevel, double scaleFactor, int minSide);
    //! Makes a level from the level before or from the input.
    void makeLevel(int index, int firstLevel);
    //! Forgets the images and masks that are the caller's, and those that became the caller's.
    void releaseImages();
};

//! Gives a workspace its input until the end of the scope, even if an exception ends it.
class InputScope
{
public:
    InputScope(Workspace& workspace_, const stages::Level& input) : workspace(workspace_)
    {
        workspace.input = input;
    }
    ~InputScope() { workspace.releaseImages(); }

private:
    InputScope(const InputScope&);
    InputScope& operator=(const InputScope&);

    Workspace& workspace;
};

}  // namespace aqorb
}  // namespace cv

#endif
