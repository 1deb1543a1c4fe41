// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "arrays.hpp"

#include "arguments.hpp"
#include "errors.hpp"

#include <pybind11/stl.h>

#include <climits>
#include <cstring>
#include <memory>
#include <utility>

namespace aqorb_python
{

namespace
{

bool isUint8(const py::array& array)
{
    return array.itemsize() == 1 && array.dtype().kind() == 'u';
}

bool isSizeOfMat(const py::array& array)
{
    return array.shape(0) <= INT_MAX && array.shape(1) <= INT_MAX;
}

// Whether a Mat can have the array's strides: rows may lie apart, pixels and channels may not.
bool hasStridesOfMat(const py::array& array, int channels)
{
    const py::ssize_t rows = array.shape(0), cols = array.shape(1);
    return (channels == 1 || array.strides(2) == 1) && (cols == 1 || array.strides(1) == channels) &&
           (rows == 1 || array.strides(0) >= cols * channels);
}

// The array if contiguous, else a contiguous copy. numpy throws if memory does not suffice.
py::array contiguous(const py::array& array)
{
    return py::module_::import("numpy").attr("ascontiguousarray")(array);
}

// A cv2.KeyPoint as OpenCV's generator of bindings declares it.
struct KeyPointObject
{
    PyObject_HEAD cv::KeyPoint value;
};

cv::KeyPoint& valueOf(const py::object& object)
{
    return reinterpret_cast<KeyPointObject*>(object.ptr())->value;
}

py::object construct(const py::object& type, const cv::KeyPoint& keypoint)
{
    return type(keypoint.pt.x, keypoint.pt.y, keypoint.size, keypoint.angle, keypoint.response,
                keypoint.octave, keypoint.class_id);
}

// The same as construct in a twentieth of the time, as OpenCV's bindings make what a function returns.
py::object copyInto(const py::object& type, const cv::KeyPoint& keypoint)
{
    PyTypeObject* const allocator = reinterpret_cast<PyTypeObject*>(type.ptr());
    const py::object object = py::reinterpret_steal<py::object>(allocator->tp_alloc(allocator, 0));
    if (!object)
        throw py::error_already_set();
    valueOf(object) = keypoint;
    return object;
}

// Whether objects of the class are KeyPointObjects and nothing more: one that was constructed has the bytes, and one
// that was copied the attributes.
bool canBeCopied(const py::object& type)
{
    PyTypeObject* const layout = reinterpret_cast<PyTypeObject*>(type.ptr());
    if (!PyType_Check(type.ptr()) || layout->tp_basicsize != sizeof(KeyPointObject) ||
        layout->tp_itemsize != 0 || PyType_IS_GC(layout))
        return false;
    const cv::KeyPoint known(1, 2, 3, 4, 5, 6, 7);
    const py::object constructed = construct(type, known);
    if (!constructed.get_type().is(type) || std::memcmp(&valueOf(constructed), &known, sizeof(known)) != 0)
        return false;
    const py::object copy = copyInto(type, known);
    return py::make_tuple(copy.attr("pt"), copy.attr("size"), copy.attr("angle"), copy.attr("response"),
                          copy.attr("octave"), copy.attr("class_id"))
        .equal(py::make_tuple(py::make_tuple(1, 2), 3, 4, 5, 6, 7));
}

Pixels toPixels(py::array array, int channels)
{
    Pixels pixels;
    if (array.size() == 0)
        return pixels;
    if (!hasStridesOfMat(array, channels))
        array = contiguous(array);
    const size_t step = array.shape(0) == 1 ? size_t(cv::Mat::AUTO_STEP) : size_t(array.strides(0));
    pixels.mat = cv::Mat(int(array.shape(0)), int(array.shape(1)), CV_8UC(channels),
                         const_cast<void*>(array.data()), step);
    pixels.owner = array;
    return pixels;
}

// An array, or a memoryview as an array with shared memory.
py::array arrayOf(py::handle source, const std::string& name, const char* accepted)
{
    if (!py::isinstance<py::array>(source) && !PyMemoryView_Check(source.ptr()))
        throwTypeError(name, brief(source), accepted);
    return py::module_::import("numpy").attr("asarray")(source);
}

const char ACCEPTED[] = "a sequence of cv2.KeyPoint or an array of aqorb.keypoint_dtype";

// Attribute names of a cv2.KeyPoint, as objects for faster look-up.
struct Names
{
    const py::str pt{"pt"}, size{"size"}, angle{"angle"}, response{"response"}, octave{"octave"},
        classId{"class_id"};
};

cv::KeyPoint toKeyPoint(py::handle object, const Names& names)
{
    const auto pt = object.attr(names.pt).cast<std::pair<float, float>>();
    return cv::KeyPoint(pt.first, pt.second, object.attr(names.size).cast<float>(),
                        object.attr(names.angle).cast<float>(), object.attr(names.response).cast<float>(),
                        object.attr(names.octave).cast<int>(), object.attr(names.classId).cast<int>());
}

// Whether the object is a one-dimensional array of objects, which cv2 accepts as a sequence.
bool isArrayOfObjects(py::handle source)
{
    if (!py::isinstance<py::array>(source))
        return false;
    const py::array array = py::reinterpret_borrow<py::array>(source);
    return array.dtype().kind() == 'O' && array.ndim() == 1;
}

std::vector<cv::KeyPoint> fromArray(const py::array& source, const std::string& name)
{
    if (source.ndim() != 1 || !source.dtype().equal(keypointDtype()))
        rejectArray(name, source, ACCEPTED);
    const py::array array = contiguous(source);
    std::vector<cv::KeyPoint> points(size_t(array.size()));
    if (!points.empty())
        std::memcpy(static_cast<void*>(points.data()), array.data(), points.size() * sizeof(points[0]));
    return points;
}

std::vector<cv::KeyPoint> fromSequence(py::handle source, const std::string& name)
{
    // A snapshot: another thread, or an attribute of an item, may change the list meanwhile.
    const py::tuple items(py::reinterpret_borrow<py::object>(source));
    const py::object type = knownClass("KeyPoint");
    const Names names;
    std::vector<cv::KeyPoint> points;
    points.reserve(items.size());
    for (size_t i = 0; i < items.size(); i++)
    {
        PyObject* const item = PyTuple_GET_ITEM(items.ptr(), py::ssize_t(i));
        if (!type || !py::isinstance(item, type))
            throwTypeError(itemName(name, i), brief(item), "a cv2.KeyPoint");
        points.push_back(toKeyPoint(item, names));
    }
    return points;
}

}  // namespace

py::tuple itemsOf(py::handle source, const std::string& name, const char* accepted)
{
    if (!isSequence(source) && !isArrayOfObjects(source))
        throwTypeError(name, brief(source), accepted);
    return py::tuple(py::reinterpret_borrow<py::object>(source));
}

std::string itemName(const std::string& sequence, size_t index)
{
    return sequence + "[" + std::to_string(index) + "]";
}

int valueOf(const IntObject& number, const std::string& name)
{
    int overflow = 0;
    const long long value = PyLong_AsLongLongAndOverflow(number.object.ptr(), &overflow);
    if (overflow || value < INT_MIN || value > INT_MAX)
        CV_Error_(cv::Error::StsOutOfRange,
                  ("%s must be an int of 32 bits, got %s", name.c_str(), brief(number.object).c_str()));
    return int(value);
}

Pixels toImage(py::handle source, const std::string& name)
{
    if (source.is_none())
        return Pixels();
    const py::array array = arrayOf(source, name, "a numpy array");
    const py::ssize_t dims = array.ndim(), channels = dims == 3 ? array.shape(2) : 1;
    const bool isShape = dims == 2 || (dims == 3 && (channels == 1 || channels == 3 || channels == 4));
    if (!isUint8(array) || !isShape || !isSizeOfMat(array))
        rejectArray(
            name, array,
            "uint8 of shape (rows, cols) or (rows, cols, channels) with 1 (grey), 3 (BGR) or 4 (BGRA)");
    return toPixels(array, int(channels));
}

Pixels toMask(py::handle source, const std::string& name)
{
    if (source.is_none())
        return Pixels();
    const py::array array = arrayOf(source, name, "a numpy array or None");
    const bool isShape = array.ndim() == 2 || (array.ndim() == 3 && array.shape(2) == 1);
    if (!(isUint8(array) || array.dtype().kind() == 'b') || !isShape || !isSizeOfMat(array))
        rejectArray(name, array, "uint8 or bool of the image's shape (rows, cols)");
    return toPixels(array, 1);
}

Pixels toDescriptors(py::handle source, const std::string& name)
{
    if (source.is_none())
        return Pixels();
    const py::array array = arrayOf(source, name, "a numpy array or None");
    if (!isUint8(array) || array.ndim() != 2 || !isSizeOfMat(array))
        rejectArray(name, array, "uint8 of shape (n, bytes)");
    Pixels descriptors = toPixels(array, 1);
    if (array.size() == 0)  // keeps the shape of an empty array
        descriptors.mat = cv::Mat(int(array.shape(0)), int(array.shape(1)), CV_8UC1);
    return descriptors;
}

std::vector<Pixels> toImages(py::handle source)
{
    const py::tuple items = itemsOf(source, "images", "a sequence of numpy arrays");
    std::vector<Pixels> images;
    for (size_t i = 0; i < items.size(); i++)
        images.push_back(toImage(items[i], itemName("images", i)));
    return images;
}

std::vector<cv::Mat> matricesOf(const std::vector<Pixels>& pixels)
{
    std::vector<cv::Mat> matrices;
    for (const Pixels& some : pixels)
        matrices.push_back(some.mat);
    return matrices;
}

std::vector<Pixels> toMasks(py::handle source, size_t images)
{
    std::vector<Pixels> masks;
    if (source.is_none())
        return masks;
    const py::tuple items = itemsOf(source, "masks", "a sequence of numpy arrays or None");
    if (items.size() > 0 && items.size() != images)
        CV_Error_(cv::Error::StsBadArg, ("masks must be one for each image or none, got %d for %d images",
                                         int(items.size()), int(images)));
    for (size_t i = 0; i < items.size(); i++)
        masks.push_back(toMask(items[i], itemName("masks", i)));
    return masks;
}

bool isSequence(py::handle object)
{
    PyObject* const ptr = object.ptr();
    return PySequence_Check(ptr) && !PyUnicode_Check(ptr) && !PyObject_CheckBuffer(ptr);
}

py::object toArray(const cv::Mat& mat, const py::dtype& type)
{
    std::unique_ptr<cv::Mat> kept(new cv::Mat(mat));
    const py::capsule owner(kept.get(), [](void* pointer) { delete static_cast<cv::Mat*>(pointer); });
    kept.release();
    return py::array(type, {mat.rows, mat.cols}, {mat.step[0], mat.step[1]}, mat.data, owner);
}

py::object keyPointClass()
{
    return classOfCv2("KeyPoint", "detectAndComputeArrays, which needs no cv2");
}

py::object matchClass()
{
    return classOfCv2("DMatch", "a function whose name ends with Arrays, which needs no cv2");
}

py::dtype keypointDtype()
{
    // Never released, because the interpreter may end first. The import makes the first call.
    static const py::handle dtype = []
    {
        static_assert(sizeof(cv::KeyPoint) == 5 * sizeof(float) + 2 * sizeof(int),
                      "an item of the array is a KeyPoint");
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

KeyPoints toKeyPoints(py::handle source, const std::string& name)
{
    KeyPoints keypoints;
    keypoints.isArray = py::isinstance<py::array>(source) && !isArrayOfObjects(source);
    if (keypoints.isArray)
        keypoints.points = fromArray(py::reinterpret_borrow<py::array>(source), name);
    else if (isSequence(source) || isArrayOfObjects(source))
        keypoints.points = fromSequence(source, name);
    else
        throwTypeError(name, brief(source), ACCEPTED);
    return keypoints;
}

std::vector<KeyPoints> toKeyPointLists(py::handle source, size_t images)
{
    const py::tuple items =
        itemsOf(source, "keypoints", "a sequence of keypoints for each of several images");
    if (items.size() != images)
        CV_Error_(cv::Error::StsBadArg,
                  ("keypoints must be one sequence for each image, got %d for %d images", int(items.size()),
                   int(images)));
    std::vector<KeyPoints> lists;
    for (size_t i = 0; i < items.size(); i++)
        lists.push_back(toKeyPoints(items[i], itemName("keypoints", i)));
    return lists;
}

py::object toPython(KeyPoints&& keypoints)
{
    return keypoints.isArray ? toArray(std::move(keypoints.points)) : toTuple(keypoints.points);
}

py::object toTuple(const std::vector<cv::KeyPoint>& keypoints)
{
    const py::object type = keypoints.empty() ? py::none() : keyPointClass();
    const bool copied = !keypoints.empty() && canBeCopied(type);
    py::tuple result(keypoints.size());
    for (size_t i = 0; i < keypoints.size(); i++)
        result[i] = copied ? copyInto(type, keypoints[i]) : construct(type, keypoints[i]);
    return py::object(std::move(result));
}

py::object toTuple(const py::object& type, const std::vector<cv::DMatch>& matches)
{
    py::tuple result(matches.size());
    for (size_t i = 0; i < matches.size(); i++)
        result[i] = type(matches[i].queryIdx, matches[i].trainIdx, matches[i].imgIdx, matches[i].distance);
    return py::object(std::move(result));
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

}  // namespace aqorb_python
