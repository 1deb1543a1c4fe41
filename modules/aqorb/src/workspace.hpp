// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#ifndef OPENCV_AQORB_WORKSPACE_HPP
#define OPENCV_AQORB_WORKSPACE_HPP

#include "blur.hpp"
#include "detection.hpp"
#include "pyramid.hpp"
#include "selection.hpp"
#include "types.hpp"

namespace cv
{
namespace aqorb
{

//! What an image needs for one level of its pyramid.
struct LevelWork
{
    LevelWork() : first(0) {}

    stages::Level level;
    Ptr<stages::ResizeTables> resizing;  //!< to make the level
    stages::SelectionLevel selection;    //!< what the level is to contribute
    stages::LevelDetection detection;
    std::vector<stages::RankedCorner> chosen;  //!< the corners that become features, in raster order
    std::vector<stages::FeaturePoint> points;  //!< where the features of the level are described
    size_t first;                              //!< index of the level's first feature among all features
};

//! A band of a level whose corners are found independently.
struct LevelBand
{
    int level, band;
};

//! Features of a level that are described together, as one task.
struct FeatureRange
{
    int level;
    size_t begin, end;  //!< among the features of the level
};

//! What a call needs beside its outputs.
struct Workspace
{
    Workspace() : levelCount(0) {}

    stages::Level input;            //!< the image itself, of the caller
    std::vector<LevelWork> levels;  //!< it never shrinks, so that levels keep their memory
    int levelCount;                 //!< levels of this image
    std::vector<Size> regions;      //!< of the levels: where they may have keypoints
    std::vector<int> areaQuotas;    //!< of the levels, for RANKED_SELECTION
    std::vector<LevelBand> bands;   //!< those of the input image first
    stages::FeatureSelector selector;
    std::vector<stages::RankedCorner> corners;  //!< to offer to selection
    std::vector<FeatureRange> ranges;
    std::vector<KeyPoint> keypoints;
    std::vector<uchar> descriptors;  //!< where they are not computed in place
    std::vector<int> order;          //!< of the output: indices of keypoints

    //! Prepares the levels of the input's pyramid: nlevels, or fewer if a side would be shorter than minSide.
    void layOutLevels(int nlevels, int firstLevel, double scaleFactor, int minSide);
    //! Makes the levels from the input.
    void fillLevels(int firstLevel);
    //! Divides the levels into bands. A level without a quota is not searched unless selection asks for its corners.
    //! Returns the number of bands of the input image, which come first.
    size_t layOutBands();
    //! Divides the features into ranges of about equal size, so that no thread waits long for another one.
    void layOutRanges();
    //! Orders the keypoints of each level by response.
    void orderByResponse();
    //! Releases the images and masks that are the caller's, and the masks of the levels.
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

//! Work space that the task that describes a range of features needs only while it runs.
struct DescriptionScratch
{
    stages::BlurRegion blurRegion;
    stages::BlurScratch blur;
    std::vector<ushort> blurred;
};

}  // namespace aqorb
}  // namespace cv

#endif
