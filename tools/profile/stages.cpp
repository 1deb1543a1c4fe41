// This file is part of the aqorb project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.

#include "benchmark.hpp"
#include "profile.hpp"

#include <opencv2/core/utility.hpp>

#include <algorithm>
#include <cstdio>
#include <iostream>
#include <iterator>

#include <sys/wait.h>
#include <unistd.h>

using namespace cv;

namespace
{

//! Runs frames of an image in a process of its own, as OpenCV decides at its start whether it traces.
std::vector<TraceRegion> trace(const Image& image, const Settings& settings)
{
    const std::string location = tempfile();
    const pid_t child = fork();
    if (child < 0)
        CV_Error(Error::StsError, "fork failed");
    if (child == 0)
    {
        setenv("OPENCV_TRACE", "1", 1);
        setenv("OPENCV_TRACE_LOCATION", location.c_str(), 1);
        for (const char* limit :
             {"OPENCV_TRACE_DEPTH_OPENCV", "OPENCV_TRACE_MAX_CHILDREN_OPENCV", "OPENCV_TRACE_MAX_CHILDREN"})
            setenv(limit, "0", 1);  // none
        const std::string images = "--images=" + image.spec, n = format("--n=%d", settings.nfeatures),
                          frames = format("--frames=%d", settings.repeats);
        execl("/proc/self/exe", "aqorb_profile", images.c_str(), n.c_str(), frames.c_str(), (char*)NULL);
        _exit(127);
    }
    int status = 0;
    waitpid(child, &status, 0);
    if (status != 0)
        CV_Error(Error::StsError, "The traced process failed");
    std::vector<TraceRegion> calls;
    for (TraceRegion& region : readTrace(location))
    {
        if (region.is("AdaptiveQuadtreeORBImpl::detectAndCompute"))
            calls.push_back(std::move(region));
    }
    std::remove((location + ".txt").c_str());
    std::remove((location + "-000.txt").c_str());
    if (calls.size() != size_t(settings.repeats + WARM_UP))
        CV_Error(Error::StsError, format("The trace has %d frames", int(calls.size())));
    calls.erase(calls.begin(), calls.begin() + WARM_UP);
    return calls;
}

//! Median time of a frame by numbers of threads, measured in turns.
std::vector<double> timeByThreads(const Image& image, const Settings& settings,
                                  const std::vector<int>& threads)
{
    const Ptr<Feature2D> detector = createDetector(AQORB, settings.nfeatures);
    Features features;
    std::vector<std::vector<double>> times(threads.size());
    const int turn = 5;
    for (int i = 0; i < settings.repeats; i += turn)
    {
        for (size_t t = 0; t < threads.size(); t++)
        {
            setNumThreads(threads[t]);
            timeFrame(*detector, image.pixels, features);
            for (int j = 0; j < turn; j++)
                times[t].push_back(timeFrame(*detector, image.pixels, features));
        }
    }
    std::vector<double> medians;
    std::transform(times.begin(), times.end(), std::back_inserter(medians), median);
    return medians;
}

std::string percent(double part, double whole)
{
    return format("%.1f", 100 * part / whole);
}

//! Of frames, times as % of the total and bounds on the speedup, as medians.
std::vector<std::string> criticalPath(const std::vector<TraceRegion>& frames)
{
    const int threads[] = {2, 4, 8, 0};
    std::vector<double> serial, longest, bounds[4];
    for (const TraceRegion& frame : frames)
    {
        serial.push_back(serialTime(frame) / frame.duration);
        longest.push_back(leastTime(frame, 0) / frame.duration - serial.back());
        for (int i = 0; i < 4; i++)
            bounds[i].push_back(frame.duration / leastTime(frame, threads[i]));
    }
    std::vector<std::string> cells = {percent(median(serial), 1), percent(median(longest), 1)};
    for (const std::vector<double>& bound : bounds)
        cells.push_back(format("%.2f", median(bound)));
    return cells;
}

}  // namespace

void printStages(const Settings& settings)
{
    std::vector<Image> images;
    std::vector<Profile> profiles;
    std::vector<std::vector<double>> times;
    std::vector<std::vector<std::string>> paths;
    const std::vector<int> threads = getNumberOfCPUs() > 1 ? std::vector<int>{1, 2} : std::vector<int>{1};
    std::vector<std::string> absent;
    for (const std::string& spec : settings.images)
    {
        images.push_back(Image(spec));
        const std::vector<TraceRegion> frames = trace(images.back(), settings);
        absent = absentStages(frames);
        if (!absent.empty())
            CV_Error(Error::StsError, "Not in the trace: " + absent[0] + "; see profile.cpp");
        std::vector<Profile> ofFrames;
        std::transform(frames.begin(), frames.end(), std::back_inserter(ofFrames), profileOf);
        profiles.push_back(medianOf(ofFrames));
        paths.push_back(criticalPath(frames));
        times.push_back(timeByThreads(images.back(), settings, threads));
    }

    std::vector<std::string> head(1, "% of a frame");
    for (const Image& image : images)
        head.push_back(image.name);
    Table stages("Stages", head);
    for (int stage = 0; stage < STAGE_COUNT; stage++)
    {
        std::vector<std::string> row(1, nameOf(Stage(stage)));
        for (const Profile& profile : profiles)
            row.push_back(percent(profile.stages[stage], profile.total));
        stages.add(row);
    }
    std::vector<std::string> cost(1, "a traced frame takes longer by %");
    for (size_t i = 0; i < images.size(); i++)
        cost.push_back(format("%.0f", 100 * (profiles[i].total * 1e-9 / times[i][0] - 1)));
    stages.add(cost);
    stages.print();
    std::cout << "One thread, n = " << settings.nfeatures << ".\n\n";

    Table path("Critical path", {"image", "selection %", "serial %", "longest tasks %", "bound, 2 threads",
                                 "4", "8", "enough threads", "measured, 2 threads"});
    for (size_t i = 0; i < images.size(); i++)
    {
        std::vector<std::string> row = {images[i].name,
                                        percent(profiles[i].stages[SELECTION], profiles[i].total)};
        row.insert(row.end(), paths[i].begin(), paths[i].end());
        row.push_back(times[i].size() > 1 ? format("%.2f", times[i][0] / times[i][1]) : "");
        path.add(row);
    }
    path.print();
}
