// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// Keypoints as cv2.KeyPoint objects or as an array. The module is not linked to cv2, so that it reads and makes
// cv2's keypoints by their attributes.

#ifndef AQORB_PYTHON_KEYPOINTS_HPP
#define AQORB_PYTHON_KEYPOINTS_HPP

#include <opencv2/core.hpp>

#include <pybind11/numpy.h>

#include <string>
#include <vector>

namespace aqorb_python
{

namespace py = pybind11;

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
