// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#ifndef AQORB_TOOLS_PROGRAM_HPP
#define AQORB_TOOLS_PROGRAM_HPP

#include <opencv2/core/utility.hpp>

#include <functional>
#include <string>
#include <vector>

namespace tools
{

//! The parts of a list, for example of an option's values. An empty text has none.
std::vector<std::string> splitList(const std::string& list, char separator = ',');

//! The whole numbers of a list; what is no number is 0.
std::vector<int> splitNumbers(const std::string& list);

//! Thrown where arguments are not accepted. The message names them.
struct BadArguments
{
    std::string message;
};

//! Throws BadArguments where options that were asked for cannot be read, after printing which.
void checkRead(const cv::CommandLineParser& parser);

/** What the main functions of the tools have in common: --help, options that do not exist, and errors, which are
 printed to standard error with the name of the program.
 @param about printed above the options
 @param keys the options as cv::CommandLineParser has them, with help among them
 @param run does the work and returns the exit code
 @return the exit code: what run returns, 0 for --help, 1 for bad arguments, 2 for other errors */
int runProgram(const std::string& name, const std::string& about, const std::string& keys, int argc,
               const char* const* argv, const std::function<int(const cv::CommandLineParser&)>& run);

}  // namespace tools

#endif
