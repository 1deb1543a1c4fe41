// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// The matcher, and the functions that match, with arrays in place of objects.

#ifndef AQORB_PYTHON_MATCHER_HPP
#define AQORB_PYTHON_MATCHER_HPP

#include <pybind11/pybind11.h>

namespace aqorb_python
{

//! Adds the class HammingMatcher and the functions that match to the module.
void addMatching(pybind11::module_& module);

}  // namespace aqorb_python

#endif
