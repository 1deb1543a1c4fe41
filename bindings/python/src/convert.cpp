// This file is part of the aqorb project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.

#include "convert.hpp"

#include <climits>
#include <cstring>
#include <memory>
#include <string>

namespace aqorb_python
{

namespace
{

[[noreturn]] void reject(const char* name, const py::array& array, const char* accepted)
{
    const std::string dtype = py::str(array.dtype()), shape = py::str(array.attr("shape"));
    CV_Error_(cv::Error::StsBadArg, ("%s: got an array of dtype %s and shape %s; %s is accepted", name,
                                     dtype.c_str(), shape.c_str(), accepted));
}

bool isUint8(const py::array& array)
{
    return array.itemsize() == 1 && array.dtype().kind() == 'u';
}

// A Mat's rows may lie apart, its pixels and channels not.
bool hasStridesOfMat(const py::array& array, int channels)
{
    const py::ssize_t rows = array.shape(0), cols = array.shape(1);
    return (channels == 1 || array.strides(2) == 1) && (cols == 1 || array.strides(1) == channels) &&
           (rows == 1 || array.strides(0) >= cols * channels);
}

// The array's pixels, which owner keeps alive: the array's own or, where a Mat cannot have its strides, a copy's.
cv::Mat toMat(py::array array, int channels, py::object& owner)
{
    if (array.size() == 0)
        return cv::Mat();
    if (!hasStridesOfMat(array, channels))
    {
        array = py::array::ensure(array, py::array::c_style);
        if (!array)
            throw py::error_already_set();
    }
    owner = array;
    const size_t step = array.shape(0) == 1 ? size_t(cv::Mat::AUTO_STEP) : size_t(array.strides(0));
    return cv::Mat(int(array.shape(0)), int(array.shape(1)), CV_8UC(channels),
                   const_cast<void*>(array.data()), step);
}

bool isImageSize(const py::array& array)
{
    return array.shape(0) <= INT_MAX && array.shape(1) <= INT_MAX;
}

// The attributes of cv2.KeyPoint and the class itself; never released, as the interpreter may be gone by then.
struct KeyPointType
{
    PyObject *type, *pt, *size, *angle, *response, *octave, *class_id;

    KeyPointType()
        : type(py::object(py::module_::import("cv2").attr("KeyPoint")).release().ptr()),
          pt(PyUnicode_InternFromString("pt")),
          size(PyUnicode_InternFromString("size")),
          angle(PyUnicode_InternFromString("angle")),
          response(PyUnicode_InternFromString("response")),
          octave(PyUnicode_InternFromString("octave")),
          class_id(PyUnicode_InternFromString("class_id"))
    {
    }
    static const KeyPointType& get()
    {
        static const KeyPointType instance;
        return instance;
    }
};

py::object attribute(PyObject* object, PyObject* name)
{
    PyObject* value = PyObject_GetAttr(object, name);
    if (!value)
        throw py::error_already_set();
    return py::reinterpret_steal<py::object>(value);
}

float floatAttribute(PyObject* object, PyObject* name)
{
    return float(PyFloat_AsDouble(attribute(object, name).ptr()));
}

int intAttribute(PyObject* object, PyObject* name)
{
    return int(PyLong_AsLong(attribute(object, name).ptr()));
}

cv::KeyPoint fromPython(PyObject* object)
{
    const KeyPointType& names = KeyPointType::get();
    const py::tuple pt = attribute(object, names.pt);
    return cv::KeyPoint(float(PyFloat_AsDouble(PyTuple_GET_ITEM(pt.ptr(), 0))),
                        float(PyFloat_AsDouble(PyTuple_GET_ITEM(pt.ptr(), 1))),
                        floatAttribute(object, names.size), floatAttribute(object, names.angle),
                        floatAttribute(object, names.response), intAttribute(object, names.octave),
                        intAttribute(object, names.class_id));
}

py::object toPython(const cv::KeyPoint& keypoint)
{
    return py::handle(KeyPointType::get().type)(keypoint.pt.x, keypoint.pt.y, keypoint.size, keypoint.angle,
                                                keypoint.response, keypoint.octave, keypoint.class_id);
}

}  // namespace

bool load(py::handle source, Image& image)
{
    if (source.is_none())
        return true;
    if (!py::isinstance<py::array>(source))
        return false;
    const py::array array = py::reinterpret_borrow<py::array>(source);
    const py::ssize_t dims = array.ndim(), channels = dims == 3 ? array.shape(2) : 1;
    const bool isShape = dims == 2 || (dims == 3 && (channels == 1 || channels == 3 || channels == 4));
    if (!isUint8(array) || !isShape || !isImageSize(array))
        reject("image", array,
               "uint8 of shape (rows, cols) or (rows, cols, channels) with 1 (grey), 3 (BGR) or 4 (BGRA)");
    image.mat = toMat(array, int(channels), image.owner);
    return true;
}

bool load(py::handle source, Mask& mask)
{
    if (source.is_none())
        return true;
    if (!py::isinstance<py::array>(source))
        return false;
    const py::array array = py::reinterpret_borrow<py::array>(source);
    const bool isShape = array.ndim() == 2 || (array.ndim() == 3 && array.shape(2) == 1);
    if (!(isUint8(array) || array.dtype().kind() == 'b') || !isShape || !isImageSize(array))
        reject("mask", array, "uint8 or bool of the image's shape (rows, cols)");
    mask.mat = toMat(array, 1, mask.owner);
    return true;
}

bool load(py::handle source, KeyPoints& keypoints)
{
    std::vector<cv::KeyPoint>& points = keypoints.points;
    if (py::isinstance<py::array>(source))
    {
        py::array array = py::reinterpret_borrow<py::array>(source);
        if (array.ndim() != 1 || !array.dtype().equal(keypointDtype()))
            reject("keypoints", array, "a sequence of cv2.KeyPoint or an array of aqorb.keypoint_dtype");
        array = py::array::ensure(array, py::array::c_style);
        if (!array)
            throw py::error_already_set();
        points.resize(size_t(array.size()));
        if (!points.empty())
            std::memcpy(static_cast<void*>(points.data()), array.data(), points.size() * sizeof(points[0]));
        keypoints.isArray = true;
        return true;
    }
    if (!PySequence_Check(source.ptr()))
        return false;
    const auto items =
        py::reinterpret_steal<py::object>(PySequence_Fast(source.ptr(), "keypoints: no sequence"));
    if (!items)
        throw py::error_already_set();
    const py::handle type = KeyPointType::get().type;
    points.reserve(size_t(PySequence_Fast_GET_SIZE(items.ptr())));
    for (py::ssize_t i = 0; i < PySequence_Fast_GET_SIZE(items.ptr()); i++)
    {
        PyObject* const item = PySequence_Fast_GET_ITEM(items.ptr(), i);
        if (!py::isinstance(item, type))
            return false;
        points.push_back(fromPython(item));
    }
    if (PyErr_Occurred())
        throw py::error_already_set();
    return true;
}

py::dtype keypointDtype()
{
    // Never released, as the interpreter may be gone by then.
    static const py::handle dtype = []
    {
        static_assert(sizeof(cv::KeyPoint) == 5 * sizeof(float) + 2 * sizeof(int),
                      "an array's item is a KeyPoint");
        py::list fields;
        fields.append(py::make_tuple("pt", "f4", 2));
        for (const char* name : {"size", "angle", "response"})
            fields.append(py::make_tuple(name, "f4"));
        for (const char* name : {"octave", "class_id"})
            fields.append(py::make_tuple(name, "i4"));
        return py::dtype::from_args(fields).release();
    }();
    return py::reinterpret_borrow<py::dtype>(dtype);
}

py::object toTuple(const std::vector<cv::KeyPoint>& keypoints)
{
    py::tuple result(keypoints.size());
    for (size_t i = 0; i < keypoints.size(); i++)
        PyTuple_SET_ITEM(result.ptr(), py::ssize_t(i), toPython(keypoints[i]).release().ptr());
    return std::move(result);
}

py::object toArray(std::vector<cv::KeyPoint>&& keypoints)
{
    typedef std::vector<cv::KeyPoint> Vector;
    std::unique_ptr<Vector> kept(new Vector(std::move(keypoints)));
    const Vector& points = *kept;
    const py::capsule owner(kept.get(), [](void* vector) { delete static_cast<Vector*>(vector); });
    kept.release();
    return py::array(keypointDtype(), {points.size()}, {sizeof(cv::KeyPoint)}, points.data(), owner);
}

py::object toArray(const cv::Mat& rows)
{
    std::unique_ptr<cv::Mat> kept(new cv::Mat(rows));
    const py::capsule owner(kept.get(), [](void* mat) { delete static_cast<cv::Mat*>(mat); });
    kept.release();
    return py::array(py::dtype::of<uchar>(), {rows.rows, rows.cols}, {rows.step[0], rows.step[1]}, rows.data,
                     owner);
}

}  // namespace aqorb_python
