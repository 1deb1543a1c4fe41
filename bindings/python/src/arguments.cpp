// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "arguments.hpp"

#include "errors.hpp"

#include <pybind11/numpy.h>

#include <cstring>

namespace aqorb_python
{

bool isInt(py::handle object, int& value)
{
    py::detail::make_caster<int> number;
    if (!number.load(object, false))
        return false;
    value = number;
    return true;
}

int toNumber(const IntObject& object, const char* name)
{
    int value = 0;
    if (!isInt(object.object, value))
        throwTypeError(name, brief(object.object), "an int of 32 bits");
    return value;
}

double toNumber(const FloatObject& object, const char* name)
{
    // An array of one number would do, too.
    const double value = PySequence_Check(object.object.ptr()) ? -1 : PyFloat_AsDouble(object.object.ptr());
    if (PyErr_Occurred() || PySequence_Check(object.object.ptr()))
    {
        PyErr_Clear();
        throwTypeError(name, brief(object.object), "a float");
    }
    return value;
}

bool toNumber(const BoolObject& object, const char* name)
{
    int value = 0;
    const bool isOfNumpy = std::strncmp(Py_TYPE(object.object.ptr())->tp_name, "numpy.bool", 10) == 0;
    if (isOfNumpy)
        return PyObject_IsTrue(object.object.ptr()) == 1;
    if (!isInt(object.object, value))
        throwTypeError(name, brief(object.object), "a bool");
    return value != 0;
}

}  // namespace aqorb_python
