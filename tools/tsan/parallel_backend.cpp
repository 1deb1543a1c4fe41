// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// Part of the tests where they are built for the thread sanitizer: runs cv::parallel_for_ on std::thread.
// OpenCV's own pools hand work over by means that the sanitizer cannot see in a library that is not
// instrumented, and so takes for races.

#include "../../test/backends.hpp"

namespace
{

const struct Installer
{
    Installer() { cv::parallel::setParallelForBackend(std::make_shared<opencv_test::NewThreads>(), false); }
} installer;

}  // namespace
