// This file is part of the aqorb project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.

#ifndef AQORB_BENCHMARK_PROFILE_HPP
#define AQORB_BENCHMARK_PROFILE_HPP

#include "trace.hpp"

//! The stages of detectAndCompute, in the pipeline's order.
enum Stage
{
    THRESHOLD,
    PYRAMID,
    FAST,
    EMPTY_CELLS,
    SUPPRESSION,
    HARRIS,
    QUADTREE,
    SELECTION,
    ORIENTATION,
    POSITION,
    BLUR,
    DESCRIPTOR,
    REST,
    STAGE_COUNT
};

const char* nameOf(Stage stage);

//! Where the time of a frame goes, by one thread, in ns.
struct Profile
{
    double total;
    double stages[STAGE_COUNT];
    std::vector<std::vector<double>> levels;    //!< time by stage of each level that has work of its own
    double serial;                              //!< outside of parallel_for_
    std::vector<std::vector<double>> parallel;  //!< time by task of each parallel_for_
};

//! The profile of a call of detectAndCompute.
Profile profileOf(const TraceRegion& frame);

//! Number by number the median of profiles of the same image; the total is the sum of the stages.
Profile medianOf(const std::vector<Profile>& profiles);

/** What threads may at most gain: total over the time that remains if each parallel_for_ took no longer than
 its longest task and its share of all tasks demand. 0 threads: as many as there are tasks. */
double boundOnSpeedup(const Profile& profile, int threads);

//! Names of functions and blocks that mark stages but are nowhere among these regions.
std::vector<std::string> absentStages(const std::vector<TraceRegion>& regions);

#endif
