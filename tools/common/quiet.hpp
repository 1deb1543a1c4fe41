// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#ifndef AQORB_TOOLS_QUIET_HPP
#define AQORB_TOOLS_QUIET_HPP

#include <opencv2/core/utility.hpp>
#include <opencv2/core/utils/logger.hpp>

namespace tools
{

//! Keeps OpenCV from printing the messages of exceptions: a program that provokes them expects them.
inline void silenceOpenCV()
{
    cv::utils::logging::setLogLevel(cv::utils::logging::LOG_LEVEL_SILENT);
    cv::redirectError([](int, const char*, const char*, const char*, int, void*) { return 0; });
}

}  // namespace tools

#endif
