// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#ifndef OPENCV_AQORB_PRECOMP_HPP
#define OPENCV_AQORB_PRECOMP_HPP

// Headers of OpenCV and the standard library only. Each source file includes the stages it uses, so a change in the
// header of one stage does not recompile the others.

#include <opencv2/core.hpp>
#include <opencv2/core/utility.hpp>
#include <opencv2/core/utils/trace.hpp>
#include <opencv2/imgproc.hpp>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <iterator>
#include <limits>
#include <memory>
#include <numeric>
#include <vector>

#if defined(_MSC_VER) && !defined(__clang__)
#pragma fp_contract(off)  // other compilers get an option from the build
#endif

#endif
