// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "precomp.hpp"

#include "hamming.hpp"

#include "hamming.simd.hpp"
#include "hamming.simd_declarations.hpp"

// Whoever disables AVX512-SKX by OPENCV_CPU_DISABLE means what builds on it, too. Pairs of bits have no kernel there.
#if CV_TRY_AVX512_ICL && !CV_CPU_FORCE_AVX512_ICL
#undef CV_CPU_HAS_SUPPORT_AVX512_ICL
#define CV_CPU_HAS_SUPPORT_AVX512_ICL                              \
    (!countPairs && cv::checkHardwareSupport(CV_CPU_AVX512_ICL) && \
     cv::checkHardwareSupport(CV_CPU_AVX512_SKX))
#endif

namespace cv
{
namespace aqorb
{

static const HammingKernels* dispatchedKernels(bool countPairs, int bytes)
{
    CV_CPU_DISPATCH(kernelsFor, (countPairs, bytes), CV_CPU_DISPATCH_MODES_ALL);
}

const HammingKernels& hammingKernels(bool countPairs, int bytes)
{
    return *dispatchedKernels(countPairs, bytes);
}

}  // namespace aqorb
}  // namespace cv
