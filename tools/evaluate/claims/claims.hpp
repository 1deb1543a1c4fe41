// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#ifndef AQORB_CLAIMS_CLAIMS_HPP
#define AQORB_CLAIMS_CLAIMS_HPP

#include "measurements.hpp"

//! One line of what is claimed of a method. Texts that have nothing to say are empty.
struct Claim
{
    std::string what;
    int n;  //!< 0: several, or none
    std::string here, orb, paper, asked, aim;
    enum Verdict
    {
        NONE,
        HOLDS,
        FAILS
    } verdict;
    bool isTime;  //!< other load of the machine may decide it
};

//! The names of the methods that a claim compares.
struct Compared
{
    std::string method;
    std::string orb;        //!< cv::ORB
    std::string paper;      //!< the paper's selection, which was the default of version 0.1
    std::string paperSlam;  //!< SlamExtractor of version 0.1
    std::string dial;       //!< the other end of the dial: strength alone
};

//! The name of the method that is SlamExtractor with the settings of an aqorb; empty if the method is none.
std::string slamOf(const std::string& method);

//! What is claimed, and whether it holds. What was not measured is left out.
std::vector<Claim> judge(const Measurements& measured, const Compared& compared,
                         const std::vector<int>& numbers);

#endif
