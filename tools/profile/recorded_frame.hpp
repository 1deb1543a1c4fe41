// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#ifndef AQORB_PROFILE_RECORDED_FRAME_HPP
#define AQORB_PROFILE_RECORDED_FRAME_HPP

#include "critical_path.hpp"

#include <opencv2/core.hpp>

#include <memory>

//! The tasks of a frame as one thread does them.
struct RecordedTasks
{
    double frame;                 //!< time of the whole frame, in ns
    std::vector<DoneTask> tasks;  //!< in ns
};

//! Does frames with default parameters and records their tasks. Memory is kept from frame to frame.
class FrameRecorder
{
public:
    //! @param threads for which the frame is divided into tasks; a single thread does them
    FrameRecorder(int threads, int nfeatures);
    ~FrameRecorder();
    RecordedTasks record(const cv::Mat& image);

private:
    struct Impl;
    std::unique_ptr<Impl> impl;
};

#endif
