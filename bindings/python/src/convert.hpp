// This file is part of the aqorb project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.

// Arguments and results of the Python package: numpy arrays and cv2.KeyPoint on one side, OpenCV's types on
// the other. cv2 itself is not linked to: its key points are read and made by their attributes.

#ifndef AQORB_PYTHON_CONVERT_HPP
#define AQORB_PYTHON_CONVERT_HPP

#include <opencv2/core.hpp>

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <utility>
#include <vector>

namespace aqorb_python
{

namespace py = pybind11;

//! An 8-bit image of 1, 3 or 4 channels, or an empty one (None). Shares the array's pixels where it can.
struct Image
{
    py::object owner;  // of the pixels
    cv::Mat mat;
};

//! An 8-bit mask of one channel (uint8 or bool), or none (None).
struct Mask
{
    py::object owner;
    cv::Mat mat;
};

//! A sequence of cv2.KeyPoint or an array of keypointDtype(); goes back to Python as what it was.
struct KeyPoints
{
    std::vector<cv::KeyPoint> points;
    bool isArray = false;
};

//! One row a keypoint; None where there are no rows, as in cv2.
struct Descriptors
{
    cv::Mat rows;
};

//! Width and height.
typedef std::pair<int, int> SizeTuple;

//! cv::KeyPoint's members as the fields of an array.
py::dtype keypointDtype();

// Each load returns false for what is of another kind, which makes a TypeError, and throws cv::Exception for
// an array of the wrong contents.
bool load(py::handle source, Image& image);
bool load(py::handle source, Mask& mask);
bool load(py::handle source, KeyPoints& keypoints);

py::object toTuple(const std::vector<cv::KeyPoint>& keypoints);
py::object toArray(std::vector<cv::KeyPoint>&& keypoints);
py::object toArray(const cv::Mat& rows);

}  // namespace aqorb_python

namespace pybind11
{
namespace detail
{

template <> struct type_caster<aqorb_python::Image>
{
    PYBIND11_TYPE_CASTER(aqorb_python::Image, const_name("Optional[numpy.ndarray]"));
    bool load(handle source, bool) { return aqorb_python::load(source, value); }
};

template <> struct type_caster<aqorb_python::Mask>
{
    PYBIND11_TYPE_CASTER(aqorb_python::Mask, const_name("Optional[numpy.ndarray]"));
    bool load(handle source, bool) { return aqorb_python::load(source, value); }
};

template <> struct type_caster<aqorb_python::KeyPoints>
{
    PYBIND11_TYPE_CASTER(aqorb_python::KeyPoints, const_name("Sequence[cv2.KeyPoint]"));
    bool load(handle source, bool) { return aqorb_python::load(source, value); }
    static handle cast(aqorb_python::KeyPoints&& keypoints, return_value_policy, handle)
    {
        return (keypoints.isArray ? aqorb_python::toArray(std::move(keypoints.points))
                                  : aqorb_python::toTuple(keypoints.points))
            .release();
    }
};

template <> struct type_caster<aqorb_python::Descriptors>
{
    PYBIND11_TYPE_CASTER(aqorb_python::Descriptors, const_name("Optional[numpy.ndarray]"));
    static handle cast(const aqorb_python::Descriptors& descriptors, return_value_policy, handle)
    {
        if (descriptors.rows.empty())
            return none().release();
        return aqorb_python::toArray(descriptors.rows).release();
    }
};

}  // namespace detail
}  // namespace pybind11

#endif
