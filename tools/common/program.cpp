// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "program.hpp"

#include <algorithm>
#include <cstdlib>
#include <iostream>
#include <set>
#include <sstream>

namespace tools
{

std::vector<std::string> splitList(const std::string& list, char separator)
{
    std::vector<std::string> parts;
    std::istringstream stream(list);
    for (std::string part; std::getline(stream, part, separator);)
        parts.push_back(part);
    return parts;
}

std::vector<int> splitNumbers(const std::string& list)
{
    std::vector<int> numbers;
    for (const std::string& number : splitList(list))
        numbers.push_back(std::atoi(number.c_str()));
    return numbers;
}

//! The names of the options: the words between `{` and the first `|` of each.
static std::set<std::string> optionNames(const std::string& keys)
{
    std::set<std::string> names;
    for (size_t begin = keys.find('{'); begin != std::string::npos; begin = keys.find('{', begin + 1))
    {
        std::istringstream words(keys.substr(begin + 1, keys.find('|', begin) - begin - 1));
        for (std::string word; words >> word;)
            names.insert(word);
    }
    return names;
}

/** The first argument that is an option which a program does not have; empty if there is none.
 cv::CommandLineParser passes over such options without a word. */
static std::string unknownOption(int argc, const char* const* argv, const std::string& keys)
{
    const std::set<std::string> known = optionNames(keys);
    for (int i = 1; i < argc; i++)
    {
        const std::string argument = argv[i];
        const size_t name = std::min(argument.find_first_not_of('-'), argument.size());
        if (name > 0 && !known.count(argument.substr(name, argument.find('=') - name)))
            return argument;
    }
    return std::string();
}

void checkRead(const cv::CommandLineParser& parser)
{
    if (parser.check())
        return;
    parser.printErrors();
    throw BadArguments{"see --help"};
}

int runProgram(const std::string& name, const std::string& about, const std::string& keys, int argc,
               const char* const* argv, const std::function<int(const cv::CommandLineParser&)>& run)
{
    const auto fail = [&name](const std::string& message, int code)
    {
        std::cerr << name << ": " << message << std::endl;
        return code;
    };
    try
    {
        cv::CommandLineParser parser(argc, argv, keys);
        parser.about(about);
        if (parser.has("help"))
        {
            parser.printMessage();
            return 0;
        }
        const std::string unknown = unknownOption(argc, argv, keys);
        if (!unknown.empty())
            throw BadArguments{unknown + ": unknown option; see --help"};
        return run(parser);
    }
    catch (const BadArguments& bad)
    {
        return fail(bad.message, 1);
    }
    catch (const cv::Exception& error)
    {
        return fail(error.err, 2);
    }
    catch (const std::exception& error)
    {
        return fail(error.what(), 2);
    }
}

}  // namespace tools
