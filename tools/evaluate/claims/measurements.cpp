// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "measurements.hpp"

#include "../../common/csv.hpp"

#include <opencv2/core.hpp>

#include <cmath>
#include <limits>

std::vector<double> Measurements::values(const std::string& subject, const std::string& method, int n,
                                         const std::string& quantity, const Filter& filter) const
{
    std::vector<double> found;
    for (const Measurement& row : rows)
        if (row.subject == subject && row.method == method && row.n == n && row.quantity == quantity &&
            (!filter || filter(row.item)))
            found.push_back(row.value);
    return found;
}

double Measurements::mean(const std::string& subject, const std::string& method, int n,
                          const std::string& quantity, const Filter& filter) const
{
    return ::mean(values(subject, method, n, quantity, filter));
}

void Measurements::write(const std::string& file) const
{
    tools::CsvTable table({"subject", "item", "method", "n", "quantity", "value"});
    for (const Measurement& row : rows)
        table.add({row.subject, row.item, row.method, std::to_string(row.n), row.quantity,
                   tools::csvNumber(row.value)});
    table.write(file);
}

double mean(const std::vector<double>& values)
{
    double sum = 0;
    for (const double value : values)
        sum += value;
    return values.empty() ? std::numeric_limits<double>::quiet_NaN() : sum / double(values.size());
}

double standardDeviation(const std::vector<double>& values)
{
    const double count = double(values.size()), middle = mean(values);
    double sum = 0;
    for (const double value : values)
        sum += (value - middle) * (value - middle);
    return count < 2 ? std::numeric_limits<double>::quiet_NaN() : std::sqrt(sum / (count - 1));
}

double standardError(const std::vector<double>& values)
{
    return standardDeviation(values) / std::sqrt(double(values.size()));
}

std::vector<double> differences(const std::vector<double>& a, const std::vector<double>& b)
{
    CV_Assert(a.size() == b.size());
    std::vector<double> result;
    for (size_t i = 0; i < a.size(); i++)
        result.push_back(a[i] - b[i]);
    return result;
}

Measurements::Filter ofSets(const std::vector<std::string>& names)
{
    return [names](const std::string& item)
    {
        for (const std::string& name : names)
            if (item.compare(0, name.size() + 1, name + "/") == 0)
                return true;
        return false;
    };
}
