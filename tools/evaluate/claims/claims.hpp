// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#ifndef AQORB_CLAIMS_CLAIMS_HPP
#define AQORB_CLAIMS_CLAIMS_HPP

#include "measurements.hpp"

//! Of the images that are scaled: all of them, and those that are rolled, too.
extern const std::vector<double> SCALES, ROLLED_SCALES;

//! Of features of the object: that of find_obj.py, 400, is not judged.
extern const std::vector<int> OBJECT_NUMBERS;

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

//! The geometric mean over the scales of the mean number of distinct correct matches.
double distinctAtScales(const Measurements& measured, const std::string& method, int n);

//! What is claimed, and whether it holds. What was not measured is left out.
std::vector<Claim> judge(const Measurements& measured, const Compared& compared,
                         const std::vector<int>& numbers);

#endif
