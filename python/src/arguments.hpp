// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// Arguments and results of the module's functions: plain Python objects with a type name for the signatures in the
// docstrings. Each function converts its arguments itself, so that its message names the invalid parameter. pybind11
// would try the next overload instead.

#ifndef AQORB_PYTHON_ARGUMENTS_HPP
#define AQORB_PYTHON_ARGUMENTS_HPP

#include "errors.hpp"
#include "arrays.hpp"

#include <pybind11/pybind11.h>

#include <type_traits>

namespace aqorb_python
{

namespace py = pybind11;

//! Parts of the module: each adds names with signatures and docstrings.
void addDetector(py::module_& module);
void addMatching(py::module_& module);
void addRefinement(py::module_& module);

//! Docstring of a function in the package's stub, of the n-th one of this name.
const char* doc(const char* name, int n = 0);

//! Whether the object is an instance of a class of cv2.
inline bool isInstance(py::handle object, const char* cv2Class)
{
    const py::object type = knownClass(cv2Class);
    return type && py::isinstance(object, type);
}

//! Replaces an integer of Python or numpy by an int. Returns false for other objects, which pybind11 would convert.
//! An error of the object's own __index__ is that of the call.
inline bool toInteger(py::object& object)
{
    object = py::reinterpret_steal<py::object>(PyNumber_Index(object.ptr()));
    if (object)
        return true;
    if (!PyErr_ExceptionMatches(PyExc_TypeError))
        throw py::error_already_set();
    PyErr_Clear();
    return false;
}

template <typename Kind> struct Object
{
    py::object object;
};

// A kind of argument: its name in signatures and, for the first argument, the choice of the overload. pybind11 calls
// the first overload that accepts the object.
#define AQORB_ARGUMENT(Name, text, isAccepted)                     \
    struct Name##Kind                                              \
    {                                                              \
        static constexpr auto name = py::detail::const_name(text); \
        static bool accepts(py::object& object)                    \
        {                                                          \
            (void)object;                                          \
            return isAccepted;                                     \
        }                                                          \
    };                                                             \
    typedef Object<Name##Kind> Name##Object;
AQORB_ARGUMENT(Image, "Optional[numpy.ndarray]", !isSequence(object))
AQORB_ARGUMENT(Images, "Sequence[Optional[numpy.ndarray]]", isSequence(object))
AQORB_ARGUMENT(ImageList, "Sequence[Optional[numpy.ndarray]]", true)
AQORB_ARGUMENT(Array, "numpy.ndarray", true)
AQORB_ARGUMENT(OptionalArray, "Optional[numpy.ndarray]", true)
AQORB_ARGUMENT(Masks, "Optional[Sequence[Optional[numpy.ndarray]]]", true)
AQORB_ARGUMENT(KeyPoints, "Union[Sequence[cv2.KeyPoint], numpy.ndarray]", true)
AQORB_ARGUMENT(KeyPointLists, "Sequence[Union[Sequence[cv2.KeyPoint], numpy.ndarray]]", true)
AQORB_ARGUMENT(KeyPointTuple, "Tuple[cv2.KeyPoint, ...]", true)
AQORB_ARGUMENT(ArrayTuple, "Tuple[numpy.ndarray, ...]", true)
AQORB_ARGUMENT(Matches, "Sequence[cv2.DMatch]", true)
AQORB_ARGUMENT(MatchTuple, "Tuple[cv2.DMatch, ...]", true)
AQORB_ARGUMENT(MatchLists, "Tuple[Tuple[cv2.DMatch, ...], ...]", true)
AQORB_ARGUMENT(Int, "int", toInteger(object))
AQORB_ARGUMENT(OptionalInt, "Optional[int]", true)
AQORB_ARGUMENT(OptionalFloat, "Optional[float]", true)
AQORB_ARGUMENT(FileStorage, "cv2.FileStorage", isInstance(object, "FileStorage"))
AQORB_ARGUMENT(FileNode, "cv2.FileNode", isInstance(object, "FileNode"))
AQORB_ARGUMENT(FileName, "Union[str, os.PathLike]", true)
#undef AQORB_ARGUMENT

//! Type of a property in Python. An enumeration is an int.
template <typename T> using InPython = typename std::conditional<std::is_enum<T>::value, int, T>::type;

//! Argument type of a property's setter.
template <typename T>
using Given = typename std::conditional<std::is_same<InPython<T>, int>::value, IntObject, T>::type;

//! Value of a number.
//! @param name parameter name for messages
int valueOf(const IntObject& number, const std::string& name);
template <typename T> T valueOf(T number, const std::string&)
{
    return number;
}

}  // namespace aqorb_python

namespace pybind11
{
namespace detail
{

template <typename Kind> struct type_caster<aqorb_python::Object<Kind>>
{
    PYBIND11_TYPE_CASTER(aqorb_python::Object<Kind>, Kind::name);
    bool load(handle source, bool)
    {
        value.object = reinterpret_borrow<object>(source);
        return Kind::accepts(value.object);
    }
    static handle cast(const aqorb_python::Object<Kind>& result, return_value_policy, handle)
    {
        return object(result.object).release();
    }
};

}  // namespace detail
}  // namespace pybind11

#endif
