// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// The extension module aqorb._aqorb: the names, signatures and docstrings. The names are those of cv2.aqorb, which a cv2
// has that was built with the module, and a few more for numpy.

#include "detector.hpp"
#include "errors.hpp"
#include "functions.hpp"
#include "keypoints.hpp"
#include "storage.hpp"
#include "threads.hpp"

#include <pybind11/stl.h>

#include <string>

using namespace aqorb_python;
using py::arg;

namespace
{

typedef Detector::Library Library;
typedef py::class_<Detector> DetectorClass;

// A getter of the library as one of the package.
template <typename Class, typename T> struct Getter
{
    T (Class::*method)() const;
    T operator()(const Detector& self) const { return (self.get().*method)(); }
};

// A setter of the library as one of the package.
template <typename Class, typename T> struct Setter
{
    void (Class::*method)(T);
    void operator()(Detector& self, T value) const { (self.change().*method)(value); }
};

template <typename Class, typename T> Getter<Class, T> get(T (Class::*method)() const)
{
    return {method};
}

template <typename Class, typename T> Setter<Class, T> set(void (Class::*method)(T))
{
    return {method};
}

int getScoreType(const Detector& self)
{
    return int(self.get().getScoreType());
}

void setScoreType(Detector& self, int scoreType)
{
    self.change().setScoreType(cv::ORB::ScoreType(scoreType));
}

int getSelectionType(const Detector& self)
{
    return int(self.get().getSelectionType());
}

void setSelectionType(Detector& self, int selectionType)
{
    self.change().setSelectionType(Library::SelectionType(selectionType));
}

std::string getDefaultName(const Detector& self)
{
    return self.get().getDefaultName();
}

Detector create(int nfeatures, float scaleFactor, int nlevels, int edgeThreshold, int firstLevel, int WTA_K,
                int scoreType, int patchSize, int fastThreshold)
{
    return Detector(Library::create(nfeatures, scaleFactor, nlevels, edgeThreshold, firstLevel, WTA_K,
                                    cv::ORB::ScoreType(scoreType), patchSize, fastThreshold));
}

// cv2's optional array for the output. Here the output is returned only.
void checkOutput(const OptionalArrayObject& descriptors)
{
    if (!descriptors.object.is_none())
        throwTypeError("descriptors", brief(descriptors.object), "None, as the descriptors are returned,");
}

std::pair<KeyPointsObject, OptionalArrayObject> computeAsCv2(const Detector& self, const ImageObject& image,
                                                             const KeyPointsObject& keypoints,
                                                             const OptionalArrayObject& descriptors)
{
    checkOutput(descriptors);
    return compute(self, image, keypoints);
}

std::pair<std::vector<KeyPointsObject>, std::vector<OptionalArrayObject>>
computeImagesAsCv2(const Detector& self, const ImagesObject& images, const KeyPointListsObject& keypoints,
                   const OptionalArrayObject& descriptors)
{
    checkOutput(descriptors);
    return computeImages(self, images, keypoints);
}

std::pair<KeyPointTupleObject, OptionalArrayObject>
detectAndComputeAsCv2(const Detector& self, const OptionalArrayObject& image, const OptionalArrayObject& mask,
                      const OptionalArrayObject& descriptors, bool useProvidedKeypoints)
{
    checkOutput(descriptors);
    if (useProvidedKeypoints)
        CV_Error(cv::Error::StsBadArg,
                 "useProvidedKeypoints: got True; False is accepted. The method compute "
                 "takes keypoints");
    return detectAndCompute(self, image, mask);
}

void addCreate(DetectorClass& detector)
{
    detector.def_static(
        "create", &create, arg("nfeatures") = 500, arg("scaleFactor") = 1.2f, arg("nlevels") = 8,
        arg("edgeThreshold") = 16, arg("firstLevel") = 0, arg("WTA_K") = 2, arg("scoreType") = 0,
        arg("patchSize") = 31, arg("fastThreshold") = 20,
        "Creates a detector. The parameters are those of cv2.ORB_create, in the same order.\n"
        "The default of edgeThreshold is 16, and fastThreshold scales the adaptive threshold.");
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
            "compute", &computeAsCv2, arg("image"), arg("keypoints"), arg("descriptors") = py::none(),
            "Computes the descriptors of given keypoints. Returns the keypoints that have one, and an array\n"
            "with a row for each, or None if there are none.")
        .def("compute", &computeImagesAsCv2, arg("images"), arg("keypoints"), arg("descriptors") = py::none(),
             "Does the same for several images and returns a list of each.")
        .def("detectAndCompute", &detectAndComputeAsCv2, arg("image"), arg("mask") = py::none(),
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
        .def("buildPyramid", &buildPyramid, arg("image"),
             "Returns the levels of the pyramid in which keypoints are found, as grey images.")
        .def("releaseMemory", &releaseMemory,
             "Frees the work space that the detector keeps between calls. The next call allocates it anew.");
}

void addProperties(DetectorClass& detector)
{
    detector
        .def("setMaxFeatures", set(&Library::setMaxFeatures), arg("maxFeatures"),
             "Sets the number of keypoints to find; default 500.")
        .def("getMaxFeatures", get(&Library::getMaxFeatures), "Returns the number of keypoints to find.")
        .def("setScaleFactor", set(&Library::setScaleFactor), arg("scaleFactor"),
             "Sets the ratio of the sizes of two neighbouring levels of the pyramid; default 1.2.")
        .def("getScaleFactor", get(&Library::getScaleFactor),
             "Returns the ratio of the sizes of two neighbouring levels of the pyramid.")
        .def("setNLevels", set(&Library::setNLevels), arg("nlevels"),
             "Sets the number of levels of the pyramid; default 8.")
        .def("getNLevels", get(&Library::getNLevels), "Returns the number of levels of the pyramid.")
        .def("setEdgeThreshold", set(&Library::setEdgeThreshold), arg("edgeThreshold"),
             "Sets the width, in pixels of each level, of the border without keypoints; default 16.")
        .def("getEdgeThreshold", get(&Library::getEdgeThreshold),
             "Returns the width, in pixels of each level, of the border without keypoints.")
        .def("setFirstLevel", set(&Library::setFirstLevel), arg("firstLevel"),
             "Sets the level of the pyramid that is the image itself; default 0. Lower levels are larger.")
        .def("getFirstLevel", get(&Library::getFirstLevel),
             "Returns the level of the pyramid that is the image itself.")
        .def("setWTA_K", set(&Library::setWTA_K), arg("wta_k"),
             "Sets how many points each element of a descriptor compares: 2, 3 or 4; default 2.")
        .def("getWTA_K", get(&Library::getWTA_K),
             "Returns how many points each element of a descriptor compares.")
        .def("setScoreType", &setScoreType, arg("scoreType"),
             "Sets what a response is: cv2.ORB_HARRIS_SCORE, the default, or cv2.ORB_FAST_SCORE.")
        .def("getScoreType", &getScoreType,
             "Returns what a response is: cv2.ORB_HARRIS_SCORE or cv2.ORB_FAST_SCORE.")
        .def("setPatchSize", set(&Library::setPatchSize), arg("patchSize"),
             "Sets the side, in pixels of a level, of the patch that a descriptor describes; default 31.")
        .def("getPatchSize", get(&Library::getPatchSize),
             "Returns the side, in pixels of a level, of the patch that a descriptor describes.")
        .def("setFastThreshold", set(&Library::setFastThreshold), arg("fastThreshold"),
             "Sets the scale of the adaptive FAST threshold, or the threshold itself where it is not "
             "adaptive.\n"
             "The default, 20, takes equation (7) as it is.")
        .def("getFastThreshold", get(&Library::getFastThreshold),
             "Returns the scale of the adaptive FAST threshold, or the threshold itself.")
        .def("setAdaptiveThreshold", set(&Library::setAdaptiveThreshold), arg("adaptiveThreshold"),
             "Sets whether the FAST threshold adapts to the image; default True.")
        .def("getAdaptiveThreshold", get(&Library::getAdaptiveThreshold),
             "Returns whether the FAST threshold adapts to the image.")
        .def("setMinThresholdRatio", set(&Library::setMinThresholdRatio), arg("minThresholdRatio"),
             "Sets how many times lower the FAST threshold is in cells that would stay empty; >= 1, default "
             "4.")
        .def("getMinThresholdRatio", get(&Library::getMinThresholdRatio),
             "Returns how many times lower the FAST threshold is in cells that would stay empty.")
        .def("setCellSize", set(&Library::setCellSize), arg("cellSize"),
             "Sets the side, in pixels of a level, of the cells in which the lower threshold may apply; >= "
             "8,\n"
             "default 35.")
        .def("getCellSize", get(&Library::getCellSize),
             "Returns the side, in pixels of a level, of the cells in which the lower threshold may apply.")
        .def(
            "setMaxDepth", set(&Library::setMaxDepth), arg("maxDepth"),
            "Sets the depth of the quadtree, 0 to 15. The default, -1, is as deep as the number of features\n"
            "asks for. With 0 corners are chosen by their response alone.")
        .def("getMaxDepth", get(&Library::getMaxDepth), "Returns the depth of the quadtree, or -1.")
        .def(
            "setSelectionType", &setSelectionType, arg("selectionType"),
            "Sets the rule by which the corners of a level are chosen: "
            "AdaptiveQuadtreeORB_RANKED_SELECTION,\n"
            "the default, or AdaptiveQuadtreeORB_BALANCED_SELECTION, the paper's, which gives the keypoints\n"
            "of version 0.1.")
        .def("getSelectionType", &getSelectionType,
             "Returns the rule by which the corners of a level are chosen.")
        .def("setStrengthWeight", set(&Library::setStrengthWeight), arg("strengthWeight"),
             "Sets how much the strength of a corner counts against an even distribution, 0 (most even) to\n"
             "1000 (by strength alone); default 0.15. It has an effect with the ranked selection only.")
        .def("getStrengthWeight", get(&Library::getStrengthWeight),
             "Returns how much the strength of a corner counts against an even distribution.")
        .def(
            "setRankRadius", set(&Library::setRankRadius), arg("rankRadius"),
            "Sets how far around a corner stronger ones are counted, 0 to 16, in units of the mean distance\n"
            "between the features of a level; default 1. It has an effect with the ranked selection only.")
        .def("getRankRadius", get(&Library::getRankRadius),
             "Returns how far around a corner stronger ones are counted.")
        .def("setOctaveSuppression", set(&Library::setOctaveSuppression), arg("octaveSuppression"),
             "Sets how far a keypoint keeps those of other levels away, in pixels of the finer level. The\n"
             "default, -1, is 1.15 / (1 + StrengthWeight) with the ranked selection, which is 1 by default, "
             "and\n"
             "0.5 with the balanced one.")
        .def("getOctaveSuppression", get(&Library::getOctaveSuppression),
             "Returns how far a keypoint keeps those of other levels away, or -1.")
        .def("setSubPixel", set(&Library::setSubPixel), arg("subPixel"),
             "Sets whether positions are refined to a fraction of a pixel; default True.")
        .def("getSubPixel", get(&Library::getSubPixel),
             "Returns whether positions are refined to a fraction of a pixel.");
}

// The other methods of cv2.Feature2D.
void addFeature2D(DetectorClass& detector)
{
    detector.def("getDefaultName", &getDefaultName, "Returns the name under which parameters are saved.")
        .def("descriptorSize", get(&Library::descriptorSize),
             "Returns the number of bytes of a descriptor, 32.")
        .def("descriptorType", get(&Library::descriptorType),
             "Returns the type of a descriptor's elements, cv2.CV_8U.")
        .def("defaultNorm", get(&Library::defaultNorm),
             "Returns the norm to match with: cv2.NORM_HAMMING, or cv2.NORM_HAMMING2 where WTA_K is 3 or 4.")
        .def("empty", get(&Library::empty), "Returns False, as there are parameters to write.")
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
        .def(py::pickle(&toText, &fromText));  // for copy, too
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
        "setNumThreads", &setNumThreads, arg("nthreads"),
        "Sets the number of threads that a call may use, as cv2.setNumThreads does for cv2. A negative\n"
        "number is the default: the number of processors, or of the variable OPENCV_FOR_THREADS_NUM.");
    module.def("getNumThreads", &getNumThreads, "Returns the number of threads that a call may use.");
}

}  // namespace

// pybind11's function that begins to make the module, under another name: in a subinterpreter it would wait for ever for
// the main interpreter's lock.
#define PyInit__aqorb aqorb_init_in_main_interpreter

PYBIND11_MODULE(_aqorb, module)
{
    module.doc() = "The compiled part of the package aqorb.";
    module.attr("__version__") = AQORB_VERSION;
    module.attr("_has_own_opencv") = prepareThreads();
    translateErrors();
    module.def("_error", &errorClass);
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
