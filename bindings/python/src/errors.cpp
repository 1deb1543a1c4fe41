// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "errors.hpp"

#include <opencv2/core.hpp>

namespace aqorb_python
{

namespace
{

PyObject* errorType = nullptr;

// Messages may hold a file name, which need not be UTF-8.
py::object toText(const std::string& bytes)
{
    return py::reinterpret_steal<py::object>(
        PyUnicode_DecodeUTF8(bytes.data(), py::ssize_t(bytes.size()), "backslashreplace"));
}

}  // namespace

void addErrorType(py::module_& module)
{
    const py::tuple bases =
        py::make_tuple(py::module_::import("cv2").attr("error"), py::handle(PyExc_ValueError));
    errorType = PyErr_NewExceptionWithDoc("aqorb.error",
                                          "The value of an argument is not accepted. The message names the "
                                          "argument. It is a cv2.error and a ValueError.",
                                          bases.ptr(), nullptr);
    if (!errorType)
        throw py::error_already_set();
    module.attr("error") = py::handle(errorType);
    py::register_local_exception_translator(
        [](std::exception_ptr pointer)
        {
            try
            {
                if (pointer)
                    std::rethrow_exception(pointer);
            }
            catch (const cv::Exception& exception)
            {
                const py::object error = py::handle(errorType)(toText(exception.what()));
                error.attr("code") = exception.code;
                error.attr("err") = toText(exception.err);
                error.attr("file") = toText(exception.file);
                error.attr("func") = toText(exception.func);
                error.attr("line") = exception.line;
                error.attr("msg") = toText(exception.msg);
                PyErr_SetObject(errorType, error.ptr());
            }
        });
}

void throwTypeError(const std::string& name, const std::string& given, const std::string& accepted)
{
    throw py::type_error(name + ": got " + given + "; " + accepted + " is accepted");
}

std::string brief(py::handle object)
{
    const py::ssize_t MAX_LENGTH = 60;
    PyObject* const ptr = object.ptr();
    if (object.is_none() || PyLong_Check(ptr) || PyFloat_Check(ptr) || PyUnicode_Check(ptr) ||
        PyBytes_Check(ptr) || PyTuple_Check(ptr))
    {
        const py::object text = py::reinterpret_steal<py::object>(PyObject_Repr(ptr));
        if (text && PyUnicode_GetLength(text.ptr()) <= MAX_LENGTH)
            return text.cast<std::string>();
        PyErr_Clear();  // the repr of an int of thousands of digits
    }
    return "an object of type " + std::string(Py_TYPE(ptr)->tp_name);
}

}  // namespace aqorb_python
