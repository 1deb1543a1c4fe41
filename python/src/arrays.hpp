// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// Images, masks, descriptors and keypoints as objects of Python. The module is not linked to cv2, so that it reads and
// makes cv2's keypoints by their attributes.

#ifndef AQORB_PYTHON_ARRAYS_HPP
#define AQORB_PYTHON_ARRAYS_HPP

#include <opencv2/core.hpp>

#include <pybind11/numpy.h>

#include <string>
#include <vector>

namespace aqorb_python
{

namespace py = pybind11;

//! The pixels of an array, shared where a Mat can have its strides, or nothing (None). Cannot be copied, as a copy
//! made without the GIL would corrupt the count of the array's references.
struct Pixels
{
    Pixels() = default;
    Pixels(Pixels&&) = default;
    Pixels(const Pixels&) = delete;

    cv::Mat mat;
    py::object owner;  // keeps the pixels alive
};

//! An 8-bit image of 1, 3 or 4 channels. Messages use the name.
Pixels toImage(py::handle source, const std::string& name = "image");
//! An 8-bit mask of one channel, uint8 or bool.
Pixels toMask(py::handle source, const std::string& name = "mask");

//! Descriptors: uint8 of shape (n, bytes), or None for none at all.
Pixels toDescriptors(py::handle source, const std::string& name);

std::vector<Pixels> toImages(py::handle source);
std::vector<cv::Mat> matricesOf(const std::vector<Pixels>& pixels);
//! One mask for each of so many images, or none at all (None or an empty sequence).
std::vector<Pixels> toMasks(py::handle source, size_t images);

//! Whether the object is a sequence of several things: a list or a tuple, but not text, nor a buffer such as an array or a memoryview.
bool isSequence(py::handle object);

//! Its items, or those of an array of objects. It is a snapshot: another thread may change a list while it is read.
py::tuple itemsOf(py::handle source, const std::string& name, const char* accepted);
std::string itemName(const std::string& sequence, size_t index);

//! An array with the matrix's elements, which have that type.
py::object toArray(const cv::Mat& mat, const py::dtype& type = py::dtype::of<uchar>());

//! The keypoints of a call, which go back to Python as what they were: objects or an array.
struct KeyPoints
{
    std::vector<cv::KeyPoint> points;
    bool isArray = false;
};

//! cv2.KeyPoint. Called before a call that will return some begins to work, so that it fails at once without cv2.
py::object keyPointClass();

//! cv::KeyPoint's members as the fields of an array.
py::dtype keypointDtype();

//! From a sequence of cv2.KeyPoint or an array of keypointDtype(). Messages use the name.
KeyPoints toKeyPoints(py::handle source, const std::string& name = "keypoints");
//! One sequence or array of keypoints for each of so many images.
std::vector<KeyPoints> toKeyPointLists(py::handle source, size_t images);

py::object toPython(KeyPoints&& keypoints);
py::object toTuple(const std::vector<cv::KeyPoint>& keypoints);
py::object toArray(std::vector<cv::KeyPoint>&& keypoints);

}  // namespace aqorb_python

#endif
