// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "images.hpp"

#include "errors.hpp"

#include <climits>
#include <memory>

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

// The rows of a Mat may lie apart. Its pixels and channels may not.
bool hasStridesOfMat(const py::array& array, int channels)
{
    const py::ssize_t rows = array.shape(0), cols = array.shape(1);
    return (channels == 1 || array.strides(2) == 1) && (cols == 1 || array.strides(1) == channels) &&
           (rows == 1 || array.strides(0) >= cols * channels);
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

// A snapshot: another thread may change a list while it is read.
py::tuple itemsOf(py::handle source, const std::string& name, const char* accepted)
{
    if (!isSequence(source))
        throwTypeError(name, brief(source), accepted);
    return py::tuple(py::reinterpret_borrow<py::object>(source));
}

std::string itemName(const char* sequence, size_t index)
{
    return sequence + ("[" + std::to_string(index) + "]");
}

}  // namespace

Pixels toImage(py::handle source, const std::string& name)
{
    if (source.is_none())
        return Pixels();
    if (!py::isinstance<py::array>(source))
        throwTypeError(name, brief(source), "a numpy array");
    const py::array array = py::reinterpret_borrow<py::array>(source);
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
    if (!py::isinstance<py::array>(source))
        throwTypeError(name, brief(source), "a numpy array or None");
    const py::array array = py::reinterpret_borrow<py::array>(source);
    const bool isShape = array.ndim() == 2 || (array.ndim() == 3 && array.shape(2) == 1);
    if (!(isUint8(array) || array.dtype().kind() == 'b') || !isShape || !isSizeOfMat(array))
        rejectArray(name, array, "uint8 or bool of the image's shape (rows, cols)");
    return toPixels(array, 1);
}

Pixels toDescriptors(py::handle source, const std::string& name)
{
    if (source.is_none())
        return Pixels();
    if (!py::isinstance<py::array>(source))
        throwTypeError(name, brief(source), "a numpy array or None");
    const py::array array = py::reinterpret_borrow<py::array>(source);
    if (!isUint8(array) || array.ndim() != 2 || !isSizeOfMat(array))
        rejectArray(name, array, "uint8 of shape (n, bytes)");
    Pixels descriptors = toPixels(array, 1);
    if (array.size() == 0)  // none, of a length that is known
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
    return PySequence_Check(ptr) && !py::isinstance<py::array>(object) && !PyUnicode_Check(ptr) &&
           !PyBytes_Check(ptr) && !PyByteArray_Check(ptr);
}

py::array contiguous(const py::array& array)
{
    return py::module_::import("numpy").attr("ascontiguousarray")(array);
}

py::object toArray(const cv::Mat& mat, const py::dtype& type)
{
    std::unique_ptr<cv::Mat> kept(new cv::Mat(mat));
    const py::capsule owner(kept.get(), [](void* pointer) { delete static_cast<cv::Mat*>(pointer); });
    kept.release();
    return py::array(type, {mat.rows, mat.cols}, {mat.step[0], mat.step[1]}, mat.data, owner);
}

}  // namespace aqorb_python
