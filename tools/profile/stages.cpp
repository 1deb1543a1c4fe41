// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "measure.hpp"
#include "profile.hpp"
#include "recorded_frame.hpp"

#include <opencv2/core/utility.hpp>

#include <cstdio>
#include <memory>

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

//! Times of the frames of an image.
class FrameTimes
{
public:
    FrameTimes(tools::CsvTable& table_, const Image& image_) : table(table_), image(image_) {}

    void add(size_t frame, const char* kind, const std::string& name, double nanoseconds)
    {
        table.add({image.name, std::to_string(frame), kind, name, format("%.0f", nanoseconds)});
    }

private:
    tools::CsvTable& table;
    const Image& image;
};

/** The least times of a frame by numbers of threads. A frame is divided into more tasks for more threads, and one thread
 does them. Whatever is outside of tasks is serial. */
void recordTasks(const Image& image, const Settings& settings, FrameTimes& times)
{
    const std::vector<int> numbers = {1, 2, 4, 8};
    std::vector<std::unique_ptr<FrameRecorder>> recorders;
    for (const int threads : numbers)
        recorders.emplace_back(new FrameRecorder(threads, settings.nfeatures));
    for (int i = -WARM_UP; i < settings.repeats; i++)
    {
        for (size_t j = 0; j < numbers.size(); j++)
        {
            const RecordedTasks recorded = recorders[j]->record(image.pixels);
            if (i < 0)
                continue;
            const double serial = recorded.frame - workOf(recorded.tasks);
            const std::string threads = " " + std::to_string(numbers[j]);
            times.add(i, "path", "frame" + threads, recorded.frame);
            times.add(i, "path", "serial" + threads, serial);
            times.add(i, "path", "longest" + threads, serial + longestPath(recorded.tasks));
            times.add(i, "path", "least" + threads, serial + leastTime(recorded.tasks, numbers[j]));
            times.add(i, "path", "queue" + threads, serial + queueTime(recorded.tasks, numbers[j]));
        }
    }
}

}  // namespace

tools::CsvTable measureStages(const Settings& settings)
{
    tools::CsvTable table({"image", "frame", "kind", "name", "ns"});
    for (const std::string& spec : settings.images)
    {
        const Image image(spec);
        FrameTimes times(table, image);
        const std::vector<TraceRegion> frames = trace(image, settings);
        const std::vector<std::string> absent = absentStages(frames);
        if (!absent.empty())
            CV_Error(Error::StsError, "Not in the trace: " + absent[0] + "; see profile.cpp");
        for (size_t i = 0; i < frames.size(); i++)
        {
            const Profile profile = profileOf(frames[i]);
            for (int stage = 0; stage < STAGE_COUNT; stage++)
                times.add(i, "stage", nameOf(Stage(stage)), profile.stages[stage]);
        }
        recordTasks(image, settings, times);
    }
    return table;
}
