// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "calls.hpp"

#include <opencv2/core/ocl.hpp>
#include <opencv2/core/utility.hpp>

#include <cstdio>
#include <cstdlib>

// Makes any call with any arguments. Whatever happens that is not documented is a find.

extern "C" int LLVMFuzzerInitialize(int*, char***);
extern "C" int LLVMFuzzerTestOneInput(const uint8_t* bytes, size_t size);

extern "C" int LLVMFuzzerInitialize(int*, char***)
{
    cv::setNumThreads(1);
    cv::ocl::setUseOpenCL(false);
    return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* bytes, size_t size)
{
    const fuzz::Report report = fuzz::callDetector(bytes, size, false);
    if (report.outcome > fuzz::NAMED_EXCEPTION)
    {
        std::fprintf(stderr, "find: %s\n", report.problem.c_str());
        std::abort();
    }
    return 0;
}
