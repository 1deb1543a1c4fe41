// This file is part of the aqorb project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.

#ifndef OPENCV_AQORB_PERF_PRECOMP_HPP
#define OPENCV_AQORB_PERF_PRECOMP_HPP

#include "opencv2/ts.hpp"
#include "opencv2/aqorb.hpp"

#endif
