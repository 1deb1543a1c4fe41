// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#ifndef OPENCV_AQORB_PERF_PRECOMP_HPP
#define OPENCV_AQORB_PERF_PRECOMP_HPP

#include "opencv2/ts.hpp"
#include "opencv2/aqorb.hpp"

#endif
