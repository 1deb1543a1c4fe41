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
namespace stages
{

void Levels::reset(const Level& input, int firstLevel_, double scaleFactor_, bool giveAway_)
{
    image = input;
    firstLevel = firstLevel_;
    scaleFactor = scaleFactor_;
    giveAway = giveAway_;
    laidOut = 0;
}

int Levels::layOut(int count, int minSide)
{
    for (; laidOut < count; laidOut++)
    {
        if (size_t(laidOut) == entries.size())
            entries.push_back(Entry());
        Entry& entry = entries[laidOut];
        if (!layOutLevel(image, laidOut, firstLevel, scaleFactor, minSide, entry.level,
                         giveAway ? 0 : &entry.pixels))
            break;
    }
    return laidOut;
}

void Levels::make(int index)
{
    CV_TRACE_FUNCTION();
    Entry& entry = entries[index];
    if (entry.level.isInput)
        return;
    const Level& source = isMadeFromInput(index, firstLevel) ? image : entries[index - 1].level;
    fillLevel(source, entry.level, entry.resizing, &entry.mask);
}

void Levels::release()
{
    image = Level();
    for (Entry& entry : entries)
        entry.level = Level();
    laidOut = 0;
}

}  // namespace stages
}  // namespace aqorb
}  // namespace cv
