// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// The detector: its methods, signatures and docstrings.

#include "arguments.hpp"
#include "errors.hpp"
#include "arrays.hpp"
#include "module.hpp"
#include "parameter_table.hpp"
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

// None where there are no rows, as in cv2.
OptionalArrayObject toObject(const cv::Mat& descriptors)
{
    if (descriptors.empty())
        return {py::none()};
    return {toArray(descriptors)};
}

// cv2's optional array for the output. Here the output is returned only.
void checkOutput(const OptionalArrayObject& descriptors)
{
    if (!descriptors.object.is_none())
        throwTypeError("descriptors", brief(descriptors.object), "None, as the descriptors are returned");
}

//! What is found in an image.
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

FeatureBatchObject detectAndComputeBatch(const Detector& self, const ImageListObject& images,
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
    py::list points, rows;
    for (size_t i = 0; i < keypoints.size(); i++)
    {
        points.append(toArray(std::move(keypoints[i])));
        if (!descriptors[i].empty())
            rows.append(toArray(descriptors[i]));
    }
    return {py::module_::import("aqorb._feature_batch").attr("join")(points, rows)};
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

//! All parameters as the text of a file of the name, by which a detector is copied and pickled, too.
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
             "Returns the keypoints of an image, as a tuple, and their descriptors, as an array with a row\n"
             "for each, or None if there are none. With a mask, only keypoints at its nonzero pixels are "
             "found.")
        .def("detectAndComputeArrays", &detectAndComputeArrays, arg("image"), arg("mask") = py::none(),
             "Does what detectAndCompute does, without making an object for each keypoint. Returns an array\n"
             "of keypoint_dtype and an array of descriptors of shape (n, 32), also where n is 0. The field\n"
             "'pt' of the first is an array of shape (n, 2).")
        .def("detectAndComputeBatch", &detectAndComputeBatch, arg("images"), arg("masks") = py::none(),
             "Returns the features of several images as a FeatureBatch, which has one array for each field.\n"
             "They are those of detectAndComputeArrays for each image. The images are processed side by "
             "side,\n"
             "each on one thread. There is one mask for each image, or none. An error names the image, as\n"
             "images[3].")
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
        "It has the methods of cv2.ORB, with the same parameters. Outputs are returned, so that\n"
        "descriptors is to be None. Methods that process images release the GIL. Several threads may share\n"
        "a detector: a parameter that one thread sets applies to the calls that begin later.");
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
