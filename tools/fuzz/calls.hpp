// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#ifndef OPENCV_AQORB_FUZZ_CALLS_HPP
#define OPENCV_AQORB_FUZZ_CALLS_HPP

#include <cstddef>
#include <cstdint>
#include <string>

namespace fuzz
{

//! The result of all calls for one input, from good to bad.
enum Outcome
{
    FINE,             //!< every call did what it should
    NAMED_EXCEPTION,  //!< the same, and at least one call rejected a bad argument by an exception that names it
    ACCEPTED,         //!< a bad argument was accepted
    BAD_EXCEPTION,    //!< an exception for good arguments, of another kind, or that names no argument
    BAD_OUTPUT        //!< too many keypoints, off the image or the mask, not finite, without descriptor, ...
};

struct Report
{
    Outcome outcome = FINE;
    std::string problem;  //!< in words, of the last three outcomes
};

/** Makes a detector and calls it in the ways that the bytes say: creates it, sets parameters, reads a
 storage, detects, computes. The report is of the worst that happens; after the first problem of
 AdaptiveQuadtreeORB there are no more calls.
 @param ofOrb calls cv::ORB, and leaves out what only AdaptiveQuadtreeORB has; both get the same
 arguments from the same bytes */
Report callDetector(const uint8_t* bytes, size_t size, bool ofOrb);

}  // namespace fuzz

#endif
