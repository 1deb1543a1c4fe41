// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "keypoints.hpp"

#include "errors.hpp"
#include "images.hpp"

#include <pybind11/stl.h>

#include <cstring>
#include <memory>
#include <utility>

namespace aqorb_python
{

namespace
{

const char ACCEPTED[] = "a sequence of cv2.KeyPoint or an array of aqorb.keypoint_dtype";

// The attributes of a cv2.KeyPoint, as objects, which are looked up faster.
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

// Such an array is a sequence for cv2, too.
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
    // A snapshot: another thread, or an attribute of an item, may change a list while it is read.
    const py::tuple items(py::reinterpret_borrow<py::object>(source));
    const py::object type = knownClass("KeyPoint");
    const Names names;
    std::vector<cv::KeyPoint> points;
    points.reserve(items.size());
    for (size_t i = 0; i < items.size(); i++)
    {
        PyObject* const item = PyTuple_GET_ITEM(items.ptr(), py::ssize_t(i));
        if (!type || !py::isinstance(item, type))
            throwTypeError(name + "[" + std::to_string(i) + "]", brief(item), "a cv2.KeyPoint");
        points.push_back(toKeyPoint(item, names));
    }
    return points;
}

}  // namespace

py::object keyPointClass()
{
    return classOfCv2("KeyPoint", "detectAndComputeArrays, which needs no cv2");
}

py::dtype keypointDtype()
{
    // Never released, as the interpreter may be gone by then. The import calls this first.
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
    if (!isSequence(source))
        throwTypeError("keypoints", brief(source), "a sequence of keypoints for each of several images");
    const py::tuple items(py::reinterpret_borrow<py::object>(source));
    if (items.size() != images)
        CV_Error_(cv::Error::StsBadArg,
                  ("keypoints must be one sequence for each image, got %d for %d images", int(items.size()),
                   int(images)));
    std::vector<KeyPoints> lists;
    for (size_t i = 0; i < items.size(); i++)
        lists.push_back(toKeyPoints(items[i], "keypoints[" + std::to_string(i) + "]"));
    return lists;
}

py::object toPython(KeyPoints&& keypoints)
{
    return keypoints.isArray ? toArray(std::move(keypoints.points)) : toTuple(keypoints.points);
}

py::object toTuple(const std::vector<cv::KeyPoint>& keypoints)
{
    const py::object type = keypoints.empty() ? py::none() : keyPointClass();
    py::tuple result(keypoints.size());
    for (size_t i = 0; i < keypoints.size(); i++)
    {
        const cv::KeyPoint& keypoint = keypoints[i];
        result[i] = type(keypoint.pt.x, keypoint.pt.y, keypoint.size, keypoint.angle, keypoint.response,
                         keypoint.octave, keypoint.class_id);
    }
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
