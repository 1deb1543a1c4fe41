// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// Class AdaptiveQuadtreeORB: methods, signatures and docstrings.

#include "arguments.hpp"
#include "errors.hpp"
#include "arrays.hpp"
#include "detector/parameter_table.hpp"
#include "threads.hpp"

#include <opencv2/aqorb.hpp>

#include <pybind11/stl.h>

#include <string>
#include <utility>
#include <vector>

namespace aqorb_python
{

using cv::ORB;
using cv::aqorb::AdaptiveQuadtreeORB;
using py::arg;

typedef AdaptiveQuadtreeORB Library;

template <> cv::Ptr<Library> copyOf(const Library& other)
{
    const cv::Ptr<Library> copy = Library::create();
#define AQORB_COPY(property, ...) copy->set##property(other.get##property());
    AQORB_PARAMETERS(AQORB_COPY)
#undef AQORB_COPY
    return copy;
}

namespace
{

typedef Shared<Library> Detector;
typedef py::class_<Detector> DetectorClass;

// Array of descriptors, or None without rows, as in cv2.
OptionalArrayObject toObject(const cv::Mat& descriptors)
{
    if (descriptors.empty())
        return {py::none()};
    return {toArray(descriptors)};
}

// Rejects cv2's optional array for the output: this package only returns outputs.
void checkOutput(const OptionalArrayObject& descriptors)
{
    if (!descriptors.object.is_none())
        throwTypeError("descriptors", brief(descriptors.object),
                       "None, because the call returns descriptors");
}

//! Keypoints and descriptors of an image.
struct Features
{
    Features(const cv::Ptr<Library>& library, const OptionalArrayObject& image,
             const OptionalArrayObject& mask)
    {
        const Pixels pixels = toImage(image.object), maskPixels = toMask(mask.object);
        withoutGil([&] { library->detectAndCompute(pixels.mat, maskPixels.mat, keypoints, descriptors); });
    }
    std::vector<cv::KeyPoint> keypoints;
    cv::Mat descriptors;
};

KeyPointTupleObject detect(const Detector& self, const ImageObject& image, const OptionalArrayObject& mask)
{
    keyPointClass();
    const cv::Ptr<Library> library = self.share();
    const Pixels pixels = toImage(image.object), maskPixels = toMask(mask.object);
    std::vector<cv::KeyPoint> keypoints;
    withoutGil([&] { library->detect(pixels.mat, keypoints, maskPixels.mat); });
    return {toTuple(keypoints)};
}

std::vector<KeyPointTupleObject> detectImages(const Detector& self, const ImagesObject& images,
                                              const MasksObject& masks)
{
    keyPointClass();
    const cv::Ptr<Library> library = self.share();
    const std::vector<Pixels> pixels = toImages(images.object),
                              maskPixels = toMasks(masks.object, pixels.size());
    std::vector<std::vector<cv::KeyPoint>> keypoints;
    withoutGil([&] { library->detect(matricesOf(pixels), keypoints, matricesOf(maskPixels)); });
    std::vector<KeyPointTupleObject> result;
    for (size_t i = 0; i < keypoints.size(); i++)
        result.push_back({toTuple(keypoints[i])});
    return result;
}

std::pair<KeyPointsObject, OptionalArrayObject> compute(const Detector& self, const ImageObject& image,
                                                        const KeyPointsObject& keypoints,
                                                        const OptionalArrayObject& output)
{
    checkOutput(output);
    const cv::Ptr<Library> library = self.share();
    const Pixels pixels = toImage(image.object);
    KeyPoints computed = toKeyPoints(keypoints.object);
    cv::Mat descriptors;
    withoutGil([&] { library->compute(pixels.mat, computed.points, descriptors); });
    return {KeyPointsObject{toPython(std::move(computed))}, toObject(descriptors)};
}

std::pair<std::vector<KeyPointsObject>, std::vector<OptionalArrayObject>>
computeImages(const Detector& self, const ImagesObject& images, const KeyPointListsObject& keypoints,
              const OptionalArrayObject& output)
{
    checkOutput(output);
    const cv::Ptr<Library> library = self.share();
    const std::vector<Pixels> pixels = toImages(images.object);
    std::vector<KeyPoints> computed = toKeyPointLists(keypoints.object, pixels.size());
    std::vector<std::vector<cv::KeyPoint>> points;
    for (KeyPoints& imageKeypoints : computed)
        points.push_back(std::move(imageKeypoints.points));
    std::vector<cv::Mat> descriptors;
    withoutGil([&] { library->compute(matricesOf(pixels), points, descriptors); });
    std::pair<std::vector<KeyPointsObject>, std::vector<OptionalArrayObject>> result;
    for (size_t i = 0; i < pixels.size(); i++)
    {
        computed[i].points = std::move(points[i]);
        result.first.push_back({toPython(std::move(computed[i]))});
        result.second.push_back(toObject(descriptors[i]));
    }
    return result;
}

std::pair<KeyPointTupleObject, OptionalArrayObject>
detectAndCompute(const Detector& self, const OptionalArrayObject& image, const OptionalArrayObject& mask,
                 const OptionalArrayObject& output, bool useProvidedKeypoints)
{
    checkOutput(output);
    if (useProvidedKeypoints)
        CV_Error(cv::Error::StsBadArg,
                 "useProvidedKeypoints must be False, got True: the method compute takes keypoints");
    keyPointClass();
    const Features found(self.share(), image, mask);
    return {KeyPointTupleObject{toTuple(found.keypoints)}, toObject(found.descriptors)};
}

std::pair<ArrayObject, ArrayObject> detectAndComputeArrays(const Detector& self,
                                                           const OptionalArrayObject& image,
                                                           const OptionalArrayObject& mask)
{
    Features found(self.share(), image, mask);
    if (found.descriptors.empty())
        found.descriptors.create(0, self.share()->descriptorSize(), CV_8UC1);
    const ArrayObject points = {toArray(std::move(found.keypoints))}, rows = {toArray(found.descriptors)};
    return std::make_pair(points, rows);
}

// Keypoints and descriptors of several images as lists of arrays, for detectAndComputeBatch in Python. C++ must not call
// it: at the interpreter's exit Python may end a daemon thread in a Python function, and unwind its stack.
std::pair<py::list, py::list> featuresOf(const Detector& self, const ImageListObject& images,
                                         const MasksObject& masks)
{
    const cv::Ptr<Library> library = self.share();
    const std::vector<Pixels> pixels = toImages(images.object),
                              maskPixels = toMasks(masks.object, pixels.size());
    std::vector<std::vector<cv::KeyPoint>> keypoints;
    std::vector<cv::Mat> descriptors;
    withoutGil(
        [&] {
            library->detectAndComputeBatch(matricesOf(pixels), matricesOf(maskPixels), keypoints,
                                           descriptors);
        });
    std::pair<py::list, py::list> result;
    for (size_t i = 0; i < keypoints.size(); i++)
    {
        result.first.append(toArray(std::move(keypoints[i])));
        if (!descriptors[i].empty())
            result.second.append(toArray(descriptors[i]));
    }
    return result;
}

ArrayTupleObject buildPyramid(const Detector& self, const OptionalArrayObject& image)
{
    const cv::Ptr<Library> library = self.share();
    const Pixels pixels = toImage(image.object);
    std::vector<cv::Mat> levels;
    withoutGil([&] { library->buildPyramid(pixels.mat, levels); });
    py::tuple arrays(levels.size());
    for (size_t i = 0; i < levels.size(); i++)
        arrays[i] = toArray(levels[i]);
    return {arrays};
}

void releaseMemory(const Detector& self)
{
    const cv::Ptr<Library> library = self.share();
    withoutGil([&] { library->releaseMemory(); });
}

// Parameters in files and in cv2's storages.

py::object inPython(const char* function)
{
    return py::module_::import("aqorb._storage").attr(function);
}

void readText(Library& library, const std::string& text)
{
    const cv::FileStorage memory(text, cv::FileStorage::READ | cv::FileStorage::MEMORY);
    library.read(memory.root());
}

//! All parameters as the text of a file. The suffix of the name chooses the format.
std::string toText(const Detector& self, const std::string& name = ".yml")
{
    cv::FileStorage memory(name, cv::FileStorage::WRITE | cv::FileStorage::MEMORY);
    self.share()->write(memory);
    return memory.releaseAndGetString();
}

Detector fromText(const std::string& text)
{
    const cv::Ptr<Library> library = Library::create();
    readText(*library, text);
    return Detector(library);
}

void writeFile(const Detector& self, const FileNameObject& fileName)
{
    const py::cpp_function textOf([&](const std::string& name) { return py::bytes(toText(self, name)); });
    inPython("save")(fileName.object, textOf);
}

void readFile(Detector& self, const FileNameObject& fileName)
{
    const py::cpp_function read([&](const std::string& text)
                                { self.change([&](Library& library) { readText(library, text); }); });
    inPython("load")(fileName.object, read);
}

void writeStorage(const Detector& self, const FileStorageObject& storage, const std::string& name)
{
    inPython("write")(toText(self), storage.object, name);
}

void readNode(Detector& self, const FileNodeObject& node)
{
    const std::string given = inPython("read")(node.object).cast<std::string>();
    self.change([&](Library& library) { readText(library, given); });
}

Detector create(const IntObject& nfeatures, double scaleFactor, const IntObject& nlevels,
                const IntObject& edgeThreshold, const IntObject& firstLevel, const IntObject& WTA_K,
                const IntObject& scoreType, const IntObject& patchSize, const IntObject& fastThreshold)
{
    return Detector(
        Library::create(valueOf(nfeatures, "nfeatures"), float(scaleFactor), valueOf(nlevels, "nlevels"),
                        valueOf(edgeThreshold, "edgeThreshold"), valueOf(firstLevel, "firstLevel"),
                        valueOf(WTA_K, "WTA_K"), ORB::ScoreType(valueOf(scoreType, "scoreType")),
                        valueOf(patchSize, "patchSize"), valueOf(fastThreshold, "fastThreshold")));
}

void addCreate(DetectorClass& detector)
{
#define AQORB_DEFAULT(property, type, name, key, byDefault, ...) arg(#name) = byDefault,
    detector.def_static("create", &create, AQORB_PARAMETERS_OF_ORB(AQORB_DEFAULT) doc("create"));
#undef AQORB_DEFAULT
}

void addProcessing(DetectorClass& detector)
{
    detector.def("detect", &detect, arg("image"), arg("mask") = py::none(), doc("detect"))
        .def("detect", &detectImages, arg("images"), arg("masks") = py::none(), doc("detect", 1))
        .def("compute", &compute, arg("image"), arg("keypoints"), arg("descriptors") = py::none(),
             doc("compute"))
        .def("compute", &computeImages, arg("images"), arg("keypoints"), arg("descriptors") = py::none(),
             doc("compute", 2))
        .def("detectAndCompute", &detectAndCompute, arg("image"), arg("mask") = py::none(),
             arg("descriptors") = py::none(), arg("useProvidedKeypoints") = false, doc("detectAndCompute"))
        .def("detectAndComputeArrays", &detectAndComputeArrays, arg("image"), arg("mask") = py::none(),
             doc("detectAndComputeArrays"))
        .def("_features_of", &featuresOf)
        .def("buildPyramid", &buildPyramid, arg("image"), doc("buildPyramid"))
        .def("releaseMemory", &releaseMemory, doc("releaseMemory"));
}

// Python literal of a default in the table.
std::string literal(std::string byDefault)
{
    if (byDefault == "true")
        return "True";
    return byDefault.back() == 'f' ? byDefault.substr(0, byDefault.size() - 1) : byDefault;
}

void addProperties(DetectorClass& detector)
{
#define AQORB_PROPERTY(property, type, name, key, byDefault, range, text)                                    \
    detector.def(                                                                                            \
        "set" #property,                                                                                     \
        [](Detector& self, const Given<type>& given)                                                         \
        {                                                                                                    \
            const InPython<type> value = valueOf(given, #name);                                              \
            self.change([=](Library& library) { library.set##property(type(value)); });                      \
        },                                                                                                   \
        arg(#name == std::string("nfeatures") ? "maxFeatures" : #key),                                       \
        ("Sets " text ". The default is " + literal(#byDefault) + ".").c_str());                             \
    detector.def(                                                                                            \
        "get" #property, [](const Detector& self) { return InPython<type>(self.share()->get##property()); }, \
        "Returns " text ".");
    AQORB_PARAMETERS(AQORB_PROPERTY)
#undef AQORB_PROPERTY
}

#define AQORB_GETTER(name) [](const Detector& self) { return self.share()->name(); }

// The other methods of cv2.Feature2D.
void addFeature2D(DetectorClass& detector)
{
    detector.def("getDefaultName", AQORB_GETTER(getDefaultName), doc("getDefaultName"))
        .def("descriptorSize", AQORB_GETTER(descriptorSize), doc("descriptorSize"))
        .def("descriptorType", AQORB_GETTER(descriptorType), doc("descriptorType"))
        .def("defaultNorm", AQORB_GETTER(defaultNorm), doc("defaultNorm"))
        .def("empty", AQORB_GETTER(empty), doc("empty"))
        .def(
            "clear", [](const Detector&) {}, doc("clear"))
        // Functions for files come last: their message covers arguments that fit no other overload.
        .def("write", &writeStorage, arg("fs"), arg("name") = "", doc("write", 1))
        .def("write", &writeFile, arg("fileName"), doc("write"))
        .def("save", &writeFile, arg("fileName"), doc("save"))
        .def("read", &readNode, arg("fn"), doc("read", 1))
        .def("read", &readFile, arg("fileName"), doc("read"))
        // For pickle and copy, in all protocols: none makes an object without a detector.
        .def("__reduce__",
             [](const Detector& self)
             {
                 const py::object fromText = py::module_::import("aqorb").attr("_from_text");
                 return py::make_tuple(fromText, py::make_tuple(toText(self)));
             });
    reinterpret_cast<PyTypeObject*>(detector.ptr())->tp_new = [](PyTypeObject*, PyObject*,
                                                                 PyObject*) -> PyObject*
    {
        PyErr_SetString(PyExc_TypeError,
                        "AdaptiveQuadtreeORB has no constructor: call aqorb.AdaptiveQuadtreeORB.create "
                        "or aqorb.AdaptiveQuadtreeORB_create, which take the parameters of cv2.ORB_create");
        return nullptr;
    };
}

}  // namespace

void addDetector(py::module_& module)
{
    module.def("_from_text", &fromText);
    DetectorClass detector(
        module, "AdaptiveQuadtreeORB",
        "An ORB detector and descriptor whose keypoints are spread uniformly over the image.\n\n"
        "It has the methods of cv2.ORB, with the same parameters. It returns its outputs, so the\n"
        "argument descriptors must be None. Methods that process images release the GIL. Several\n"
        "threads may share a detector: a parameter set by one thread applies to later calls.");
    detector.attr("__module__") = "aqorb";
    addCreate(detector);
    addProcessing(detector);
    addProperties(detector);
    addFeature2D(detector);
    module.attr("AdaptiveQuadtreeORB_create") = detector.attr("create");
    module.attr("AdaptiveQuadtreeORB_RANKED_SELECTION") = int(Library::RANKED_SELECTION);
    module.attr("AdaptiveQuadtreeORB_QUADTREE_SELECTION") = int(Library::QUADTREE_SELECTION);
}

}  // namespace aqorb_python
