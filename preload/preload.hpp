// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#ifndef OPENCV_AQORB_PRELOAD_HPP
#define OPENCV_AQORB_PRELOAD_HPP

// Shared by the definitions that replace OpenCV's.

namespace aqorb_preload
{

//! Whether an environment variable is 1. Throws if it is anything but 0, 1 or empty.
bool isVariableOn(const char* name);

//! OpenCV's definition of the function with the symbol of ours. Throws if there is none.
void* originalOf(void* ours, const char* name);

template <typename Function> Function* originalOf(Function* ours, const char* name)
{
    return reinterpret_cast<Function*>(originalOf(reinterpret_cast<void*>(ours), name));
}

}  // namespace aqorb_preload

#endif
