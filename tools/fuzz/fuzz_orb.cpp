// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "calls.hpp"

#include <opencv2/core/ocl.hpp>
#include <opencv2/core/utils/filesystem.hpp>
#include <opencv2/core/utility.hpp>

#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <map>
#include <vector>

// Gives the inputs of fuzz_api to cv::ORB and to AdaptiveQuadtreeORB, and counts the outcomes:
//
//   fuzz_orb FOLDER...
//
// Each input gets a process of its own with 10 seconds and 4 GB. It counts once, by the worst that happened.

namespace
{

// These come in addition to fuzz::Outcome.
const int CRASH = fuzz::BAD_OUTPUT + 1, TIMEOUT = CRASH + 1, OUTCOMES = TIMEOUT + 1;
const char* const NAMES[OUTCOMES] = {
    "every call did what it should", "a bad argument rejected by an exception that names it",
    "a bad argument accepted",       "another exception",
    "an output that is wrong",       "crash",
    "not done within 10 s",
};

typedef std::map<std::string, int> Problems;

//! Runs one input in a process of its own. Gives its outcome and the problem in words.
int outcomeOf(const std::vector<char>& input, bool ofOrb, std::string& problem)
{
    int ends[2];
    if (pipe(ends) != 0)
        throw std::runtime_error("no pipe");
    const pid_t child = fork();
    if (child < 0)
        throw std::runtime_error("no process");
    if (child == 0)
    {
        const rlimit memory = {size_t(4) << 30, size_t(4) << 30}, none = {0, 0};
        setrlimit(RLIMIT_AS, &memory);
        setrlimit(RLIMIT_CORE, &none);
        alarm(10);
        const fuzz::Report report =
            fuzz::callDetector(reinterpret_cast<const uint8_t*>(input.data()), input.size(), ofOrb);
        const std::string& text = report.problem;
        _exit(write(ends[1], text.data(), text.size()) == ssize_t(text.size()) ? report.outcome : CRASH);
    }
    close(ends[1]);
    problem.clear();
    char buffer[1024];
    for (ssize_t count; (count = read(ends[0], buffer, sizeof(buffer))) > 0;)
        problem.append(buffer, size_t(count));
    close(ends[0]);
    int status = 0;
    waitpid(child, &status, 0);
    if (WIFEXITED(status))
        return std::min(WEXITSTATUS(status), CRASH);
    return WTERMSIG(status) == SIGALRM ? TIMEOUT : CRASH;
}

}  // namespace

int main(int argc, char** argv)
{
    cv::setNumThreads(1);
    cv::ocl::setUseOpenCL(false);
    std::vector<cv::String> files;
    for (int i = 1; i < argc; i++)
    {
        std::vector<cv::String> found;
        cv::utils::fs::glob(argv[i], "", found, true);
        files.insert(files.end(), found.begin(), found.end());
    }
    std::sort(files.begin(), files.end());

    int counts[2][OUTCOMES] = {};
    Problems problems[2];
    for (const cv::String& file : files)
    {
        std::ifstream stream(file, std::ios::binary);
        const std::vector<char> input((std::istreambuf_iterator<char>(stream)),
                                      std::istreambuf_iterator<char>());
        for (int ours = 0; ours <= 1; ours++)
        {
            std::string problem;
            counts[ours][outcomeOf(input, !ours, problem)]++;
            if (!problem.empty())
                problems[ours][problem.substr(0, problem.find('\n'))]++;
        }
    }
    std::printf("| %d inputs | cv::ORB | AdaptiveQuadtreeORB |\n|---|---|---|\n", int(files.size()));
    for (int i = 0; i < OUTCOMES; i++)
        std::printf("| %s | %d | %d |\n", NAMES[i], counts[0][i], counts[1][i]);
    for (int ours = 0; ours <= 1; ours++)
    {
        std::printf("\n%s:\n", ours ? "AdaptiveQuadtreeORB" : "cv::ORB");
        for (Problems::const_iterator it = problems[ours].begin(); it != problems[ours].end(); ++it)
            std::printf("%6d  %s\n", it->second, it->first.c_str());
    }
    return 0;
}
