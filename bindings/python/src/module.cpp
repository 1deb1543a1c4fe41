// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// The extension module aqorb._aqorb. The names are those of cv2.aqorb, which a cv2 has that was built with the module,
// and a few more for numpy.

#include "module.hpp"

#include "errors.hpp"
#include "keypoints.hpp"
#include "threads.hpp"

#include <opencv2/core/utility.hpp>

#include <string>

using namespace aqorb_python;

namespace
{

// What calls run with.
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

}  // namespace

// pybind11's function that begins to make the module, under another name: in a subinterpreter it would wait for ever for
// the main interpreter's lock.
#define PyInit__aqorb aqorb_init_in_main_interpreter

#if PYBIND11_VERSION_HEX >= 0x020D0000
PYBIND11_MODULE(_aqorb, module, py::mod_gil_not_used())  // shared.hpp says what is used in its place
#else
PYBIND11_MODULE(_aqorb, module)
#endif
{
    module.doc() = "The compiled part of the package aqorb.";
    module.attr("__version__") = AQORB_VERSION;
    prepareThreads();
    module.def("_build_information", &buildInformation, "What calls run with: versions, kernels, threads.");
    translateErrors();
    module.attr("keypoint_dtype") = keypointDtype();

    addDetector(module);
    addMatching(module);
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
