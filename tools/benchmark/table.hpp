// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#ifndef AQORB_BENCHMARK_TABLE_HPP
#define AQORB_BENCHMARK_TABLE_HPP

#include <opencv2/core.hpp>

#include <string>
#include <vector>

//! A table in Markdown, to be pasted into a document.
class Table
{
public:
    //! The first column is set as text, the others as numbers.
    explicit Table(const std::vector<std::string>& columns) : rows(1, columns) {}

    //! Adds a row of as many cells as there are columns.
    void add(const std::vector<std::string>& cells)
    {
        CV_CheckEQ(cells.size(), rows[0].size(), "a row has as many cells as the table has columns");
        rows.push_back(cells);
    }

    std::string text() const
    {
        std::string result;
        for (size_t i = 0; i < rows.size(); i++)
        {
            for (const std::string& cell : rows[i])
                result += "| " + cell + " ";
            result += "|\n";
            for (size_t column = 0; i == 0 && column < rows[0].size(); column++)
                result += column == 0 ? "|---" : "|---:";
            result += i == 0 ? "|\n" : "";
        }
        return result;
    }

private:
    std::vector<std::vector<std::string>> rows;
};

//! The text of a number with so many decimals; empty for not-a-number.
inline std::string cell(double value, int digits = 2)
{
    return cvIsNaN(value) ? std::string() : cv::format("%.*f", digits, value);
}

#endif
