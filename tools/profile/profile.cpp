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
} MARKS[] = {{"varianceOverMean", THRESHOLD},   {"makeLevel", PYRAMID},      {"BandSearch::find", FAST},
             {"harrisResponses", HARRIS},       {"orderByRank", QUADTREE},   {"select", SELECTION},
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

bool isParallel(const TraceRegion& region)
{
    return region.is("parallel_for");
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
                                        "Harris",      "quadtree", "selection",
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

namespace
{

//! The tasks that one thread did in a parallel_for_, if they are those of a frame.
std::vector<const TraceRegion*> tasksOfFrame(const TraceRegion& region)
{
    std::vector<const TraceRegion*> tasks;
    for (const TraceRegion& body : region.children)
    {
        for (const TraceRegion& task : body.children)
            tasks.push_back(&task);
    }
    const bool isFrame =
        std::any_of(tasks.begin(), tasks.end(), [](const TraceRegion* task) { return task->is("make"); });
    return isFrame ? tasks : std::vector<const TraceRegion*>();
}

/** The longest chain of tasks of a frame that depend on each other; see modules/aqorb/src/frame.hpp. Levels are made
 from fine to coarse. Then one thread goes from coarse to fine, and completes a level before it begins the next one. What
 is described comes last, as far as there are several threads. */
double longestChain(const std::vector<const TraceRegion*>& tasks)
{
    double measured = 0, longestSearch = 0, ordered = 0, selected = 0, chain = 0;
    std::vector<double> made;  // by level
    for (const TraceRegion* task : tasks)
    {
        const double duration = task->duration;
        if (task->is("measure"))
            measured = duration;
        else if (task->is("make"))
            made.push_back(duration + (made.empty() ? 0 : made.back()));
        else if (task->is("search"))
            longestSearch = std::max(longestSearch, duration);
        else if (task->is("order"))
            ordered = longestSearch + duration;
        else if (task->is("select"))
        {
            if (made.empty())
                CV_Error(cv::Error::StsError, "The trace has more levels selected than made");
            selected = std::max(std::max(measured, made.back()) + ordered, selected) + duration;
            made.pop_back();
            longestSearch = ordered = 0;
            chain = std::max(chain, selected);
        }
        else if (task->is("describe") && task == tasks.back())  // of the finest level
            chain = std::max(chain, selected + duration);
    }
    return chain;
}

}  // namespace

double leastTime(const TraceRegion& region, int threads)
{
    double work = 0, longest = 0, sum = 0;  // of the children
    for (const TraceRegion& child : region.children)
    {
        const double least = leastTime(child, threads);
        work += child.duration;
        longest = std::max(longest, least);
        sum += least;
    }
    const std::vector<const TraceRegion*> tasks =
        isParallel(region) ? tasksOfFrame(region) : std::vector<const TraceRegion*>();
    if (!tasks.empty())
        longest = longestChain(tasks);
    if (isParallel(region))
        sum = threads > 0 ? std::max(longest, work / threads) : longest;
    return region.selfDuration() + sum;
}

double serialTime(const TraceRegion& region)
{
    double serial = region.selfDuration();
    for (const TraceRegion& child : region.children)
        serial += isParallel(region) ? 0 : serialTime(child);
    return serial;
}

std::vector<std::string> absentStages(const std::vector<TraceRegion>& regions)
{
    std::vector<std::string> absent;
    for (const auto& mark : MARKS)
        absent.push_back(mark.region);
    enter(regions, absent);
    return absent;
}
