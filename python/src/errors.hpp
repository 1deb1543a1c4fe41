// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// Errors of a call: aqorb.error for an invalid value, TypeError for an object of a wrong type. Both messages name the
// parameter, the argument and the accepted values.

#ifndef AQORB_PYTHON_ERRORS_HPP
#define AQORB_PYTHON_ERRORS_HPP

#include <pybind11/numpy.h>

#include <string>

namespace aqorb_python
{

namespace py = pybind11;

//! Class of cv2. Without cv2 throws an ImportError that names the function to call instead.
py::object classOfCv2(const char* name, const char* instead);

//! Class of cv2, or nothing if nobody has imported cv2: then no objects of the class exist.
py::object knownClass(const char* name);

//! Translates OpenCV's exceptions to aqorb.error. Called once, at import.
void translateErrors();

//! Throws TypeError for an object of a wrong type.
[[noreturn]] void throwTypeError(const std::string& name, const std::string& given,
                                 const std::string& accepted);

//! Throws aqorb.error for an array of another dtype or shape.
[[noreturn]] void rejectArray(const std::string& name, const py::array& array, const char* accepted);

//! Shortened representation of an object for messages.
std::string brief(py::handle object);

}  // namespace aqorb_python

#endif
