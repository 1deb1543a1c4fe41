// This file is part of the aqorb project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.

#ifndef AQORB_EVALUATE_RESULTS_HPP
#define AQORB_EVALUATE_RESULTS_HPP

#include "measures.hpp"
#include "method.hpp"

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

//! The motion from one frame to the next as one method sees it.
struct OdometryRow
{
    std::string method;
    int n, frame;
    int stereo, matches, inliers;
    double metres, degrees;  // error; NO_MOTION: there is none
};

const double NO_MOTION = 1e6;

//! Everything that was measured.
struct Results
{
    std::vector<std::string> methods;           // those measured, in order
    std::map<std::string, std::string> titles;  // of the methods
    std::vector<Ablation> ablations;            // measured, too
    std::map<std::string, std::string> absent;  // methods that could not be had, and why
    std::vector<int> numbers;                   // of features; the first is the paper's
    std::vector<FeatureRow> features;
    std::vector<MatchingRow> matching;
    std::vector<OdometryRow> odometry;
};

//! Writes uniformity.csv, matching.csv, homography.csv and odometry.csv.
void writeCsv(const Results& results, const std::string& folder);

//! Writes tables.md: the paper's tables with ours beside them, and those beyond it.
void writeTables(const Results& results, const std::string& file);

#endif
