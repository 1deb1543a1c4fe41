// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// The extension module aqorb._aqorb: the names, signatures and docstrings. The names are those of cv2.aqorb, which a cv2
// has that was built with the module, and a few more for numpy.

#include "detector.hpp"
#include "errors.hpp"
#include "keypoints.hpp"
#include "matcher.hpp"
#include "parameter_table.hpp"
#include "threads.hpp"

#include <pybind11/stl.h>

#include <string>

using namespace aqorb_python;
using cv::ORB;
using cv::aqorb::AdaptiveQuadtreeORB;
using py::arg;

namespace
{

typedef Detector::Library Library;
typedef py::class_<Detector> DetectorClass;

// What somebody is told who passes another keyword than those of create.
[[noreturn]] void refuseKeyword(const std::string& keyword)
{
    std::string hint;
    py::list names;
#define AQORB_NAME(property, type, name, ...) names.append(#name);
    AQORB_PARAMETERS_OF_ORB(AQORB_NAME)
#undef AQORB_NAME
    const py::list near = py::module_::import("difflib").attr("get_close_matches")(keyword, names, 1);
    if (!near.empty())
        hint = "; did you mean " + near[0].cast<std::string>() + "?";
#define AQORB_HINT(property, type, name, ...) \
    if (keyword == #name)                     \
        hint = "; call set" #property;
    AQORB_OWN_PARAMETERS(AQORB_HINT)
#undef AQORB_HINT
    throw py::type_error("create has no argument " + keyword + hint);
}

#define AQORB_ARGUMENT(property, type, name, ...) const InPython<type>::Argument &name,
Detector create(AQORB_PARAMETERS_OF_ORB(AQORB_ARGUMENT) const py::kwargs& others)
{
    if (!others.empty())
        refuseKeyword(others.begin()->first.cast<std::string>());
    return Detector(
        Library::create(toNumber(nfeatures, "nfeatures"), float(toNumber(scaleFactor, "scaleFactor")),
                        toNumber(nlevels, "nlevels"), toNumber(edgeThreshold, "edgeThreshold"),
                        toNumber(firstLevel, "firstLevel"), toNumber(WTA_K, "WTA_K"),
                        cv::ORB::ScoreType(toNumber(scoreType, "scoreType")),
                        toNumber(patchSize, "patchSize"), toNumber(fastThreshold, "fastThreshold")));
}
#undef AQORB_ARGUMENT

void addCreate(DetectorClass& detector)
{
#define AQORB_DEFAULT(property, type, name, key, byDefault, ...) arg(#name) = byDefault,
    const char* const text =
        "Creates a detector. The parameters are those of cv2.ORB_create, in the same order.\n"
        "The default of edgeThreshold is 16, and fastThreshold scales the adaptive threshold.";
    detector.def_static("create", &create, AQORB_PARAMETERS_OF_ORB(AQORB_DEFAULT) text);
#undef AQORB_DEFAULT
}

void addProcessing(DetectorClass& detector)
{
    detector
        .def("detect", &detect, arg("image"), arg("mask") = py::none(),
             "Returns the keypoints of an image, as a tuple. With a mask, only those at its nonzero pixels.")
        .def(
            "detect", &detectImages, arg("images"), arg("masks") = py::none(),
            "Does the same for several images and returns a list. There is one mask for each image, or none.")
        .def(
            "compute", &compute, arg("image"), arg("keypoints"), arg("descriptors") = py::none(),
            "Computes the descriptors of given keypoints. Returns the keypoints that have one, and an array\n"
            "with a row for each, or None if there are none.")
        .def("compute", &computeImages, arg("images"), arg("keypoints"), arg("descriptors") = py::none(),
             "Does the same for several images and returns a list of each.")
        .def("detectAndCompute", &detectAndCompute, arg("image"), arg("mask") = py::none(),
             arg("descriptors") = py::none(), arg("useProvidedKeypoints") = false,
             "Returns the keypoints of an image, as a tuple, and their descriptors, as an array with a row "
             "for\n"
             "each, or None if there are none. With a mask, only keypoints at its nonzero pixels are found.")
        .def("detectAndComputeArrays", &detectAndComputeArrays, arg("image"), arg("mask") = py::none(),
             "Does what detectAndCompute does, without making an object for each keypoint. Returns an array "
             "of\n"
             "keypoint_dtype and an array of descriptors of shape (n, 32), also where n is 0. The field 'pt' "
             "of\n"
             "the first is an array of shape (n, 2).")
        .def("detectAndComputeBatch", &detectAndComputeBatch, arg("images"), arg("masks") = py::none(),
             "Returns the features of several images as a FeatureBatch, which has one array for each field. "
             "They\n"
             "are those of detectAndComputeArrays for each image. The images are processed side by side, "
             "each on\n"
             "one thread. There is one mask for each image, or none. An error names the image, as images[3].")
        .def("buildPyramid", &buildPyramid, arg("image"),
             "Returns the levels of the pyramid in which keypoints are found, as grey images.")
        .def("releaseMemory", &releaseMemory,
             "Frees the work space that the detector keeps between calls. The next call allocates it anew.");
}

// A default of the table as Python writes it.
std::string literal(std::string byDefault)
{
    if (byDefault == "true")
        return "True";
    return byDefault.back() == 'f' ? byDefault.substr(0, byDefault.size() - 1) : byDefault;
}

void addProperties(DetectorClass& detector)
{
#define AQORB_PROPERTY(property, type, name, key, byDefault, range, text)                           \
    detector.def(                                                                                   \
        "set" #property,                                                                            \
        [](Detector& self, const InPython<type>::Argument& value)                                   \
        {                                                                                           \
            const type number = type(toNumber(value, #name));                                       \
            self.change([=](Library& library) { library.set##property(number); });                  \
        },                                                                                          \
                                                                                                    \
        arg(#name == std::string("nfeatures") ? "maxFeatures" : #key),                              \
        ("Sets " text ". The default is " + literal(#byDefault) + ".").c_str());                    \
    detector.def(                                                                                   \
        "get" #property,                                                                            \
        [](const Detector& self) { return InPython<type>::Result(self.share()->get##property()); }, \
        "Returns " text ".");
    AQORB_PARAMETERS(AQORB_PROPERTY)
#undef AQORB_PROPERTY
}

#define AQORB_GETTER(name) [](const Detector& self) { return self.share()->name(); }

// The other methods of cv2.Feature2D.
void addFeature2D(DetectorClass& detector)
{
    detector
        .def("getDefaultName", AQORB_GETTER(getDefaultName),
             "Returns the name under which parameters are saved.")
        .def("descriptorSize", AQORB_GETTER(descriptorSize),
             "Returns the number of bytes of a descriptor, 32.")
        .def("descriptorType", AQORB_GETTER(descriptorType),
             "Returns the type of a descriptor's elements, cv2.CV_8U.")
        .def("defaultNorm", AQORB_GETTER(defaultNorm),
             "Returns the norm to match with: cv2.NORM_HAMMING, or cv2.NORM_HAMMING2 where WTA_K is 3 or 4.")
        .def("empty", AQORB_GETTER(empty), "Returns False, as there are parameters to write.")
        .def(
            "clear", [](const Detector&) {}, "Does nothing, as that of cv2.ORB.")
        // The functions for files come last, as they say what is accepted where no other overload is meant.
        .def("write", &writeStorage, arg("fs"), arg("name") = "",
             "Writes the parameters to a cv2.FileStorage, under the name if one is given.")
        .def("write", &writeFile, arg("fileName"), "Writes the parameters to an XML, YAML or JSON file.")
        .def("save", &writeFile, arg("fileName"), "Does the same as write(fileName).")
        .def("read", &readNode, arg("fn"),
             "Reads the parameters that the map of a cv2.FileNode has. The others keep their values.")
        .def("read", &readFile, arg("fileName"),
             "Reads the parameters that a file has. The others keep their values.")
        // For pickle and copy. All protocols take it, so that none makes an object without a detector.
        .def("__reduce__",
             [](const Detector& self)
             {
                 const py::object fromText = py::module_::import("aqorb").attr("_from_text");
                 return py::make_tuple(fromText, py::make_tuple(toText(self)));
             });
    reinterpret_cast<PyTypeObject*>(detector.ptr())->tp_new = nullptr;
}

void addFunctions(py::module_& module)
{
    module.def(
        "adaptiveFastThreshold", &adaptiveFastThreshold, arg("image"), arg("mask") = py::none(),
        "Returns the adaptive FAST threshold of an image, equation (7): the variance of its grey values\n"
        "divided by their mean.");
    module.def(
        "distributionUniformity", &distributionUniformity, arg("keypoints"), arg("imageSize"),
        "Returns how uniformly the keypoints of any detector are distributed over an image of (width,\n"
        "height). A lower value is more uniform. Compare equal numbers of keypoints only.");
    module.def(
        "distributionOccupancy", &distributionOccupancy, arg("keypoints"), arg("imageSize"),
        arg("grid") = py::make_tuple(16, 12),
        "Returns the share of the cells of a grid of (columns, rows) that hold at least one keypoint.");
    module.def(
        "retainUniform", &retainUniform, arg("keypoints"), arg("imageSize"), arg("npoints"),
        "Returns the npoints keypoints, of any detector, that are spread best over the image. It prefers\n"
        "high responses, and keeps the order of the keypoints.");
    module.def("keypointsToArray", &keypointsToArray, arg("keypoints"),
               "Returns an array of keypoint_dtype with the values of cv2.KeyPoint objects.");
    module.def("keypointsFromArray", &keypointsFromArray, arg("keypoints"),
               "Returns a tuple of cv2.KeyPoint objects with the values of an array of keypoint_dtype.");
    module.def(
        "setNumThreads", [](const IntObject& nthreads) { cv::setNumThreads(toNumber(nthreads, "nthreads")); },
        arg("nthreads"),
        "Sets the number of threads that a call may use, as cv2.setNumThreads does for cv2. A negative\n"
        "number is the default: the number of processors, or of the variable OPENCV_FOR_THREADS_NUM.");
    module.def("getNumThreads", &cv::getNumThreads, "Returns the number of threads that a call may use.");
}

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
    module.def("_error", &errorClass);
    module.def("_from_text", &fromText);
    module.def("_brief", &brief);
    module.attr("keypoint_dtype") = keypointDtype();

    DetectorClass detector(
        module, "AdaptiveQuadtreeORB",
        "An ORB detector and descriptor whose keypoints are spread uniformly over the image.\n\n"
        "It has the methods of cv2.ORB, with the same parameters. Outputs are returned, so that\n"
        "descriptors is to be None. Methods that process images release the GIL. Several threads may share "
        "a\n"
        "detector: a parameter that one thread sets applies to the calls that begin later.");
    detector.attr("__module__") = "aqorb";
    addCreate(detector);
    addProcessing(detector);
    addProperties(detector);
    addFeature2D(detector);
    module.attr("AdaptiveQuadtreeORB_create") = detector.attr("create");
    module.attr("AdaptiveQuadtreeORB_RANKED_SELECTION") = int(Library::RANKED_SELECTION);
    module.attr("AdaptiveQuadtreeORB_BALANCED_SELECTION") = int(Library::BALANCED_SELECTION);
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
