// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#ifndef AQORB_TOOLS_OPTIONS_HPP
#define AQORB_TOOLS_OPTIONS_HPP

#include <string>
#include <vector>

namespace tools
{

//! The parts of a list, for example of an option's values. An empty text has none.
std::vector<std::string> splitList(const std::string& list, char separator = ',');

//! The whole numbers of a list; what is no number is 0.
std::vector<int> splitNumbers(const std::string& list);

/** The first argument that is an option which a program does not have; empty if there is none.
 cv::CommandLineParser passes over such options without a word.
 @param keys as given to the parser */
std::string unknownOption(int argc, const char* const* argv, const std::string& keys);

}  // namespace tools

#endif
