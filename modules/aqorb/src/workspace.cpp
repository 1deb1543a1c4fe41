// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "precomp.hpp"

#include "workspace.hpp"

namespace cv
{
namespace aqorb
{

using namespace stages;

void Workspace::layOutLevels(int nlevels, int firstLevel, double scaleFactor, int minSide)
{
    for (levelCount = 0; levelCount < nlevels; levelCount++)
    {
        if (size_t(levelCount) == levels.size())
            levels.push_back(LevelWork());
        LevelWork& work = levels[levelCount];
        if (!layOutLevel(input, levelCount, firstLevel, scaleFactor, minSide, work.level,
                         givesLevels ? 0 : &work.pixels))
            break;
    }
}

void Workspace::makeLevel(int index, int firstLevel)
{
    CV_TRACE_FUNCTION();
    LevelWork& work = levels[index];
    if (work.level.isInput)
        return;
    const Level& source = isMadeFromInput(index, firstLevel) ? input : levels[index - 1].level;
    fillLevel(source, work.level, work.resizing);
}

void Workspace::releaseImages()
{
    input = Level();
    for (size_t i = 0; i < levels.size(); i++)
        levels[i].level = Level();
    givesLevels = false;
}

}  // namespace aqorb
}  // namespace cv
