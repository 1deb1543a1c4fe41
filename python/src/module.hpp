// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// Parts of the module: each adds names with signatures and docstrings.

#ifndef AQORB_PYTHON_MODULE_HPP
#define AQORB_PYTHON_MODULE_HPP

#include <pybind11/pybind11.h>

namespace aqorb_python
{

void addDetector(pybind11::module_& module);
void addMatching(pybind11::module_& module);
void addRefinement(pybind11::module_& module);

}  // namespace aqorb_python

#endif
