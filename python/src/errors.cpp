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

// Messages may hold a file name, which need not be UTF-8.
py::object toText(const std::string& bytes)
{
    return py::reinterpret_steal<py::object>(
        PyUnicode_DecodeUTF8(bytes.data(), py::ssize_t(bytes.size()), "backslashreplace"));
}

}  // namespace

py::object classOfCv2(const char* name, const char* instead)
{
    return py::module_::import("aqorb._cv2").attr("named")(name, instead);
}

py::object knownClass(const char* name)
{
    const auto cv2 = py::reinterpret_steal<py::object>(PyImport_GetModule(py::str("cv2").ptr()));
    if (PyErr_Occurred())
        throw py::error_already_set();
    return cv2 ? py::getattr(cv2, name, py::handle()) : py::object();
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
                // err instead of what(), whose version and source line belong to the package's OpenCV, not to cv2's.
                const py::object type =
                    py::module_::import("aqorb._cv2")
                        .attr(exception.code == cv::Error::StsNoMem ? "memory_error" : "error");
                const py::object error = type(toText(exception.err));
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
    return py::str(py::module_::import("reprlib").attr("repr")(object));
}

}  // namespace aqorb_python
