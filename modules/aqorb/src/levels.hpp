// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#ifndef OPENCV_AQORB_LEVELS_HPP
#define OPENCV_AQORB_LEVELS_HPP

#include "aligned.hpp"
#include "pyramid.hpp"
#include "types.hpp"

#include <deque>

namespace cv
{
namespace aqorb
{

/** The levels of cv::ORB's pyramid of an image, with the memory and the tables by which they are made. It is kept for later
 images. Level `firstLevel` is the image itself, which is not copied. */
class Levels
{
public:
    /** Starts with an image.
     @param input the image and its mask, of the caller
     @param giveAway whether the levels become the caller's: then they get memory of their own */
    void reset(const Level& input, int firstLevel, double scaleFactor, bool giveAway);
    //! Prepares so many levels, or fewer if a side would be shorter than minSide. Levels that were made stay.
    //! @return how many there are
    int layOut(int count, int minSide);
    //! Makes the pixels and the mask of a level from the level before or from the input.
    void make(int index);
    //! Forgets the images and masks that are the caller's, and those that became the caller's.
    void release();

    const Level& input() const { return inputLevel; }
    int size() const { return laidOut; }
    const Level& operator[](int index) const { return entries[index].level; }
    Level& operator[](int index) { return entries[index].level; }

private:
    struct Entry
    {
        Level level;
        AlignedVector<uchar> pixels;  // of the level, if they do not become the caller's
        std::vector<uchar> mask;      // its memory, if the image has a mask
        Ptr<ResizeTables> resizing;   // to make the level
    };
    void allocate(Size size, Entry& entry) const;
    void checkEnlarged(double pixels) const;
    void rejectMemory(double pixels) const;

    Level inputLevel;
    int firstLevel = 0;
    double scaleFactor = 1;
    bool giveAway = false;
    int laidOut = 0;
    std::deque<Entry> entries;  // it never shrinks, so that levels keep their memory, and never moves them
};

}  // namespace aqorb
}  // namespace cv

#endif
