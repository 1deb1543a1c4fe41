// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "recorded_frame.hpp"

#include "frame.hpp"

#include <opencv2/core/utility.hpp>

using namespace cv;
using namespace cv::aqorb;

namespace
{

double nanosecondsSince(int64 start)
{
    return double(getTickCount() - start) * 1e9 / getTickFrequency();
}

class RecordedFrame : public Frame
{
public:
    RecordedFrame(const Parameters& parameters_, const Tables& tables_, Workspace& workspace_)
        : Frame(parameters_, tables_, workspace_)
    {
    }

    std::vector<DoneTask> done() const
    {
        std::vector<DoneTask> result;
        for (size_t i = 0; i < records.size(); i++)
        {
            result.push_back({records[i].duration, {}});
            for (size_t j = 0; j < i; j++)
                if (isInput(records[j].task, records[i].task))
                    result.back().inputs.push_back(j);
        }
        return result;
    }

private:
    struct Record
    {
        Task task;
        double duration;
    };

    void run(const Task& task, int worker) CV_OVERRIDE
    {
        const int64 start = getTickCount();
        Frame::run(task, worker);
        records.push_back({task, nanosecondsSince(start)});
    }

    //! Whether a task needs what another one makes, in an image without a mask: the table in frame.hpp.
    static bool isInput(const Task& input, const Task& task)
    {
        const bool isSameLevel = input.level == task.level;
        switch (task.kind)
        {
        case MEASURE:
            return false;
        case MAKE:
            return input.kind == MAKE && input.level + 1 == task.level;
        case SEARCH:
            return input.kind == MEASURE || (input.kind == MAKE && isSameLevel);
        case ORDER:
            return input.kind == SEARCH && isSameLevel;
        case SELECT:
            return input.kind == MEASURE || ((input.kind == MAKE || input.kind == ORDER) && isSameLevel) ||
                   (input.kind == SELECT && input.level == task.level + 1);
        default:  // what fills up is selected with the finest level
            return input.kind == SELECT && input.level == (task.part % 2 == 0 ? task.level : 0);
        }
    }

    std::vector<Record> records;
};

Parameters parametersOf(int nfeatures)
{
    Parameters parameters;
    parameters.nfeatures = nfeatures;
    return parameters;
}

}  // namespace

struct FrameRecorder::Impl
{
    Impl(int threads_, int nfeatures)
        : threads(threads_), parameters(parametersOf(nfeatures)), tables(parameters)
    {
    }

    const int threads;
    const Parameters parameters;
    const Tables tables;
    Workspace workspace;
    std::vector<KeyPoint> keypoints;
    Mat descriptors;
};

FrameRecorder::FrameRecorder(int threads, int nfeatures) : impl(new Impl(threads, nfeatures))
{
}

FrameRecorder::~FrameRecorder()
{
}

RecordedTasks FrameRecorder::record(const Mat& image)
{
    RecordedTasks result;
    const auto body = [&](const Range&)
    {
        const int64 start = getTickCount();
        stages::Level input;
        input.image = image;
        const InputScope scope(impl->workspace, input);
        RecordedFrame frame(impl->parameters, impl->tables, impl->workspace);
        frame.detect(true);
        impl->descriptors.create(int(frame.count()), 32, CV_8UC1);
        frame.output(impl->keypoints, impl->descriptors);
        result.frame = nanosecondsSince(start);
        result.tasks = frame.done();
    };
    const int threads = getNumThreads();
    setNumThreads(impl->threads);
    parallel_for_(Range(0, 1), body);  // inside of which parallel_for_ takes this thread alone
    setNumThreads(threads);
    return result;
}
