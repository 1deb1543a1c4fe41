// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// Runs cv::parallel_for_ on std::thread in tests built for the thread sanitizer. OpenCV's library is not instrumented,
// so the sanitizer cannot see how OpenCV's own pools hand over work, and would report races.

#include "../../test/backends.hpp"

namespace
{

const struct Installer
{
    Installer() { cv::parallel::setParallelForBackend(std::make_shared<opencv_test::NewThreads>(), false); }
} installer;

}  // namespace
