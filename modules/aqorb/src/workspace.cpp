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
        if (!layOutLevel(input, levelCount, firstLevel, scaleFactor, minSide, levels[levelCount].level))
            break;
    }
    // Images of levels that this pyramid does not have are not kept.
    for (size_t i = size_t(levelCount); i < levels.size(); i++)
        levels[i].level = Level();
}

void Workspace::fillLevels(int firstLevel)
{
    CV_TRACE_FUNCTION();
    for (int i = 0; i < levelCount; i++)
    {
        if (levels[i].level.isInput)
            continue;
        const Level& source = isMadeFromInput(i, firstLevel) ? input : levels[i - 1].level;
        fillLevel(source, levels[i].level, levels[i].resizing);
    }
}

size_t Workspace::layOutBands()
{
    bands.clear();
    size_t ofInput = 0;
    for (int pass = 0; pass < 2; pass++)
    {
        const bool wantsInput = pass == 0;
        for (int i = 0; i < levelCount; i++)
        {
            if (levels[i].level.isInput != wantsInput || levels[i].selection.quota == 0)
                continue;
            const int count = levels[i].detection.layOutBands();
            for (int j = 0; j < count; j++)
            {
                const LevelBand band = {i, j};
                bands.push_back(band);
            }
        }
        if (wantsInput)
            ofInput = bands.size();
    }
    return ofInput;
}

void Workspace::layOutRanges()
{
    // More and smaller ranges would cost time, because neighbouring ranges both blur the rows between them.
    const size_t RANGES = 8, MIN_FEATURES = 64;
    const size_t most = std::max(keypoints.size() / RANGES, MIN_FEATURES);
    ranges.clear();
    for (int level = 0; level < levelCount; level++)
    {
        const size_t count = levels[level].points.size(), parts = (count + most - 1) / most;
        for (size_t i = 0; i < parts; i++)
        {
            const FeatureRange range = {level, count * i / parts, count * (i + 1) / parts};
            ranges.push_back(range);
        }
    }
}

void Workspace::orderByResponse()
{
    order.resize(keypoints.size());
    std::iota(order.begin(), order.end(), 0);
    const std::vector<KeyPoint>& unordered = keypoints;
    std::sort(order.begin(), order.end(),
              [&](int a, int b)
              {
                  const KeyPoint &first = unordered[a], &second = unordered[b];
                  if (first.octave != second.octave)
                      return first.octave < second.octave;
                  return first.response != second.response ? first.response > second.response : a < b;
              });
}

void Workspace::releaseImages()
{
    input = Level();
    for (size_t i = 0; i < levels.size(); i++)
    {
        levels[i].level.mask.release();
        if (levels[i].level.isInput)
            levels[i].level.image.release();
    }
}

}  // namespace aqorb
}  // namespace cv
