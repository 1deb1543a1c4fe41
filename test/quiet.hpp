// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#ifndef OPENCV_AQORB_TEST_QUIET_HPP
#define OPENCV_AQORB_TEST_QUIET_HPP

#include <opencv2/core/utility.hpp>
#include <opencv2/core/utils/logger.hpp>

namespace opencv_test
{

//! Keeps OpenCV from printing the messages of exceptions until it goes out of scope, where thousands are expected.
class Quiet
{
public:
    Quiet() : before(cv::utils::logging::setLogLevel(cv::utils::logging::LOG_LEVEL_SILENT))
    {
        cv::redirectError([](int, const char*, const char*, const char*, int, void*) { return 0; });
    }
    ~Quiet()
    {
        cv::redirectError(0);
        cv::utils::logging::setLogLevel(before);
    }

private:
    const cv::utils::logging::LogLevel before;
};

}  // namespace opencv_test

#endif
