// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#ifndef AQORB_PROFILE_TRACE_HPP
#define AQORB_PROFILE_TRACE_HPP

#include <string>
#include <vector>

//! A region of OpenCV's trace: a function or a named block, entered once.
struct TraceRegion
{
    std::string name;  //!< of functions qualified, without types: cv::aqorb::stages::findCorners
    double duration;   //!< in ns, with the regions inside
    std::vector<TraceRegion> children;

    //! Whether the name is this one or ends with `::` and it.
    bool is(const std::string& suffix) const;
    //! The part of the duration that no child has.
    double selfDuration() const;
};

/** Reads what a process of one thread wrote under OPENCV_TRACE=1.
 @param location its OPENCV_TRACE_LOCATION
 @return the outermost regions, in order
 Throws cv::Exception where the trace is absent, not of one thread, or where OpenCV left regions out. */
std::vector<TraceRegion> readTrace(const std::string& location);

#endif
