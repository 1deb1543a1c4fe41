// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#ifndef AQORB_CLAIMS_MEASUREMENTS_HPP
#define AQORB_CLAIMS_MEASUREMENTS_HPP

#include <functional>
#include <string>
#include <vector>

//! One number that was measured.
struct Measurement
{
    std::string subject;  //!< what it belongs to, such as rolled
    std::string item;     //!< the image, the pair of images or the step, such as bikes/1-2
    std::string method;
    int n;  //!< features asked for
    std::string quantity;
    double value;
};

//! Everything that was measured. Questions that no measurement answers get not-a-number.
class Measurements
{
public:
    //! Which items count; an empty function lets all count.
    typedef std::function<bool(const std::string& item)> Filter;

    void add(const Measurement& measurement) { rows.push_back(measurement); }

    //! The values in the order in which they were measured, the same for all methods.
    std::vector<double> values(const std::string& subject, const std::string& method, int n,
                               const std::string& quantity, const Filter& filter = Filter()) const;
    double mean(const std::string& subject, const std::string& method, int n, const std::string& quantity,
                const Filter& filter = Filter()) const;

    void write(const std::string& file) const;

private:
    std::vector<Measurement> rows;
};

double mean(const std::vector<double>& values);

double standardDeviation(const std::vector<double>& values);

//! The standard error of the mean.
double standardError(const std::vector<double>& values);

//! Of each pair of values.
std::vector<double> differences(const std::vector<double>& a, const std::vector<double>& b);

//! Lets the items of these sets count, which begin with NAME/.
Measurements::Filter ofSets(const std::vector<std::string>& names);

#endif
