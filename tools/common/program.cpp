// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "program.hpp"

#include "options.hpp"

#include <iostream>

namespace tools
{

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
