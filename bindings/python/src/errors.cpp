// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "errors.hpp"

#include "shared.hpp"

#include <opencv2/core.hpp>

namespace aqorb_python
{

namespace
{

Made<PyObject*> errorType;

// Messages may hold a file name, which need not be UTF-8.
py::object toText(const std::string& bytes)
{
    return py::reinterpret_steal<py::object>(
        PyUnicode_DecodeUTF8(bytes.data(), py::ssize_t(bytes.size()), "backslashreplace"));
}

}  // namespace

py::object errorClass()
{
    if (!errorType.get())
    {
        // Without cv2, or with one that does not work, it is a ValueError only.
        py::object cv2Error;
        try
        {
            cv2Error = py::module_::import("cv2").attr("error");
        }
        catch (const py::error_already_set& error)
        {
            if (!error.matches(PyExc_Exception))
                throw;
        }
        const py::handle valueError(PyExc_ValueError);
        py::tuple bases = py::make_tuple(valueError);
        if (cv2Error)
            bases = py::make_tuple(cv2Error, valueError);
        PyObject* const made =
            PyErr_NewExceptionWithDoc("aqorb.error",
                                      "The value of an argument is not accepted. The message names the "
                                      "argument. It is a ValueError and, where there is cv2, a cv2.error.",
                                      bases.ptr(), nullptr);
        if (!made)
            throw py::error_already_set();
        errorType.set(made);
    }
    return py::reinterpret_borrow<py::object>(*errorType.get());
}

py::object classOfCv2(const char* name, const std::string& instead)
{
    try
    {
        return py::module_::import("cv2").attr(name);
    }
    catch (py::error_already_set& error)
    {
        // A folder cv2 that is left of an old installation can be imported, and has no names.
        if (!error.matches(PyExc_ImportError) && !error.matches(PyExc_AttributeError))
            throw;
        const std::string message =
            "objects of cv2 are returned, which cannot be imported: install opencv-python or "
            "opencv-python-headless, or call " +
            instead;
        py::raise_from(error, PyExc_ImportError, message.c_str());
        throw py::error_already_set();
    }
}

void translateErrors()
{
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
                // Without OpenCV's version and place in what(), which are the package's own and not cv2's.
                const py::object type = errorClass(), error = type(toText(exception.err));
                error.attr("code") = exception.code;
                error.attr("err") = toText(exception.err);
                error.attr("file") = toText(exception.file);
                error.attr("func") = toText(exception.func);
                error.attr("line") = exception.line;
                error.attr("msg") = toText(exception.msg);
                PyErr_SetObject(type.ptr(), error.ptr());
            }
        });
}

void throwTypeError(const std::string& name, const std::string& given, const std::string& accepted)
{
    throw py::type_error(name + " must be " + accepted + ", got " + given);
}

void rejectArray(const std::string& name, const py::array& array, const char* accepted)
{
    const std::string dtype = py::str(array.dtype()), shape = py::str(array.attr("shape"));
    CV_Error_(cv::Error::StsBadArg, ("%s must be %s, got an array of dtype %s and shape %s", name.c_str(),
                                     accepted, dtype.c_str(), shape.c_str()));
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
