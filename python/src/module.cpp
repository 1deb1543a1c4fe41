// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// Extension module aqorb._aqorb, and its functions without a detector. The names are those of cv2.aqorb, and a few more
// for numpy.

#include "arguments.hpp"
#include "errors.hpp"
#include "arrays.hpp"
#include "threads.hpp"

#include <opencv2/aqorb.hpp>
#include <opencv2/core/utility.hpp>

#include <string>
#include <utility>

using namespace aqorb_python;

namespace
{

using py::arg;

typedef std::pair<int, int> Size;

cv::Size toSize(const Size& size)
{
    return cv::Size(size.first, size.second);
}

KeyPointsObject retainUniform(const KeyPointsObject& keypoints, const Size& imageSize,
                              const IntObject& npoints)
{
    KeyPoints kept = toKeyPoints(keypoints.object);
    cv::aqorb::retainUniform(kept.points, toSize(imageSize), valueOf(npoints, "npoints"));
    return {toPython(std::move(kept))};
}

double distributionUniformity(const KeyPointsObject& keypoints, const Size& imageSize)
{
    return cv::aqorb::distributionUniformity(toKeyPoints(keypoints.object).points, toSize(imageSize));
}

double distributionOccupancy(const KeyPointsObject& keypoints, const Size& imageSize, const Size& grid)
{
    return cv::aqorb::distributionOccupancy(toKeyPoints(keypoints.object).points, toSize(imageSize),
                                            toSize(grid));
}

double adaptiveFastThreshold(const OptionalArrayObject& image, const OptionalArrayObject& mask)
{
    const Pixels pixels = toImage(image.object), maskPixels = toMask(mask.object);
    double threshold = 0;
    withoutGil([&] { threshold = cv::aqorb::adaptiveFastThreshold(pixels.mat, maskPixels.mat); });
    return threshold;
}

ArrayObject keypointsToArray(const KeyPointsObject& keypoints)
{
    return {toArray(std::move(toKeyPoints(keypoints.object).points))};
}

KeyPointTupleObject keypointsFromArray(const KeyPointsObject& keypoints)
{
    return {toTuple(toKeyPoints(keypoints.object).points)};
}

// Versions, kernels and number of threads of calls.
std::string buildInformation()
{
    std::string kernels = CV_NEON ? "NEON" : CV_SSE2 ? "SSE2" : "plain C++";
#if defined __GNUC__ && defined __x86_64__  // where cmake/AqorbDispatch.cmake compiles others
    if (cv::checkHardwareSupport(CV_CPU_AVX512_SKX))
        kernels = "AVX-512";
    else if (cv::checkHardwareSupport(CV_CPU_AVX2))
        kernels = "AVX2";
#endif
    const int threads = cv::getNumThreads();
    return "aqorb " AQORB_VERSION ", OpenCV " + cv::getVersionString() + ", kernels for " + kernels + ", " +
           std::to_string(threads) + (threads == 1 ? " thread" : " threads");
}

void addFunctions(py::module_& module)
{
    module.def("adaptiveFastThreshold", &adaptiveFastThreshold, arg("image"), arg("mask") = py::none(),
               doc("adaptiveFastThreshold"));
    module.def("distributionUniformity", &distributionUniformity, arg("keypoints"),
               arg("imageSize").noconvert(), doc("distributionUniformity"));
    module.def("distributionOccupancy", &distributionOccupancy, arg("keypoints"),
               arg("imageSize").noconvert(), arg("grid").noconvert() = Size(16, 12),
               doc("distributionOccupancy"));
    module.def("retainUniform", &retainUniform, arg("keypoints"), arg("imageSize").noconvert(),
               arg("npoints"), doc("retainUniform"));
    module.def("keypointsToArray", &keypointsToArray, arg("keypoints"), doc("keypointsToArray"));
    module.def("keypointsFromArray", &keypointsFromArray, arg("keypoints"), doc("keypointsFromArray"));
    module.def(
        "setNumThreads",
        [](const IntObject& nthreads) { aqorb_python::setNumThreads(valueOf(nthreads, "nthreads")); },
        arg("nthreads"), doc("setNumThreads"));
    module.def("getNumThreads", &cv::getNumThreads, doc("getNumThreads"));
}

}  // namespace

const char* aqorb_python::doc(const char* name, int n)
{
    static const char* const docs[][2] = {
#include "docs.inc"
    };
    for (const auto& each : docs)
        if (std::string(each[0]) == name && n-- == 0)
            return each[1];
    throw py::import_error("the stub lacks " + std::string(name));
}

// Renames pybind11's init function: in a subinterpreter it would wait forever for the main interpreter's lock.
#define PyInit__aqorb aqorb_init_in_main_interpreter

#if PYBIND11_VERSION_HEX >= 0x020D0000
PYBIND11_MODULE(_aqorb, module, py::mod_gil_not_used())  // threads.hpp has the locks
#else
PYBIND11_MODULE(_aqorb, module)
#endif
{
    module.doc() = "The compiled part of the package aqorb.";
    module.attr("__version__") = AQORB_VERSION;
    prepareThreads();
    module.def("_build_information", &buildInformation, doc("_build_information"));
    translateErrors();
    module.attr("keypoint_dtype") = keypointDtype();

    addDetector(module);
    addMatching(module);
    addRefinement(module);
    addFunctions(module);
}

#undef PyInit__aqorb

extern "C" PYBIND11_EXPORT PyObject* PyInit__aqorb();

extern "C" PyObject* PyInit__aqorb()
{
    if (PyThreadState_Get()->interp != PyInterpreterState_Main())
    {
        PyErr_SetString(PyExc_ImportError,
                        "aqorb works in Python's main interpreter only, and this is a subinterpreter");
        return nullptr;
    }
    return aqorb_init_in_main_interpreter();
}
