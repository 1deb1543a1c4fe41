// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// How a call that is refused ends: aqorb.error for a value, TypeError for an object of a wrong type. Either message
// names the parameter, what was given and what is accepted.

#ifndef AQORB_PYTHON_ERRORS_HPP
#define AQORB_PYTHON_ERRORS_HPP

#include <pybind11/numpy.h>

#include <string>

namespace aqorb_python
{

namespace py = pybind11;

//! A class of cv2, or an ImportError that says what to call instead.
py::object classOfCv2(const char* name, const char* instead);

//! A class of cv2, or nothing if nobody has imported cv2: then there are no such objects.
py::object knownClass(const char* name);

//! Makes OpenCV's exceptions such errors. To be called once, at import.
void translateErrors();

//! For a number, an object or a sequence that is no such thing.
[[noreturn]] void throwTypeError(const std::string& name, const std::string& given,
                                 const std::string& accepted);

//! For an array of another dtype or shape.
[[noreturn]] void rejectArray(const std::string& name, const py::array& array, const char* accepted);

//! What was given, shortened.
std::string brief(py::handle object);

}  // namespace aqorb_python

#endif
