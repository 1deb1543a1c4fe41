// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#ifndef OPENCV_AQORB_PERF_STREAM_HPP
#define OPENCV_AQORB_PERF_STREAM_HPP

#include <opencv2/core.hpp>

#include <vector>

// What stands between two calls of a detector in a program: other frames, and other work.

namespace opencv_test
{

//! Memory that has nothing to do with the detector. To touch it drives what the detector used out of the caches.
class OtherMemory
{
public:
    explicit OtherMemory(size_t megabytes) : words((megabytes << 20) / sizeof(uint64)) {}
    //! Reads and writes each cache line.
    void touch()
    {
        for (size_t i = 0; i < words.size(); i += 64 / sizeof(uint64))
            words[i]++;
    }

private:
    std::vector<uint64> words;
};

const int STREAM_FRAMES = 8;
const size_t STREAM_WORK = 16;  //!< megabytes of other memory that are touched between two frames

//! Frames of a camera that pans over an image, each in memory of its own.
inline std::vector<cv::Mat> panFrames(const cv::Mat& image)
{
    const int STEP = 4;  // pixels between two frames
    const cv::Size size = image.size() - cv::Size(STEP, STEP) * (STREAM_FRAMES - 1);
    std::vector<cv::Mat> frames;
    for (int i = 0; i < STREAM_FRAMES; i++)
        frames.push_back(image(cv::Rect(cv::Point(STEP, STEP) * i, size)).clone());
    return frames;
}

}  // namespace opencv_test

#endif
