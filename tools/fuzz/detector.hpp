// This file is part of the aqorb project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.

#ifndef OPENCV_AQORB_FUZZ_DETECTOR_HPP
#define OPENCV_AQORB_FUZZ_DETECTOR_HPP

#include "calls.hpp"

#include <fuzzer/FuzzedDataProvider.h>
#include <opencv2/aqorb.hpp>

#include <functional>

namespace fuzz
{

//! Another thing than what the documentation says has happened.
struct Problem
{
    Outcome outcome;
    std::string text;
};

//! Throws a Problem, BAD_OUTPUT, unless the condition holds.
void require(bool condition, const std::string& what);

//! All of cv::ORB, which has no getter that could tell an invalid score type.
struct OrbParameters
{
    int nfeatures = 500;
    double scaleFactor = 1.2f;
    int nlevels = 8, edgeThreshold = 16, firstLevel = 0, WTA_K = 2, scoreType = cv::ORB::HARRIS_SCORE;
    int patchSize = 31, fastThreshold = 20;

    //! Whether a value is bad by itself; `limits`: also one that only AdaptiveQuadtreeORB rejects.
    bool isBad(bool limits) const;
    //! Whether values do not go together.
    bool clash() const;

    double scale(int level) const;
    bool hasTooLargeLevel(cv::Size image, int level) const;
};

//! What a call must come to.
enum Expectation
{
    GOOD,    //!< arguments: no exception
    BAD,     //!< an exception that names one
    UNKNOWN  //!< either
};

inline Expectation expect(bool bad)
{
    return bad ? BAD : GOOD;
}

//! AdaptiveQuadtreeORB or cv::ORB.
class Detector
{
public:
    explicit Detector(bool ofOrb) : isOrb(ofOrb) {}

    //! Calls a function; false if it rejected its arguments.
    bool attempt(const char* name, Expectation expected, const std::function<void()>& function);

    // What the bytes say: creates it with parameters of any kind, sets one, ...
    void create(FuzzedDataProvider& data);
    void setOrbParameter(FuzzedDataProvider& data);
    void setOurParameter(FuzzedDataProvider& data);
    void readStorage(FuzzedDataProvider& data);

    const bool isOrb;
    cv::Ptr<cv::aqorb::AdaptiveQuadtreeORB> ours;  //!< empty for cv::ORB
    cv::Ptr<cv::ORB> orb;                          //!< the same, or cv::ORB; empty before create
    OrbParameters parameters;                      //!< what they must be
    int rejections = 0;                            //!< calls that threw what they should

private:
    void make(const OrbParameters& p);
    //! A value that was rejected must not stay, one that was accepted must.
    void requireParameters(const char* after) const;
};

}  // namespace fuzz

#endif
