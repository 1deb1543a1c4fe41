// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "profile.hpp"

#include <opencv2/core.hpp>

#include <algorithm>

namespace
{

const struct
{
    const char* region;
    Stage stage;
} MARKS[] = {{"varianceOverMean", THRESHOLD},   {"fillLevel", PYRAMID},      {"BandSearch::find", FAST},
             {"harrisResponses", HARRIS},       {"orderByRank", RANKING},    {"select", SELECTION},
             {"orientations", ORIENTATION},     {"findKeypoints", POSITION}, {"approximateBlur", BLUR},
             {"computeDescriptors", DESCRIPTOR}};

//! The stage of a region inside one of another stage. Whatever selection calls is selection.
Stage stageOf(const TraceRegion& region, Stage outer)
{
    for (const auto& mark : MARKS)
    {
        if (outer != SELECTION && region.is(mark.region))
            return mark.stage;
    }
    return outer;
}

class Profiler
{
public:
    Profiler() : profile() {}

    void add(const TraceRegion& region, Stage outer)
    {
        const Stage stage = stageOf(region, outer);
        profile.stages[stage] += region.selfDuration();
        for (const TraceRegion& child : region.children)
            add(child, stage);
    }

    Profile profile;
};

void enter(const std::vector<TraceRegion>& regions, std::vector<std::string>& absent)
{
    for (const TraceRegion& region : regions)
    {
        absent.erase(std::remove_if(absent.begin(), absent.end(),
                                    [&](const std::string& name) { return region.is(name); }),
                     absent.end());
        enter(region.children, absent);
    }
}

}  // namespace

const char* nameOf(Stage stage)
{
    static const char* const NAMES[] = {"threshold",   "pyramid",  "FAST, cells, suppression",
                                        "Harris",      "ranking",  "selection",
                                        "orientation", "position", "blur",
                                        "descriptor",  "rest"};
    return NAMES[stage];
}

Profile profileOf(const TraceRegion& frame)
{
    Profiler profiler;
    profiler.add(frame, REST);
    profiler.profile.total = frame.duration;
    return profiler.profile;
}

std::vector<std::string> absentStages(const std::vector<TraceRegion>& regions)
{
    std::vector<std::string> absent;
    for (const auto& mark : MARKS)
        absent.push_back(mark.region);
    enter(regions, absent);
    return absent;
}
