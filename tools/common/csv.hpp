// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#ifndef AQORB_TOOLS_CSV_HPP
#define AQORB_TOOLS_CSV_HPP

#include <string>
#include <vector>

namespace tools
{

//! What a tool has measured, for tools/report to make tables and figures of.
class CsvTable
{
public:
    explicit CsvTable(const std::vector<std::string>& columns);
    //! Adds a row of as many cells as there are columns.
    void add(const std::vector<std::string>& cells);
    //! The text: a line of column names, then the rows; cells are quoted as RFC 4180 says.
    std::string text() const;
    //! Writes the text to a file. Throws cv::Exception if that fails.
    void write(const std::string& file) const;

private:
    std::vector<std::vector<std::string>> rows;
};

//! A number as a cell, with the nine digits that no mean in a table needs all of.
std::string csvNumber(double value);

}  // namespace tools

#endif
