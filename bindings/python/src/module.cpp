// This file is part of the aqorb project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.

// The extension module aqorb._aqorb: the names and signatures that cv2.aqorb has where the module is built
// inside OpenCV, and a few for numpy.

#include "convert.hpp"

#include <opencv2/aqorb.hpp>

#include <memory>
#include <string>

using namespace aqorb_python;
using cv::aqorb::AdaptiveQuadtreeORB;
using py::arg;

namespace
{

typedef AdaptiveQuadtreeORB Detector;
typedef std::shared_ptr<Detector> DetectorPtr;
typedef py::call_guard<py::gil_scoped_release> WithoutGIL;

PyObject* errorType = nullptr;

// aqorb.error: what except cv2.error catches, with its attributes, and a ValueError.
void makeErrorType(py::module_& module)
{
    const py::tuple bases =
        py::make_tuple(py::module_::import("cv2").attr("error"), py::handle(PyExc_ValueError));
    errorType = PyErr_NewExceptionWithDoc(
        "aqorb.error",
        "An argument's value is not accepted; the message names it. A cv2.error and a ValueError.",
        bases.ptr(), nullptr);
    if (!errorType)
        throw py::error_already_set();
    module.attr("error") = py::handle(errorType);
    py::register_local_exception_translator(
        [](std::exception_ptr pointer)
        {
            try
            {
                if (pointer)
                    std::rethrow_exception(pointer);
            }
            catch (const cv::Exception& exception)
            {
                const py::object error = py::handle(errorType)(exception.what());
                error.attr("code") = exception.code;
                error.attr("err") = exception.err;
                error.attr("file") = exception.file;
                error.attr("func") = exception.func;
                error.attr("line") = exception.line;
                error.attr("msg") = exception.msg;
                PyErr_SetObject(errorType, error.ptr());
            }
        });
}

DetectorPtr create(int nfeatures, float scaleFactor, int nlevels, int edgeThreshold, int firstLevel,
                   int WTA_K, int scoreType, int patchSize, int fastThreshold)
{
    return AdaptiveQuadtreeORB::create(nfeatures, scaleFactor, nlevels, edgeThreshold, firstLevel, WTA_K,
                                       cv::ORB::ScoreType(scoreType), patchSize, fastThreshold);
}

KeyPoints detect(Detector& self, const Image& image, const Mask& mask)
{
    KeyPoints keypoints;
    self.detect(image.mat, keypoints.points, mask.mat);
    return keypoints;
}

std::vector<KeyPoints> detectImages(Detector& self, const std::vector<Image>& images,
                                    const std::vector<Mask>& masks)
{
    if (!masks.empty() && masks.size() != images.size())
        CV_Error_(cv::Error::StsBadArg,
                  ("masks: got %d; one an image or none is accepted", int(masks.size())));
    std::vector<KeyPoints> keypoints;
    for (size_t i = 0; i < images.size(); i++)
        keypoints.push_back(detect(self, images[i], masks.empty() ? Mask() : masks[i]));
    return keypoints;
}

std::pair<KeyPoints, Descriptors> compute(Detector& self, const Image& image, KeyPoints keypoints)
{
    Descriptors descriptors;
    self.compute(image.mat, keypoints.points, descriptors.rows);
    return std::make_pair(std::move(keypoints), descriptors);
}

std::pair<std::vector<KeyPoints>, std::vector<Descriptors>>
computeImages(Detector& self, const std::vector<Image>& images, std::vector<KeyPoints> keypoints)
{
    if (keypoints.size() != images.size())
        CV_Error_(cv::Error::StsBadArg,
                  ("keypoints: got %d lists; one an image is accepted", int(keypoints.size())));
    std::vector<Descriptors> descriptors(images.size());
    for (size_t i = 0; i < images.size(); i++)
        self.compute(images[i].mat, keypoints[i].points, descriptors[i].rows);
    return std::make_pair(std::move(keypoints), std::move(descriptors));
}

std::pair<KeyPoints, Descriptors> detectAndCompute(Detector& self, const Image& image, const Mask& mask)
{
    KeyPoints keypoints;
    Descriptors descriptors;
    self.detectAndCompute(image.mat, mask.mat, keypoints.points, descriptors.rows);
    return std::make_pair(std::move(keypoints), descriptors);
}

py::tuple detectAndComputeArrays(Detector& self, const Image& image, const Mask& mask)
{
    std::vector<cv::KeyPoint> keypoints;
    cv::Mat descriptors;
    {
        const py::gil_scoped_release release;
        self.detectAndCompute(image.mat, mask.mat, keypoints, descriptors);
        if (descriptors.empty())
            descriptors.create(0, self.descriptorSize(), CV_8UC1);
    }
    return py::make_tuple(toArray(std::move(keypoints)), toArray(descriptors));
}

py::tuple buildPyramid(const Detector& self, const Image& image)
{
    std::vector<cv::Mat> levels;
    {
        const py::gil_scoped_release release;
        self.buildPyramid(image.mat, levels);
    }
    py::tuple arrays(levels.size());
    for (size_t i = 0; i < levels.size(); i++)
        arrays[i] = toArray(levels[i]);
    return arrays;
}

// A cv2.FileStorage or cv2.FileNode cannot be had as OpenCV's own object without linking to cv2. What is
// written goes through a storage in memory; its nodes are numbers and text only.
void writeStorage(const Detector& self, const py::object& storage, const std::string& name)
{
    cv::FileStorage memory(".yml", cv::FileStorage::WRITE | cv::FileStorage::MEMORY);
    self.write(memory);
    const cv::FileStorage written(memory.releaseAndGetString(),
                                  cv::FileStorage::READ | cv::FileStorage::MEMORY);
    const py::object write = storage.attr("write");
    if (!name.empty())
        storage.attr("startWriteStruct")(name, int(cv::FileNode::MAP));
    for (const cv::FileNode& node : written.root())
    {
        if (node.isInt())
            write(node.name(), int(node));
        else if (node.isReal())
            write(node.name(), double(node));
        else
            write(node.name(), std::string(node));
    }
    if (!name.empty())
        storage.attr("endWriteStruct")();
}

void readNode(Detector& self, const py::object& node)
{
    cv::FileStorage memory(".yml", cv::FileStorage::WRITE | cv::FileStorage::MEMORY);
    for (const py::handle key : node.attr("keys")())
    {
        const std::string name = key.cast<std::string>();
        const py::object value = node.attr("getNode")(name);
        if (value.attr("isInt")().cast<bool>() || value.attr("isReal")().cast<bool>())
            memory.write(name, value.attr("real")().cast<double>());
        else  // the library says which key should have been a number
            memory.write(name, value.attr("string")().cast<std::string>());
    }
    const cv::FileStorage read(memory.releaseAndGetString(), cv::FileStorage::READ | cv::FileStorage::MEMORY);
    self.read(read.root());
}

void writeFile(const Detector& self, const std::string& fileName)
{
    cv::FileStorage storage(fileName, cv::FileStorage::WRITE);
    if (!storage.isOpened())
        CV_Error_(cv::Error::StsError, ("fileName: %s cannot be written", fileName.c_str()));
    self.write(storage);
}

void readFile(Detector& self, const std::string& fileName)
{
    const cv::FileStorage storage(fileName, cv::FileStorage::READ);
    if (!storage.isOpened())
        CV_Error_(cv::Error::StsError, ("fileName: %s cannot be read", fileName.c_str()));
    self.read(storage.root());
}

KeyPoints retainUniform(KeyPoints keypoints, SizeTuple imageSize, int npoints)
{
    cv::aqorb::retainUniform(keypoints.points, cv::Size(imageSize.first, imageSize.second), npoints);
    return keypoints;
}

double distributionUniformity(const KeyPoints& keypoints, SizeTuple imageSize)
{
    return cv::aqorb::distributionUniformity(keypoints.points, cv::Size(imageSize.first, imageSize.second));
}

double distributionOccupancy(const KeyPoints& keypoints, SizeTuple imageSize, SizeTuple grid)
{
    return cv::aqorb::distributionOccupancy(keypoints.points, cv::Size(imageSize.first, imageSize.second),
                                            cv::Size(grid.first, grid.second));
}

double adaptiveFastThreshold(const Image& image, const Mask& mask)
{
    return cv::aqorb::adaptiveFastThreshold(image.mat, mask.mat);
}

}  // namespace

PYBIND11_MODULE(_aqorb, module)
{
    module.doc() = "The compiled part of the package aqorb.";
    makeErrorType(module);
    module.attr("keypoint_dtype") = keypointDtype();

    py::class_<Detector, DetectorPtr> detector(
        module, "AdaptiveQuadtreeORB",
        "ORB detector and descriptor whose keypoints are spread uniformly over the image.\n\n"
        "Has cv2.ORB's methods, except that those for images do not take the output array\n"
        "descriptors. Methods that process images release the GIL; one object may serve several\n"
        "threads, as long as none calls a setter.");
    detector.attr("__module__") = "aqorb";

    detector.def_static("create", &create, arg("nfeatures") = 500, arg("scaleFactor") = 1.2f,
                        arg("nlevels") = 8, arg("edgeThreshold") = 16, arg("firstLevel") = 0,
                        arg("WTA_K") = 2, arg("scoreType") = 0, arg("patchSize") = 31,
                        arg("fastThreshold") = 20,
                        "Creates the detector. The parameters are cv2.ORB_create's, in the same order;\n"
                        "edgeThreshold is 16 by default, and fastThreshold scales the adaptive threshold.");
    module.attr("AdaptiveQuadtreeORB_create") = detector.attr("create");

    // Processing
    detector
        .def("detect", &detect, WithoutGIL(), arg("image"), arg("mask") = py::none(),
             "Keypoints of an image, where the mask, if any, is not zero.")
        .def("detect", &detectImages, WithoutGIL(), arg("images"), arg("masks") = py::tuple(),
             "The same for a sequence of images.")
        .def("compute", &compute, WithoutGIL(), arg("image"), arg("keypoints"),
             "Descriptors of given keypoints. Returns the keypoints that have one, and the\n"
             "descriptors, a row each; None where there are none.")
        .def("compute", &computeImages, WithoutGIL(), arg("images"), arg("keypoints"),
             "The same for a sequence of images.")
        .def("detectAndCompute", &detectAndCompute, WithoutGIL(), arg("image"), arg("mask") = py::none(),
             "Keypoints, as a tuple of cv2.KeyPoint, and descriptors, as an array of a row each; None\n"
             "where there are none.")
        .def("detectAndComputeArrays", &detectAndComputeArrays, arg("image"), arg("mask") = py::none(),
             "As detectAndCompute, without an object for each keypoint: an array of keypoint_dtype,\n"
             "whose field 'pt' is an array of shape (n, 2), and an array of descriptors of shape (n,\n"
             "32), n = 0 included.")
        .def("buildPyramid", &buildPyramid, arg("image"),
             "The levels of the pyramid in which keypoints are found, as grey images.");

    // Properties
    detector.def("setMaxFeatures", &Detector::setMaxFeatures, arg("maxFeatures"))
        .def("getMaxFeatures", &Detector::getMaxFeatures)
        .def("setScaleFactor", &Detector::setScaleFactor, arg("scaleFactor"))
        .def("getScaleFactor", &Detector::getScaleFactor)
        .def("setNLevels", &Detector::setNLevels, arg("nlevels"))
        .def("getNLevels", &Detector::getNLevels)
        .def("setEdgeThreshold", &Detector::setEdgeThreshold, arg("edgeThreshold"),
             "Width in pixels, on each level, of the border without keypoints; default 16.")
        .def("getEdgeThreshold", &Detector::getEdgeThreshold)
        .def("setFirstLevel", &Detector::setFirstLevel, arg("firstLevel"))
        .def("getFirstLevel", &Detector::getFirstLevel)
        .def("setWTA_K", &Detector::setWTA_K, arg("wta_k"))
        .def("getWTA_K", &Detector::getWTA_K)
        .def(
            "setScoreType",
            [](Detector& self, int scoreType) { self.setScoreType(cv::ORB::ScoreType(scoreType)); },
            arg("scoreType"), "cv2.ORB_HARRIS_SCORE or cv2.ORB_FAST_SCORE.")
        .def("getScoreType", [](const Detector& self) { return int(self.getScoreType()); })
        .def("setPatchSize", &Detector::setPatchSize, arg("patchSize"))
        .def("getPatchSize", &Detector::getPatchSize)
        .def("setFastThreshold", &Detector::setFastThreshold, arg("fastThreshold"),
             "Scale of the adaptive FAST threshold, 20 for equation (7) as it is; without\n"
             "setAdaptiveThreshold the threshold itself. Default 20.")
        .def("getFastThreshold", &Detector::getFastThreshold)
        .def("setAdaptiveThreshold", &Detector::setAdaptiveThreshold, arg("adaptiveThreshold"),
             "Whether the FAST threshold is taken from the image; default True.")
        .def("getAdaptiveThreshold", &Detector::getAdaptiveThreshold)
        .def("setMinThresholdRatio", &Detector::setMinThresholdRatio, arg("minThresholdRatio"),
             "How many times lower the FAST threshold is in cells that would stay empty; >= 1, default 4.")
        .def("getMinThresholdRatio", &Detector::getMinThresholdRatio)
        .def("setCellSize", &Detector::setCellSize, arg("cellSize"),
             "Side in pixels of the level of the cells in which the lower threshold may apply; >= 8,\n"
             "default 35.")
        .def("getCellSize", &Detector::getCellSize)
        .def("setMaxDepth", &Detector::setMaxDepth, arg("maxDepth"),
             "Depth of the quadtree, 0 to 15; -1, the default: as deep as the number of features asks for.")
        .def("getMaxDepth", &Detector::getMaxDepth)
        .def("setOctaveSuppression", &Detector::setOctaveSuppression, arg("octaveSuppression"),
             "How far a keypoint keeps others away across levels, in pixels of the finer level; default 0.5.")
        .def("getOctaveSuppression", &Detector::getOctaveSuppression)
        .def("setSubPixel", &Detector::setSubPixel, arg("subPixel"),
             "Whether positions are refined to a fraction of a pixel; default True.")
        .def("getSubPixel", &Detector::getSubPixel);

    // cv2.Feature2D's others
    detector.def("getDefaultName", [](const Detector& self) { return std::string(self.getDefaultName()); })
        .def("descriptorSize", &Detector::descriptorSize)
        .def("descriptorType", &Detector::descriptorType)
        .def("defaultNorm", &Detector::defaultNorm,
             "The norm to match with: cv2.NORM_HAMMING; NORM_HAMMING2 for WTA_K 3 and 4.")
        .def("empty", &Detector::empty)
        .def("write", &writeFile, arg("fileName"), "Writes the parameters to an XML, YAML or JSON file.")
        .def("write", &writeStorage, arg("fs"), arg("name") = "",
             "Writes the parameters to a cv2.FileStorage, under a name if given.")
        .def("save", &writeFile, arg("fileName"), "The same as write(fileName).")
        .def("read", &readFile, arg("fileName"), "Reads the parameters that the file has; the others stay.")
        .def("read", &readNode, arg("fn"), "The same from a cv2.FileNode.");

    module.def(
        "adaptiveFastThreshold", &adaptiveFastThreshold, WithoutGIL(), arg("image"), arg("mask") = py::none(),
        "The adaptive FAST threshold of an image, equation (7): variance over mean of its grey values.");
    module.def("distributionUniformity", &distributionUniformity, WithoutGIL(), arg("keypoints"),
               arg("imageSize"),
               "How uniformly keypoints of any detector are distributed over an image of (width,\n"
               "height); less is more uniform. Compare at equal numbers.");
    module.def("distributionOccupancy", &distributionOccupancy, WithoutGIL(), arg("keypoints"),
               arg("imageSize"), arg("grid") = py::make_tuple(16, 12),
               "The share of the cells of a grid of (columns, rows) that hold at least one keypoint.");
    module.def("retainUniform", &retainUniform, WithoutGIL(), arg("keypoints"), arg("imageSize"),
               arg("npoints"),
               "The npoints keypoints of any detector that are spread best over the image, preferring\n"
               "high responses; in their order.");
    module.def(
        "keypointsToArray", [](KeyPoints keypoints) { return toArray(std::move(keypoints.points)); },
        arg("keypoints"), "An array of keypoint_dtype from cv2.KeyPoint objects.");
    module.def(
        "keypointsFromArray", [](const KeyPoints& keypoints) { return toTuple(keypoints.points); },
        arg("keypoints"), "cv2.KeyPoint objects from an array of keypoint_dtype.");
}
