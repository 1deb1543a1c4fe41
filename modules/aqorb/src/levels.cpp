// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "precomp.hpp"

#include "levels.hpp"

namespace cv
{
namespace aqorb
{

void Levels::reset(const Level& input, int firstLevel_, double scaleFactor_, bool giveAway_)
{
    release();
    inputLevel = input;
    firstLevel = firstLevel_;
    scaleFactor = scaleFactor_;
    giveAway = giveAway_;
}

// Throws for levels that are larger than the image and, all in all, larger than anybody means: a few wrong digits would
// otherwise ask for more memory than there is.
void Levels::checkEnlarged(double pixels) const
{
    const double MOST = 1 << 30;
    if (pixels > MOST)
        rejectMemory(pixels);
}

void Levels::rejectMemory(double pixels) const
{
    CV_Error_(Error::StsNoMem,
              ("scaleFactor and firstLevel must give levels for which there is memory, with at most 2^30 "
               "pixels in those larger than the image, got %g and %d, which give %.0f pixels for an image of "
               "%d x %d",
               scaleFactor, firstLevel, pixels, inputLevel.image.cols, inputLevel.image.rows));
}

int Levels::layOut(int count, int minSide)
{
    double pixels = 0, enlarged = 0;
    for (; laidOut < count; laidOut++)
    {
        const float scale = levelScale(laidOut, firstLevel, scaleFactor);
        const Size size = levelSize(inputLevel.image.size(), scale);
        if (std::min(size.width, size.height) < minSide)
            break;
        if (size_t(laidOut) == entries.size())
            entries.push_back(Entry());
        Entry& entry = entries[laidOut];
        Level& level = entry.level;
        level.isInput = laidOut == firstLevel;
        level.scale = scale;
        if (level.isInput)
        {
            level.image = inputLevel.image;
            level.mask = inputLevel.mask;
            continue;
        }
        pixels += double(size.width) * size.height;
        if (laidOut < firstLevel)
            checkEnlarged(enlarged += double(size.width) * size.height);
        try
        {
            allocate(size, entry);
        }
        catch (const std::exception&)
        {
            rejectMemory(pixels);
        }
    }
    return laidOut;
}

void Levels::allocate(Size size, Entry& entry) const
{
    const size_t rows = size_t(size.height);
    if (!inputLevel.mask.empty())
        growTo(entry.mask, size.width * rows);
    if (giveAway)
    {
        entry.level.image = Mat(size, CV_8UC1);
        return;
    }
    // Rows begin where cache lines do, so that vectors cross as few of them as possible.
    const size_t step = alignSize(size_t(size.width), CACHE_LINE);
    growTo(entry.pixels, step * rows);
    entry.level.image = Mat(size, CV_8UC1, entry.pixels.data(), step);
}

void Levels::make(int index)
{
    CV_TRACE_FUNCTION();
    Entry& entry = entries[index];
    if (entry.level.isInput)
        return;
    // As cv::ORB does, the first level that is smaller than the image is made of it, too, and so are all larger ones.
    const Level& source = index <= firstLevel + 1 ? inputLevel : entries[index - 1].level;
    fillLevel(source, entry.level, entry.resizing, entry.mask);
}

void Levels::release()
{
    inputLevel = Level();
    for (Entry& entry : entries)
        entry.level = Level();
    laidOut = 0;
}

}  // namespace aqorb
}  // namespace cv
