// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#ifndef OPENCV_AQORB_TYPES_HPP
#define OPENCV_AQORB_TYPES_HPP

#include "common/images.hpp"
#include "common/memory.hpp"

#include <opencv2/core.hpp>

#include <vector>

// Types that several stages share. The header of a stage declares the stage and the structs of its kernel, so a change
// in one stage does not recompile the others.

namespace cv
{
namespace aqorb
{

//! Level of the pyramid. Outside its border its pixels continue by reflection (BORDER_REFLECT_101).
struct Level
{
    Mat image;             //!< CV_8UC1
    Mat mask;              //!< CV_8UC1 of the same size, not 0 at usable pixels; empty: all are usable
    float scale = 1;       //!< size of a pixel of this level in pixels of the input image
    bool isInput = false;  //!< whether the level is the input image itself
};

const int FAST_RADIUS = 3;  //!< radius of FAST's circle of pixels

//! FAST thresholds of an image: `ini` everywhere, `min` in cells without a corner at `ini`.
struct Thresholds
{
    int ini, min;
};

//! FAST corner: a pixel of a level and its score, the highest threshold at which it is a corner.
struct Corner
{
    enum
    {
        ROW_BITS = 22,
        SCORE_BITS = 10
    };
    int x;
    int y : ROW_BITS, score : SCORE_BITS;  // 8 bytes a corner: a level has thousands
};
static_assert(MAX_LEVEL_SIDE < 1 << (Corner::ROW_BITS - 1), "Corner::y must hold each row of a level");

//! Corner with its response: Harris response or FAST score.
struct CornerResponse
{
    int x, y;
    float response;
};

//! Orders corners by row, then by column. A type, because std::sort does not inline functions.
struct InRasterOrder
{
    template <typename C> bool operator()(const C& a, const C& b) const
    {
        return a.y != b.y ? a.y < b.y : a.x < b.x;
    }
};

//! Pixel of a level and direction of a feature.
struct FeaturePoint
{
    int x, y;
    float angle;  //!< degrees
};

//! Features of a level.
struct FeatureList
{
    std::vector<FeaturePoint> points;  //!< in raster order
    std::vector<KeyPoint> keypoints;   //!< one for each point
    std::vector<uchar> descriptors;    //!< ORB::kBytes for each point; empty without descriptors
    std::vector<uint64> outputKeys;    //!< one for each point; ascending keys order the output
};

}  // namespace aqorb
}  // namespace cv

#endif
