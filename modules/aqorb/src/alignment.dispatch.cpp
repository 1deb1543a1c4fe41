// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "precomp.hpp"

#include "alignment.hpp"

#include "alignment.simd.hpp"
#include "alignment.simd_declarations.hpp"

namespace cv
{
namespace aqorb
{

void alignPatches(const LevelPatches* patches, int count, LevelAlignment* alignments)
{
    CV_TRACE_FUNCTION();
    CV_CPU_DISPATCH(alignByLanes, (patches, count, alignments), CV_CPU_DISPATCH_MODES_ALL);
}

}  // namespace aqorb
}  // namespace cv
