// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// Images, masks, descriptors and keypoints as Python objects. The module is not linked to cv2, so it reads and makes
// cv2's keypoints by their attributes.

#ifndef AQORB_PYTHON_ARRAYS_HPP
#define AQORB_PYTHON_ARRAYS_HPP

#include <opencv2/core.hpp>

#include <pybind11/numpy.h>

#include <string>
#include <vector>

namespace aqorb_python
{

namespace py = pybind11;

//! Pixels of an array, shared if a Mat can have its strides, or nothing (None). Not copyable: a copy without the GIL
//! would corrupt the array's reference count.
struct Pixels
{
    Pixels() = default;
    Pixels(Pixels&&) = default;
    Pixels(const Pixels&) = delete;

    cv::Mat mat;
    py::object owner;  // keeps the pixels alive
};

//! 8-bit image of 1, 3 or 4 channels. The argument `name` of these functions is the parameter's name for messages.
Pixels toImage(py::handle source, const std::string& name = "image");
//! Mask of one channel, uint8 or bool.
Pixels toMask(py::handle source, const std::string& name = "mask");

//! Descriptors: uint8 of shape (n, bytes), or None without descriptors.
Pixels toDescriptors(py::handle source, const std::string& name);

std::vector<Pixels> toImages(py::handle source);
std::vector<cv::Mat> matricesOf(const std::vector<Pixels>& pixels);
//! One mask for each of `images` images, or no masks (None or an empty sequence).
std::vector<Pixels> toMasks(py::handle source, size_t images);

//! Whether the object is a sequence such as a list or a tuple, but neither text nor a buffer such as an array.
bool isSequence(py::handle object);

//! Items of a sequence or of an array of objects. A snapshot, because another thread may change a list meanwhile.
py::tuple itemsOf(py::handle source, const std::string& name, const char* accepted);
std::string itemName(const std::string& sequence, size_t index);

//! Array of a matrix's elements.
//! @param type element type of the matrix
py::object toArray(const cv::Mat& mat, const py::dtype& type = py::dtype::of<uchar>());

//! Keypoints of a call. They return to Python in the form of the argument: objects or an array.
struct KeyPoints
{
    std::vector<cv::KeyPoint> points;
    bool isArray = false;
};

//! Class cv2.KeyPoint. Functions that return keypoints first call this, to fail at once without cv2.
py::object keyPointClass();

//! Array type with the members of cv::KeyPoint as fields.
py::dtype keypointDtype();

//! Keypoints of a sequence of cv2.KeyPoint or an array of keypointDtype().
KeyPoints toKeyPoints(py::handle source, const std::string& name = "keypoints");
//! One sequence or array of keypoints for each of `images` images.
std::vector<KeyPoints> toKeyPointLists(py::handle source, size_t images);

py::object toPython(KeyPoints&& keypoints);
py::object toTuple(const std::vector<cv::KeyPoint>& keypoints);

//! Class cv2.DMatch. Functions that return matches first call this, to fail at once without cv2.
py::object matchClass();

//! Tuple of cv2.DMatch, of this class.
py::object toTuple(const py::object& type, const std::vector<cv::DMatch>& matches);
py::object toArray(std::vector<cv::KeyPoint>&& keypoints);

}  // namespace aqorb_python

#endif
