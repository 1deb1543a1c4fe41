// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// The arguments and results of the module's functions. They are plain Python objects with a name for the signatures in
// the docstrings, so that a function converts them itself and its message names the parameter that is wrong: pybind11
// would try the next overload instead.

#ifndef AQORB_PYTHON_ARGUMENTS_HPP
#define AQORB_PYTHON_ARGUMENTS_HPP

#include "images.hpp"

#include <pybind11/pybind11.h>

namespace aqorb_python
{

namespace py = pybind11;

//! Whether the object is an instance of a class of cv2. If nobody has imported cv2, there are none.
inline bool isInstance(py::handle object, const char* cv2Class)
{
    PyObject* const cv2 = PyDict_GetItemString(PyImport_GetModuleDict(), "cv2");
    return cv2 && py::hasattr(cv2, cv2Class) && py::isinstance(object, py::handle(cv2).attr(cv2Class));
}

// A kind is the name in signatures and, for the first argument, the choice between overloads. The first overload that
// accepts it is called.
struct Anything
{
    static bool accepts(py::handle) { return true; }
};

struct ImageKind
{
    static constexpr auto name = py::detail::const_name("Optional[numpy.ndarray]");
    static bool accepts(py::handle object) { return !isSequence(object); }
};

struct ImagesKind
{
    static constexpr auto name = py::detail::const_name("Sequence[Optional[numpy.ndarray]]");
    static bool accepts(py::handle object) { return isSequence(object); }
};

struct ArrayKind : Anything
{
    static constexpr auto name = py::detail::const_name("numpy.ndarray");
};

struct OptionalArrayKind : Anything
{
    static constexpr auto name = py::detail::const_name("Optional[numpy.ndarray]");
};

struct MasksKind : Anything
{
    static constexpr auto name = py::detail::const_name("Optional[Sequence[Optional[numpy.ndarray]]]");
};

struct KeyPointsKind : Anything
{
    static constexpr auto name = py::detail::const_name("Union[Sequence[cv2.KeyPoint], numpy.ndarray]");
};

struct KeyPointListsKind : Anything
{
    static constexpr auto name =
        py::detail::const_name("Sequence[Union[Sequence[cv2.KeyPoint], numpy.ndarray]]");
};

struct KeyPointTupleKind : Anything
{
    static constexpr auto name = py::detail::const_name("Tuple[cv2.KeyPoint, ...]");
};

struct ArrayTupleKind : Anything
{
    static constexpr auto name = py::detail::const_name("Tuple[numpy.ndarray, ...]");
};

struct SizeKind : Anything
{
    static constexpr auto name = py::detail::const_name("Tuple[int, int]");
};

struct FileStorageKind
{
    static constexpr auto name = py::detail::const_name("cv2.FileStorage");
    static bool accepts(py::handle object) { return isInstance(object, "FileStorage"); }
};

struct FileNodeKind
{
    static constexpr auto name = py::detail::const_name("cv2.FileNode");
    static bool accepts(py::handle object) { return isInstance(object, "FileNode"); }
};

struct FileNameKind : Anything
{
    static constexpr auto name = py::detail::const_name("Union[str, os.PathLike]");
};

template <typename Kind> struct Object
{
    py::object object;
};

typedef Object<ImageKind> ImageObject;
typedef Object<ImagesKind> ImagesObject;
typedef Object<ArrayKind> ArrayObject;
typedef Object<OptionalArrayKind> OptionalArrayObject;
typedef Object<MasksKind> MasksObject;
typedef Object<KeyPointsKind> KeyPointsObject;
typedef Object<KeyPointListsKind> KeyPointListsObject;
typedef Object<KeyPointTupleKind> KeyPointTupleObject;
typedef Object<ArrayTupleKind> ArrayTupleObject;
typedef Object<SizeKind> SizeObject;
typedef Object<FileStorageKind> FileStorageObject;
typedef Object<FileNodeKind> FileNodeObject;
typedef Object<FileNameKind> FileNameObject;

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
        return Kind::accepts(source);
    }
    static handle cast(const aqorb_python::Object<Kind>& result, return_value_policy, handle)
    {
        return object(result.object).release();
    }
};

}  // namespace detail
}  // namespace pybind11

#endif
