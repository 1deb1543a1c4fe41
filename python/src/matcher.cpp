// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "arguments.hpp"
#include "errors.hpp"
#include "arrays.hpp"
#include "threads.hpp"

#include <opencv2/aqorb.hpp>

#include <pybind11/stl.h>

#include <cmath>
#include <string>
#include <utility>
#include <vector>

namespace aqorb_python
{

using py::arg;

typedef cv::aqorb::HammingMatcher Library;

template <> cv::Ptr<Library> copyOf(const Library& other)
{
    return other.clone(false).dynamicCast<Library>();
}

namespace
{

using aqorb_python::toTuple;
typedef Shared<Library> Matcher;
typedef std::vector<std::vector<cv::DMatch>> MatchLists;

typedef std::pair<ArrayObject, ArrayObject> Arrays;

// Tuple of a tuple of matches for each query.
py::object toTuple(const py::object& type, const MatchLists& lists)
{
    py::tuple result(lists.size());
    for (size_t i = 0; i < lists.size(); i++)
        result[i] = toTuple(type, lists[i]);
    return py::object(std::move(result));
}

// Array of int32 with the elements of a matrix, even without rows.
ArrayObject toIntegers(const cv::Mat& mat, int columns)
{
    return {toArray(mat, py::dtype::of<int>()).attr("reshape")(-1, columns)};
}

// The number, or the default for None.
template <typename T> T toNumber(py::handle source, T byDefault, const char* name, const char* accepted)
{
    if (source.is_none())
        return byDefault;
    const bool isFloat = std::is_floating_point<T>::value;
    const double number =
        isFloat ? PyFloat_AsDouble(source.ptr()) : double(PyNumber_AsSsize_t(source.ptr(), nullptr));
    if (PyErr_Occurred() && !PyErr_ExceptionMatches(PyExc_TypeError))
        throw py::error_already_set();
    const bool isWrong = PyErr_Occurred() || (!isFloat && std::abs(number) > INT_MAX);
    PyErr_Clear();
    if (isWrong)
        throwTypeError(name, brief(source), accepted);
    return T(number);
}

Matcher create(const IntObject& normType, bool crossCheck)
{
    return Matcher(Library::create(valueOf(normType, "normType"), crossCheck));
}

// Access to the settings, because cv::BFMatcher has no getters.
struct Settings : Library
{
    static py::tuple of(const Library& matcher)
    {
        return py::make_tuple(matcher.*&Settings::normType, matcher.*&Settings::crossCheck);
    }
};

void add(Matcher& self, const ImagesObject& descriptors)
{
    const py::tuple items(descriptors.object);
    std::vector<cv::Mat> copies;
    for (size_t i = 0; i < items.size(); i++)
        copies.push_back(toDescriptors(items[i], "descriptors[" + std::to_string(i) + "]").mat.clone());
    self.change([&](Library& library) { library.add(copies); });
}

ArrayTupleObject getTrainDescriptors(const Matcher& self)
{
    const cv::Ptr<Library> library = self.share();
    const std::vector<cv::Mat>& images = library->getTrainDescriptors();
    py::tuple arrays(images.size());
    for (size_t i = 0; i < images.size(); i++)
        arrays[i] = toArray(images[i].clone());
    return {arrays};
}

MatchTupleObject match(const Matcher& self, const OptionalArrayObject& queryDescriptors,
                       const ImageObject& trainDescriptors, const OptionalArrayObject& mask)
{
    const py::object type = matchClass();
    const cv::Ptr<Library> library = self.share();
    const Pixels query = toDescriptors(queryDescriptors.object, "queryDescriptors"),
                 train = toDescriptors(trainDescriptors.object, "trainDescriptors"),
                 allowed = toMask(mask.object);
    std::vector<cv::DMatch> matches;
    withoutGil([&] { library->match(query.mat, train.mat, matches, allowed.mat); });
    return {toTuple(type, matches)};
}

MatchTupleObject matchCollection(const Matcher& self, const OptionalArrayObject& queryDescriptors,
                                 const MasksObject& masks)
{
    const py::object type = matchClass();
    const cv::Ptr<Library> library = self.share();
    const Pixels query = toDescriptors(queryDescriptors.object, "queryDescriptors");
    const std::vector<Pixels> allowed = toMasks(masks.object, library->getTrainDescriptors().size());
    std::vector<cv::DMatch> matches;
    withoutGil([&] { library->match(query.mat, matches, matricesOf(allowed)); });
    return {toTuple(type, matches)};
}

MatchListsObject knnMatch(const Matcher& self, const OptionalArrayObject& queryDescriptors,
                          const ImageObject& trainDescriptors, const IntObject& k,
                          const OptionalArrayObject& mask, bool compactResult)
{
    const py::object type = matchClass();
    const cv::Ptr<Library> library = self.share();
    const Pixels query = toDescriptors(queryDescriptors.object, "queryDescriptors"),
                 train = toDescriptors(trainDescriptors.object, "trainDescriptors"),
                 allowed = toMask(mask.object);
    const int neighbours = valueOf(k, "k");
    MatchLists matches;
    withoutGil([&]
               { library->knnMatch(query.mat, train.mat, matches, neighbours, allowed.mat, compactResult); });
    return {toTuple(type, matches)};
}

MatchListsObject knnMatchCollection(const Matcher& self, const OptionalArrayObject& queryDescriptors,
                                    const IntObject& k, const MasksObject& masks, bool compactResult)
{
    const py::object type = matchClass();
    const cv::Ptr<Library> library = self.share();
    const Pixels query = toDescriptors(queryDescriptors.object, "queryDescriptors");
    const std::vector<Pixels> allowed = toMasks(masks.object, library->getTrainDescriptors().size());
    const int neighbours = valueOf(k, "k");
    MatchLists matches;
    withoutGil([&]
               { library->knnMatch(query.mat, matches, neighbours, matricesOf(allowed), compactResult); });
    return {toTuple(type, matches)};
}

MatchListsObject radiusMatch(const Matcher& self, const OptionalArrayObject& queryDescriptors,
                             const ImageObject& trainDescriptors, float maxDistance,
                             const OptionalArrayObject& mask, bool compactResult)
{
    const py::object type = matchClass();
    const cv::Ptr<Library> library = self.share();
    const Pixels query = toDescriptors(queryDescriptors.object, "queryDescriptors"),
                 train = toDescriptors(trainDescriptors.object, "trainDescriptors"),
                 allowed = toMask(mask.object);
    MatchLists matches;
    withoutGil(
        [&]
        { library->radiusMatch(query.mat, train.mat, matches, maxDistance, allowed.mat, compactResult); });
    return {toTuple(type, matches)};
}

MatchListsObject radiusMatchCollection(const Matcher& self, const OptionalArrayObject& queryDescriptors,
                                       float maxDistance, const MasksObject& masks, bool compactResult)
{
    const py::object type = matchClass();
    const cv::Ptr<Library> library = self.share();
    const Pixels query = toDescriptors(queryDescriptors.object, "queryDescriptors");
    const std::vector<Pixels> allowed = toMasks(masks.object, library->getTrainDescriptors().size());
    MatchLists matches;
    withoutGil(
        [&] { library->radiusMatch(query.mat, matches, maxDistance, matricesOf(allowed), compactResult); });
    return {toTuple(type, matches)};
}

Arrays toArrays(const cv::Mat& pairs, const cv::Mat& distances)
{
    return Arrays(toIntegers(pairs, 2), {toIntegers(distances, 1).object.attr("ravel")()});
}

Arrays matchArrays(const OptionalArrayObject& queryDescriptors, const OptionalArrayObject& trainDescriptors,
                   const OptionalFloatObject& ratio, bool crossCheck, const OptionalIntObject& maxDistance,
                   const IntObject& normType)
{
    const Pixels query = toDescriptors(queryDescriptors.object, "queryDescriptors"),
                 train = toDescriptors(trainDescriptors.object, "trainDescriptors");
    const double limit = toNumber(ratio.object, 0., "ratio", "a float or None");
    const int longest = toNumber(maxDistance.object, -1, "maxDistance", "an int or None");
    const int norm = valueOf(normType, "normType");
    cv::Mat pairs, distances;
    withoutGil(
        [&] {
            cv::aqorb::matchArrays(query.mat, train.mat, pairs, distances, limit, crossCheck, longest, norm);
        });
    return toArrays(pairs, distances);
}

Arrays knnMatchArrays(const OptionalArrayObject& queryDescriptors,
                      const OptionalArrayObject& trainDescriptors, const IntObject& k,
                      const IntObject& normType)
{
    const Pixels query = toDescriptors(queryDescriptors.object, "queryDescriptors"),
                 train = toDescriptors(trainDescriptors.object, "trainDescriptors");
    const int neighbours = valueOf(k, "k"), norm = valueOf(normType, "normType");
    cv::Mat indices, distances;
    withoutGil([&]
               { cv::aqorb::knnMatchArrays(query.mat, train.mat, indices, distances, neighbours, norm); });
    return Arrays(toIntegers(indices, neighbours), toIntegers(distances, neighbours));
}

typedef py::array_t<float, py::array::c_style | py::array::forcecast> Floats;
typedef py::array_t<double, py::array::c_style | py::array::forcecast> Doubles;

std::vector<cv::Point2f> toPositions(const Floats& array)
{
    const py::ssize_t dims = array.ndim();
    const bool isShape = (dims == 2 || (dims == 3 && array.shape(1) == 1)) && array.shape(dims - 1) == 2;
    if (array.size() > 0 && !isShape)
        rejectArray("predicted", array, "an array of numbers of shape (n, 2) or, as in cv2, (n, 1, 2)");
    const cv::Point2f* const first = reinterpret_cast<const cv::Point2f*>(array.data());
    return std::vector<cv::Point2f>(first, first + array.size() / 2);
}

Arrays matchByPosition(const OptionalArrayObject& queryDescriptors, const Floats& predicted,
                       const OptionalArrayObject& trainDescriptors, const KeyPointsObject& trainKeypoints,
                       const std::pair<float, float>& reach, const OptionalFloatObject& ratio,
                       bool crossCheck, const OptionalIntObject& maxDistance, const IntObject& normType)
{
    const Pixels query = toDescriptors(queryDescriptors.object, "queryDescriptors"),
                 train = toDescriptors(trainDescriptors.object, "trainDescriptors");
    const std::vector<cv::Point2f> positions = toPositions(predicted);
    const KeyPoints keypoints = toKeyPoints(trainKeypoints.object, "trainKeypoints");
    const cv::Size2f window(reach.first, reach.second);
    const double limit = toNumber(ratio.object, 0., "ratio", "a float or None");
    const int longest = toNumber(maxDistance.object, -1, "maxDistance", "an int or None");
    const int norm = valueOf(normType, "normType");
    cv::Mat pairs, distances;
    withoutGil(
        [&]
        {
            cv::aqorb::matchByPosition(query.mat, positions, train.mat, keypoints.points, window, pairs,
                                       distances, limit, crossCheck, longest, norm);
        });
    return toArrays(pairs, distances);
}

Arrays matchGuided(const OptionalArrayObject& queryDescriptors, const KeyPointsObject& queryKeypoints,
                   const OptionalArrayObject& trainDescriptors, const KeyPointsObject& trainKeypoints,
                   const Doubles& F, float reach, const OptionalFloatObject& ratio,
                   const OptionalIntObject& maxDistance, const IntObject& normType)
{
    const Pixels query = toDescriptors(queryDescriptors.object, "queryDescriptors"),
                 train = toDescriptors(trainDescriptors.object, "trainDescriptors");
    const KeyPoints queries = toKeyPoints(queryKeypoints.object, "queryKeypoints"),
                    trains = toKeyPoints(trainKeypoints.object, "trainKeypoints");
    if (F.ndim() != 2 || F.shape(0) != 3 || F.shape(1) != 3)
        rejectArray("F", F, "an array of numbers of shape (3, 3)");
    const cv::Matx33d fundamental(F.data());
    const double limit = toNumber(ratio.object, 0., "ratio", "a float or None");
    const int longest = toNumber(maxDistance.object, -1, "maxDistance", "an int or None");
    const int norm = valueOf(normType, "normType");
    cv::Mat matches, distances;
    withoutGil(
        [&]
        {
            cv::aqorb::matchGuided(query.mat, queries.points, train.mat, trains.points, fundamental, reach,
                                   matches, distances, limit, longest, norm);
        });
    return toArrays(matches, distances);
}

void addMatcher(py::module_& module)
{
    py::class_<Matcher> matcher(
        module, "HammingMatcher",
        "A brute-force matcher of binary descriptors with the matches of cv2.BFMatcher for\n"
        "NORM_HAMMING and NORM_HAMMING2, but faster. It has the methods of cv2.BFMatcher, except\n"
        "those for files. Methods that match release the GIL.");
    matcher.attr("__module__") = "aqorb";
    matcher
        .def(py::init(&create), arg("normType") = int(cv::NORM_HAMMING), arg("crossCheck") = false,
             "Creates a matcher with the parameters of cv2.BFMatcher.")
        .def_static("create", &create, arg("normType") = int(cv::NORM_HAMMING), arg("crossCheck") = false,
                    doc("create", 1))
        .def("match", &match, arg("queryDescriptors"), arg("trainDescriptors"), arg("mask") = py::none(),
             doc("match"))
        .def("match", &matchCollection, arg("queryDescriptors"), arg("masks") = py::none(), doc("match", 1))
        .def("knnMatch", &knnMatch, arg("queryDescriptors"), arg("trainDescriptors"), arg("k"),
             arg("mask") = py::none(), arg("compactResult") = false, doc("knnMatch"))
        .def("knnMatch", &knnMatchCollection, arg("queryDescriptors"), arg("k"), arg("masks") = py::none(),
             arg("compactResult") = false, doc("knnMatch", 1))
        .def("radiusMatch", &radiusMatch, arg("queryDescriptors"), arg("trainDescriptors"),
             arg("maxDistance"), arg("mask") = py::none(), arg("compactResult") = false, doc("radiusMatch"))
        .def("radiusMatch", &radiusMatchCollection, arg("queryDescriptors"), arg("maxDistance"),
             arg("masks") = py::none(), arg("compactResult") = false, doc("radiusMatch", 1))
        .def("add", &add, arg("descriptors"), doc("add"))
        .def("getTrainDescriptors", &getTrainDescriptors, doc("getTrainDescriptors"))
        .def(
            "clear", [](Matcher& self) { self.change([](Library& library) { library.clear(); }); },
            doc("clear", 1))
        .def(
            "empty", [](const Matcher& self) { return self.share()->empty(); }, doc("empty", 1))
        .def(
            "train", [](const Matcher&) {}, doc("train"))
        .def(
            "isMaskSupported", [](const Matcher&) { return true; }, doc("isMaskSupported"))
        .def(
            "clone",
            [](const Matcher& self, bool emptyTrainData)
            { return Matcher(self.share()->clone(emptyTrainData).dynamicCast<Library>()); },
            arg("emptyTrainData") = false, doc("clone"))
        // For pickle and copy, in all protocols.
        .def("__reduce__",
             [](const py::object& self)
             {
                 const Matcher& object = self.cast<const Matcher&>();
                 const py::tuple arguments =
                     py::make_tuple(self.attr("__class__"), Settings::of(*object.share()),
                                    getTrainDescriptors(object).object);
                 return py::make_tuple(py::module_::import("aqorb").attr("_matcher"), arguments);
             });
    module.attr("HammingMatcher_create") = matcher.attr("create");
}

}  // namespace

void addMatching(py::module_& module)
{
    addMatcher(module);
    module.def("matchArrays", &matchArrays, arg("queryDescriptors"), arg("trainDescriptors"),
               arg("ratio") = py::none(), arg("crossCheck") = true, arg("maxDistance") = py::none(),
               arg("normType") = int(cv::NORM_HAMMING), doc("matchArrays"));
    module.def("knnMatchArrays", &knnMatchArrays, arg("queryDescriptors"), arg("trainDescriptors"), arg("k"),
               arg("normType") = int(cv::NORM_HAMMING), doc("knnMatchArrays"));
    module.def("matchByPosition", &matchByPosition, arg("queryDescriptors"), arg("predicted"),
               arg("trainDescriptors"), arg("trainKeypoints"), arg("reach"), arg("ratio") = py::none(),
               arg("crossCheck") = true, arg("maxDistance") = py::none(),
               arg("normType") = int(cv::NORM_HAMMING), doc("matchByPosition"));
    module.def("matchGuided", &matchGuided, arg("queryDescriptors"), arg("queryKeypoints"),
               arg("trainDescriptors"), arg("trainKeypoints"), arg("F"), arg("reach"), arg("ratio") = .9,
               arg("maxDistance") = py::none(), arg("normType") = int(cv::NORM_HAMMING), doc("matchGuided"));
}

}  // namespace aqorb_python
