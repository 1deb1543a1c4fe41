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
#include "shared.hpp"

#include <pybind11/pybind11.h>

namespace aqorb_python
{

namespace py = pybind11;

//! Whether the object is an instance of a class of cv2. If nobody has imported cv2, there are none.
inline bool isInstance(py::handle object, const char* cv2Class)
{
    const py::object cv2 = importedModule("cv2");
    return cv2 && py::hasattr(cv2, cv2Class) && py::isinstance(object, cv2.attr(cv2Class));
}

template <typename Kind> struct Object
{
    py::object object;
};

// A kind is the name in signatures and, for the first argument, the choice between overloads: the first one that accepts
// it is called.
#define AQORB_ARGUMENT(Name, text, isAccepted)                     \
    struct Name##Kind                                              \
    {                                                              \
        static constexpr auto name = py::detail::const_name(text); \
        static bool accepts(py::handle object)                     \
        {                                                          \
            (void)object;                                          \
            return isAccepted;                                     \
        }                                                          \
    };                                                             \
    typedef Object<Name##Kind> Name##Object;
AQORB_ARGUMENT(Bool, "bool", true)
AQORB_ARGUMENT(Int, "int", true)
AQORB_ARGUMENT(Float, "float", true)
AQORB_ARGUMENT(Image, "Optional[numpy.ndarray]", !isSequence(object))
AQORB_ARGUMENT(Images, "Sequence[Optional[numpy.ndarray]]", isSequence(object))
AQORB_ARGUMENT(ImageList, "Sequence[Optional[numpy.ndarray]]", true)
AQORB_ARGUMENT(FeatureBatch, "FeatureBatch", true)
AQORB_ARGUMENT(Array, "numpy.ndarray", true)
AQORB_ARGUMENT(OptionalArray, "Optional[numpy.ndarray]", true)
AQORB_ARGUMENT(Masks, "Optional[Sequence[Optional[numpy.ndarray]]]", true)
AQORB_ARGUMENT(KeyPoints, "Union[Sequence[cv2.KeyPoint], numpy.ndarray]", true)
AQORB_ARGUMENT(KeyPointLists, "Sequence[Union[Sequence[cv2.KeyPoint], numpy.ndarray]]", true)
AQORB_ARGUMENT(KeyPointTuple, "Tuple[cv2.KeyPoint, ...]", true)
AQORB_ARGUMENT(ArrayTuple, "Tuple[numpy.ndarray, ...]", true)
AQORB_ARGUMENT(MatchTuple, "Tuple[cv2.DMatch, ...]", true)
AQORB_ARGUMENT(MatchLists, "Tuple[Tuple[cv2.DMatch, ...], ...]", true)
AQORB_ARGUMENT(Size, "Tuple[int, int]", true)
AQORB_ARGUMENT(OptionalInt, "Optional[int]", true)
AQORB_ARGUMENT(OptionalFloat, "Optional[float]", true)
AQORB_ARGUMENT(FloatPair, "Tuple[float, float]", true)
AQORB_ARGUMENT(FileStorage, "cv2.FileStorage", isInstance(object, "FileStorage"))
AQORB_ARGUMENT(FileNode, "cv2.FileNode", isInstance(object, "FileNode"))
AQORB_ARGUMENT(FileName, "Union[str, os.PathLike]", true)
#undef AQORB_ARGUMENT

//! Whether the object is an int, or converts to one without loss as those of numpy do, and has at most 32 bits.
bool isInt(py::handle object, int& value);

// The number that is passed as an argument of this name.
bool toNumber(const BoolObject& object, const char* name);
int toNumber(const IntObject& object, const char* name);
double toNumber(const FloatObject& object, const char* name);

//! What Python passes and gets for a property of the type. An enumeration is an int.
template <typename T> struct InPython
{
    typedef IntObject Argument;
    typedef int Result;
};
template <> struct InPython<double>
{
    typedef FloatObject Argument;
    typedef double Result;
};
template <> struct InPython<bool>
{
    typedef BoolObject Argument;
    typedef bool Result;
};

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
