// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "csv.hpp"
#include "median.hpp"
#include "options.hpp"
#include "program.hpp"

#include <gtest/gtest.h>
#include <opencv2/core.hpp>

#include <stdexcept>

namespace
{

TEST(Aqorb_Common, csv_quotes_cells_and_keeps_digits)
{
    tools::CsvTable table({"name", "value"});
    table.add({"a, \"b\"", tools::csvNumber(1. / 3)});
    table.add({"", tools::csvNumber(1e6)});
    EXPECT_EQ("name,value\n\"a, \"\"b\"\"\",0.333333333\n,1000000\n", table.text());
}

TEST(Aqorb_Common, csv_rejects_wrong_rows_and_files)
{
    tools::CsvTable table({"name", "value"});
    EXPECT_THROW(table.add({"one"}), cv::Exception);
    EXPECT_THROW(table.write("/nowhere/table.csv"), cv::Exception);
}

TEST(Aqorb_Common, options_splits_lists)
{
    EXPECT_EQ((std::vector<std::string>{"a", "", "b"}), tools::splitList("a,,b"));
    EXPECT_EQ((std::vector<std::string>{"a,b", "c"}), tools::splitList("a,b:c", ':'));
    EXPECT_TRUE(tools::splitList("").empty());
    EXPECT_EQ((std::vector<int>{500, -1, 0}), tools::splitNumbers("500,-1,many"));
}

TEST(Aqorb_Common, options_finds_unknown_options)
{
    const std::string keys = "{help h | | help }{out | . | folder }{@input | | file }";
    const char* const good[] = {"program", "--out=x", "-h", "file", "--help"};
    const char* const bad[] = {"program", "--out=x", "--outt=y"};
    EXPECT_EQ("", tools::unknownOption(5, good, keys));
    EXPECT_EQ("--outt=y", tools::unknownOption(3, bad, keys));
}

TEST(Aqorb_Common, programs_return_what_went_wrong)
{
    const auto codeOf = [](const char* argument, const std::function<int(const cv::CommandLineParser&)>& run)
    {
        const char* const arguments[] = {"program", argument};
        testing::internal::CaptureStdout();
        testing::internal::CaptureStderr();
        const int code =
            tools::runProgram("tool", "about", "{help h | | help }{number | 1 | }", 2, arguments, run);
        return std::to_string(code) + " " + testing::internal::GetCapturedStderr() +
               (testing::internal::GetCapturedStdout().empty() ? "" : "output");
    };
    const auto number = [](const cv::CommandLineParser& parser)
    {
        const int value = parser.get<int>("number");
        tools::checkRead(parser);
        return value;
    };
    EXPECT_EQ("7 ", codeOf("--number=7", number));
    EXPECT_EQ("1 tool: see --help\noutput", codeOf("--number=x", number));
    EXPECT_EQ("0 output", codeOf("--help", number));
    EXPECT_EQ("1 tool: --other: unknown option; see --help\n", codeOf("--other", number));
    EXPECT_EQ("1 tool: bad\n",
              codeOf("", [](const cv::CommandLineParser&) -> int { throw tools::BadArguments{"bad"}; }));
    EXPECT_EQ("2 tool: broken\n",
              codeOf("", [](const cv::CommandLineParser&) -> int { throw std::runtime_error("broken"); }));
    EXPECT_EQ("2 tool: wrong\n",
              codeOf("",
                     [](const cv::CommandLineParser&) -> int
                     { throw cv::Exception(cv::Error::StsError, "wrong", "here", "file", 1); }));
}

TEST(Aqorb_Common, median_of_odd_even_and_none)
{
    EXPECT_EQ(2, tools::median({3, 1, 2}));
    EXPECT_EQ(2.5, tools::median({4, 1, 2, 3}));
    EXPECT_EQ(0, tools::median({}));
}

}  // namespace
