// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// How long a frame takes beside another detector.

#include "benchmark.hpp"
#include "table.hpp"

#include <opencv2/core/utility.hpp>

#include <algorithm>
#include <iostream>

#include <sched.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

using namespace cv;

void touchOtherMemory()
{
    static std::vector<uint64> words((64 << 20) / sizeof(uint64));
    for (size_t i = 0; i < words.size(); i += 8)  // each cache line
        words[i]++;
}

namespace
{

//! Calls a detector on one image again and again.
class Runner
{
public:
    Runner(const Contender& contender, int n, const Mat& image_, bool cold_)
        : detector(contender.create(n)), image(image_), cold(cold_)
    {
    }

    double operator()()
    {
        if (cold)
            touchOtherMemory();
        return timeFrame(*detector, image, features);
    }

private:
    Ptr<Feature2D> detector;
    Mat image;
    bool cold;
    Features features;
};

//! A process that keeps the first processor busy while it exists.
class BusyProcess
{
public:
    BusyProcess() : process(fork())
    {
        if (process < 0)
            CV_Error(Error::StsError, "fork failed");
        if (process > 0)
            return;
        const sched_param ordinary = {};  // not the priority of this program
        sched_setscheduler(0, SCHED_OTHER, &ordinary);
        cpu_set_t first;
        CPU_ZERO(&first);
        CPU_SET(0, &first);
        sched_setaffinity(0, sizeof(first), &first);
        while (getppid() != 1)
            ;
        _exit(0);
    }
    ~BusyProcess()
    {
        kill(process, SIGKILL);
        waitpid(process, NULL, 0);
    }

private:
    const pid_t process;
};

}  // namespace

void measureSpeed(const Settings& settings, const Contender& other)
{
    const Contender ours = aqorbHere();
    const std::string ratio = "time of " + other.name + " / time of " + ours.name;
    std::cout << cpuName() << (settings.cold ? ", cold" : "") << "\n\n";
    Table cases({"image", "n", "threads", other.name + ", ms", ours.name + ", ms", ratio});
    Table means({"threads", ratio + ", geometric mean", "lowest", "highest"});
    for (const int threads : settings.threads)
    {
        setNumThreads(threads);
        std::vector<double> ratios;
        for (const std::string& spec : settings.images)
        {
            const Image image(spec);
            for (const int n : settings.numbers)
            {
                double ms[2];
                Runner theirs(other, n, image.pixels, settings.cold),
                    own(ours, n, image.pixels, settings.cold);
                ratios.push_back(medianRatio(std::ref(theirs), std::ref(own), settings.turns, ms));
                cases.add({image.name, std::to_string(n), std::to_string(threads), cell(ms[0]), cell(ms[1]),
                           cell(ratios.back())});
            }
        }
        means.add({std::to_string(threads), cell(geometricMean(ratios), 3),
                   cell(*std::min_element(ratios.begin(), ratios.end())),
                   cell(*std::max_element(ratios.begin(), ratios.end()))});
    }
    std::cout << cases.text() << "\n" << means.text() << std::flush;
}

void measureFrames(const Settings& settings, const std::vector<Contender>& contenders)
{
    std::cout << cpuName() << "\n\n";
    Table table({"one processor", "image", "n", "threads", "detector", "median, ms", "90th percentile, ms"});
    for (const bool isBusy : {false, true})
    {
        Ptr<BusyProcess> busy;
        if (isBusy)
            busy = makePtr<BusyProcess>();
        for (const int threads : settings.threads)
        {
            setNumThreads(threads);
            for (const std::string& spec : settings.images)
            {
                const Image image(spec);
                for (const int n : settings.numbers)
                {
                    std::vector<Runner> runners;
                    std::vector<std::vector<double>> times(contenders.size());
                    for (const Contender& contender : contenders)
                        runners.push_back(Runner(contender, n, image.pixels, settings.cold));
                    for (int turn = -3; turn < settings.turns; turn++)
                    {
                        for (size_t i = 0; i < runners.size(); i++)
                        {
                            const double ms = runners[i]();
                            if (turn >= 0)
                                times[i].push_back(ms);
                        }
                    }
                    for (size_t i = 0; i < runners.size(); i++)
                    {
                        std::sort(times[i].begin(), times[i].end());
                        table.add({isBusy ? "busy" : "idle", image.name, std::to_string(n),
                                   std::to_string(threads), contenders[i].name,
                                   cell(times[i][times[i].size() / 2]),
                                   cell(times[i][times[i].size() * 9 / 10])});
                    }
                }
            }
        }
    }
    std::cout << table.text() << std::flush;
}
