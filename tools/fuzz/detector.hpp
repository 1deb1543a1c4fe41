// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#ifndef OPENCV_AQORB_FUZZ_DETECTOR_HPP
#define OPENCV_AQORB_FUZZ_DETECTOR_HPP

#include <fuzzer/FuzzedDataProvider.h>
#include <opencv2/aqorb.hpp>

#include <functional>
#include <string>

namespace fuzz
{

//! Thrown when something other than the documentation says has happened.
struct Problem
{
    std::string text;
};

//! Throws a Problem unless the condition holds.
void require(bool condition, const std::string& what);

//! All parameters of cv::ORB as they were set, since its getters cannot return an invalid score type.
struct OrbParameters
{
    int nfeatures = 500;
    double scaleFactor = 1.2f;
    int nlevels = 8, edgeThreshold = 16, firstLevel = 0, WTA_K = 2, scoreType = cv::ORB::HARRIS_SCORE;
    int patchSize = 31, fastThreshold = 20;

    //! Whether a value is bad by itself.
    bool isBad() const;
    //! Whether values contradict each other.
    bool clash() const;

    double scale(int level) const;
    bool hasTooLargeLevel(cv::Size image, int level) const;
};

//! How a call must end.
enum Expectation
{
    GOOD,    //!< without an exception: all arguments are good
    BAD,     //!< by an exception that names a bad argument
    UNKNOWN  //!< in either way
};

inline Expectation expect(bool bad)
{
    return bad ? BAD : GOOD;
}

class Detector
{
public:
    //! Calls a function. Returns false if it rejected its arguments, and throws a Problem if it should not have.
    bool attempt(const char* name, Expectation expected, const std::function<void()>& function);

    // Each takes from the bytes what to do.
    void create(FuzzedDataProvider& data);
    void setOrbParameter(FuzzedDataProvider& data);
    void setOurParameter(FuzzedDataProvider& data);
    void readStorage(FuzzedDataProvider& data);

    cv::Ptr<cv::aqorb::AdaptiveQuadtreeORB> orb;  //!< empty before create
    OrbParameters parameters;                     //!< what the getters must return

private:
    void make(const OrbParameters& p);
    //! What the getters return.
    OrbParameters current() const;
    //! Requires that a rejected value was not stored, and that an accepted one was.
    void requireParameters(const char* after) const;
};

}  // namespace fuzz

#endif
