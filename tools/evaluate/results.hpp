// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#ifndef AQORB_EVALUATE_RESULTS_HPP
#define AQORB_EVALUATE_RESULTS_HPP

#include "measures.hpp"
#include "method.hpp"
#include "stereo_odometry.hpp"

#include <map>
#include <string>
#include <vector>

//! What one method found in one image.
struct FeatureRow
{
    std::string set;
    int image;
    std::string method;
    int n, keypoints;
    double uniformity, occupancy;
    double milliseconds;  // CPU time; negative: not measured
};

//! How one method matched the first image of a set with another.
struct MatchingRow
{
    std::string set;
    int image;
    std::string method;
    int n;
    Matching matching;
};

//! The motion from the frame before to this one, by the features of one method.
struct OdometryRow
{
    std::string method;
    int n, frame;
    OdometryStep step;
};

//! Everything that was measured.
struct Results
{
    std::vector<std::string> methods;           // in the order of the command line
    std::map<std::string, std::string> titles;  // of the methods
    std::vector<Ablation> ablations;            // measured in addition
    std::map<std::string, std::string> absent;  // methods that were left out, and why
    std::vector<FeatureRow> features;
    std::vector<MatchingRow> matching;
    std::vector<OdometryRow> odometry;
};

/** Writes what tools/report/evaluation.py makes tables of, all numbers as they were measured:
 - setting.csv: what OpenCV and which CPU features were in use
 - methods.csv: titles of the methods and of the ablations, and why others are absent
 - uniformity.csv, matching.csv, homography.csv, odometry.csv: the measures */
void writeCsv(const Results& results, const std::string& folder);

#endif
