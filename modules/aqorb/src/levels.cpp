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

int Levels::layOut(int count, int minSide)
{
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
        // Rows begin where cache lines do, so that vectors cross as few of them as possible.
        const size_t step = alignSize(size_t(size.width), CACHE_LINE);
        if (!giveAway)
            growTo(entry.pixels, step * size.height);
        level.image = giveAway ? Mat(size, CV_8UC1) : Mat(size, CV_8UC1, entry.pixels.data(), step);
    }
    return laidOut;
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
