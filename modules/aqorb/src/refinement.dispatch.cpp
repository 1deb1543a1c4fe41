// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// The alignment of patches on the kernels of this CPU.

#include "precomp.hpp"

#include "refinement.hpp"

#include "refinement.simd.hpp"
#include "refinement.simd_declarations.hpp"

namespace cv
{
namespace aqorb
{

void alignPatches(const PatchPair* pairs, int count, Alignment* alignments)
{
    CV_TRACE_FUNCTION();
    CV_CPU_DISPATCH(alignByLanes, (pairs, count, alignments), CV_CPU_DISPATCH_MODES_ALL);
}

}  // namespace aqorb
}  // namespace cv
