// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#ifndef AQORB_PROFILE_PROFILE_HPP
#define AQORB_PROFILE_PROFILE_HPP

#include "trace.hpp"

//! The stages of detectAndCompute, in the pipeline's order.
enum Stage
{
    THRESHOLD,
    PYRAMID,
    FAST,
    HARRIS,
    RANKING,
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
};

//! The profile of a call of detectAndCompute.
Profile profileOf(const TraceRegion& frame);

//! Names of functions and blocks that mark stages but are nowhere among these regions.
std::vector<std::string> absentStages(const std::vector<TraceRegion>& regions);

#endif
