// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "csv.hpp"

#include <opencv2/core.hpp>

#include <fstream>

namespace tools
{

static std::string quoted(const std::string& cell)
{
    if (cell.find_first_of(",\"\r\n") == std::string::npos)
        return cell;
    std::string result = "\"";
    for (const char c : cell)
        result += c == '"' ? "\"\"" : std::string(1, c);
    return result + "\"";
}

CsvTable::CsvTable(const std::vector<std::string>& columns) : rows(1, columns)
{
}

void CsvTable::add(const std::vector<std::string>& cells)
{
    CV_CheckEQ(cells.size(), rows[0].size(), "a row has as many cells as the table has columns");
    rows.push_back(cells);
}

std::string CsvTable::text() const
{
    std::string result;
    for (const std::vector<std::string>& row : rows)
    {
        for (size_t i = 0; i < row.size(); i++)
            result += (i > 0 ? "," : "") + quoted(row[i]);
        result += '\n';
    }
    return result;
}

void CsvTable::write(const std::string& file) const
{
    std::ofstream stream(file);
    stream << text();
    stream.close();
    if (!stream)
        CV_Error(cv::Error::StsError, file + ": cannot be written");
}

std::string csvNumber(double value)
{
    return cv::format("%.9g", value);
}

}  // namespace tools
