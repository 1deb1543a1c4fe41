// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// How long a frame takes in a program that does other work, too.

#include "measure.hpp"

#include "../../perf/perf_stream.hpp"
#include "../common/median.hpp"
#include "../common/program.hpp"

#include <opencv2/core/utility.hpp>

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <iostream>

#include <sys/wait.h>
#include <unistd.h>

using namespace cv;
using opencv_test::OtherMemory;

namespace
{

const size_t COLD_MEMORY = 64;  // megabytes of other memory that are touched before a call
const int WARM_CALLS = 3;       // that come before the measured ones in a block of warm calls

//! A detector of each contender, its outputs and the times of its calls in ms.
class Race
{
public:
    Race(const std::vector<Contender>& contenders, int nfeatures)
    {
        for (const Contender& contender : contenders)
            runners.push_back({contender.create(nfeatures), Features(), {}});
    }

    size_t size() const { return runners.size(); }
    void call(size_t i, const Mat& image, bool counts)
    {
        const double seconds = timeFrame(*runners[i].detector, image, runners[i].features);
        if (counts)
            runners[i].times.push_back(1e3 * seconds);
    }
    double median(size_t i) const { return tools::median(runners[i].times); }
    size_t keypoints(size_t i) const { return runners[i].features.keypoints.size(); }

private:
    struct Runner
    {
        Ptr<Feature2D> detector;
        Features features;
        std::vector<double> times;
    };

    std::vector<Runner> runners;
};

//! Call by call: cv::ORB, AdaptiveQuadtreeORB, cv::ORB, the other build, and again.
void runInTurns(Race& race, const Mat& image, int calls)
{
    for (int call = -1; call < calls; call++)
        for (size_t i = 1; i < race.size(); i++)
        {
            race.call(0, image, call >= 0);
            race.call(i, image, call >= 0);
        }
}

//! Other memory is touched before each call.
void runCold(Race& race, const Mat& image, int calls)
{
    static OtherMemory memory(COLD_MEMORY);
    for (size_t i = 0; i < race.size(); i++)
        race.call(i, image, false);
    for (int call = 0; call < calls; call++)
        for (size_t i = 0; i < race.size(); i++)
        {
            memory.touch();
            race.call(i, image, true);
        }
}

//! Calls of the same detector one right after the other.
void runWarm(Race& race, const Mat& image, int calls)
{
    for (size_t i = 0; i < race.size(); i++)
        for (int call = -WARM_CALLS; call < calls; call++)
            race.call(i, image, call >= 0);
}

//! Different frames, with other work between, as in perf/.
void runStream(Race& race, const Mat& image, int calls)
{
    static OtherMemory memory(opencv_test::STREAM_WORK);
    const std::vector<Mat> frames = opencv_test::panFrames(image);
    for (size_t i = 0; i < race.size(); i++)
    {
        race.call(i, frames.back(), false);
        for (int call = 0; call < calls; call++)
        {
            memory.touch();
            race.call(i, frames[call % frames.size()], true);
        }
    }
}

const struct
{
    const char* name;
    void (*run)(Race&, const Mat&, int);
} CASES[] = {{"turns", runInTurns}, {"cold", runCold}, {"warm", runWarm}, {"stream", runStream}};

bool has(const ProgramSettings& settings, const std::string& name)
{
    return std::find(settings.cases.begin(), settings.cases.end(), name) != settings.cases.end();
}

//! Measures the cases one after the other with the CPU features that OpenCV now uses.
void measureCases(const ProgramSettings& settings, tools::CsvTable& table)
{
    const std::vector<Contender> contenders = makeContenders(settings.beside);
    const std::string cpu = getCPUFeaturesLine();
    std::cerr << "CPU features in use: " << cpu << std::endl;
    std::vector<Image> images;
    for (const std::string& spec : settings.images)
        images.push_back(Image(spec));
    for (int pass = 0; pass < settings.passes; pass++)
        for (const auto& each : CASES)
        {
            if (!has(settings, each.name))
                continue;
            for (const int threads : settings.threads)
            {
                setNumThreads(threads);
                for (const Image& image : images)
                    for (const int n : settings.numbers)
                    {
                        Race race(contenders, n);
                        each.run(race, image.pixels, settings.calls);
                        for (size_t i = 0; i < race.size(); i++)
                            table.add({cpu, each.name, std::to_string(threads), image.name, std::to_string(n),
                                       std::to_string(pass), contenders[i].name,
                                       std::to_string(race.keypoints(i)), tools::csvNumber(race.median(i))});
                    }
            }
        }
}

/** Measures the case turns in a process of its own without AVX-512: OpenCV decides at its start which CPU features it
 uses. */
void measureWithoutAvx512(const ProgramSettings& settings, tools::CsvTable& table)
{
    const std::string file = tempfile(".csv");
    std::vector<std::string> arguments = settings.arguments;
    arguments.push_back("--cases=turns");
    std::vector<char*> pointers;
    for (std::string& argument : arguments)
        pointers.push_back(&argument[0]);
    pointers.push_back(NULL);
    const pid_t child = fork();
    if (child < 0)
        CV_Error(Error::StsError, "fork failed");
    if (child == 0)
    {
        setenv("OPENCV_CPU_DISABLE", "AVX512-SKX,AVX512F", 1);
        if (std::freopen(file.c_str(), "w", stdout))
            execv("/proc/self/exe", pointers.data());
        _exit(127);
    }
    int status = 0;
    waitpid(child, &status, 0);
    std::ifstream stream(file);
    std::string line;
    std::getline(stream, line);  // the names of the columns
    while (std::getline(stream, line))
        table.add(tools::splitList(line));
    std::remove(file.c_str());
    if (status != 0)
        CV_Error(Error::StsError, "The process without AVX-512 failed");
}

}  // namespace

tools::CsvTable measureProgram(const ProgramSettings& settings)
{
    tools::CsvTable table({"cpu", "case", "threads", "image", "n", "pass", "detector", "keypoints", "ms"});
    measureCases(settings, table);
    if (has(settings, "avx2") && checkHardwareSupport(CPU_AVX512_SKX))
        measureWithoutAvx512(settings, table);
    return table;
}
