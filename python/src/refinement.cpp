// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "arguments.hpp"
#include "arrays.hpp"
#include "errors.hpp"
#include "threads.hpp"

#include <opencv2/aqorb/refinement.hpp>

#include <cstring>
#include <tuple>
#include <utility>
#include <vector>

namespace aqorb_python
{

using py::arg;

namespace
{

typedef std::vector<cv::DMatch> Matches;

Matches toMatches(py::handle source)
{
    const py::tuple items = itemsOf(source, "matches", "a sequence of cv2.DMatch");
    Matches matches;
    for (const py::handle item : items)
    {
        if (!isInstance(item, "DMatch"))
            throwTypeError(itemName("matches", matches.size()), brief(item), "a cv2.DMatch");
        matches.push_back(cv::DMatch(item.attr("queryIdx").cast<int>(), item.attr("trainIdx").cast<int>(),
                                     item.attr("imgIdx").cast<int>(), item.attr("distance").cast<float>()));
    }
    return matches;
}

Matches fromPairs(py::handle source, size_t keypoints1, size_t keypoints2)
{
    const char* const ACCEPTED = "an array of integers of shape (m, 2)";
    if (!py::isinstance<py::array>(source))
        throwTypeError("pairs", brief(source), ACCEPTED);
    const py::array array = py::reinterpret_borrow<py::array>(source);
    const char kind = array.dtype().kind();
    if ((kind != 'i' && kind != 'u') || array.ndim() != 2 || array.shape(1) != 2)
        rejectArray("pairs", array, ACCEPTED);
    const py::array_t<long long, py::array::forcecast> integers(array);
    const auto pairs = integers.unchecked<2>();
    Matches matches;
    for (py::ssize_t i = 0; i < pairs.shape(0); i++)
    {
        const long long query = pairs(i, 0), train = pairs(i, 1);
        if (query < 0 || query >= (long long)keypoints1 || train < 0 || train >= (long long)keypoints2)
            CV_Error_(cv::Error::StsOutOfRange,
                      ("%s must be indices of the %d keypoints1 and the %d keypoints2, got %lld and %lld",
                       itemName("pairs", size_t(i)).c_str(), int(keypoints1), int(keypoints2), query, train));
        matches.push_back(cv::DMatch(int(query), int(train), 0));
    }
    return matches;
}

//! Images and keypoints of a call.
struct Features
{
    Features(const OptionalArrayObject& image1_, const KeyPointsObject& keypoints1_,
             const OptionalArrayObject& image2_, const KeyPointsObject& keypoints2_)
        : image1(toImage(image1_.object, "image1")),
          image2(toImage(image2_.object, "image2")),
          keypoints1(toKeyPoints(keypoints1_.object, "keypoints1")),
          keypoints2(toKeyPoints(keypoints2_.object, "keypoints2"))
    {
    }

    Pixels image1, image2;
    KeyPoints keypoints1, keypoints2;
};

//! Matches of a call, with their refined positions and deviations.
struct Refined
{
    void refine(const Features& of, double minCorrelation, double scaleFactor)
    {
        withoutGil(
            [&]
            {
                cv::aqorb::refineMatches(of.image1.mat, of.keypoints1.points, of.image2.mat,
                                         of.keypoints2.points, matches, points1, points2, deviations,
                                         float(minCorrelation), float(scaleFactor));
            });
    }
    //! Appends the grown keypoints to those of the features.
    void grow(Features& of, double minCorrelation, double scaleFactor, bool bothWays)
    {
        withoutGil(
            [&]
            {
                cv::aqorb::growMatches(of.image1.mat, of.keypoints1.points, of.image2.mat,
                                       of.keypoints2.points, matches, of.keypoints1.points,
                                       of.keypoints2.points, points1, points2, deviations,
                                       float(minCorrelation), float(scaleFactor), bothWays);
            });
    }

    Matches matches;
    std::vector<cv::Point2f> points1, points2;
    std::vector<float> deviations;
};

ArrayObject toArray(const std::vector<cv::Point2f>& points)
{
    return {aqorb_python::toArray(cv::Mat(points).reshape(1).clone(), py::dtype::of<float>())
                .attr("reshape")(-1, 2)};
}

ArrayObject toArray(const std::vector<float>& deviations)
{
    return {py::array_t<float>(py::ssize_t(deviations.size()), deviations.data())};
}

//! Pairs of indices of matches, with -1 for grown keypoints.
ArrayObject toPairs(const Matches& matches, size_t keypoints1, size_t keypoints2)
{
    py::array_t<int> pairs({py::ssize_t(matches.size()), py::ssize_t(2)});
    const auto orGrown = [](int index, size_t count) { return size_t(index) < count ? index : -1; };
    for (size_t i = 0; i < matches.size(); i++)
    {
        pairs.mutable_at(py::ssize_t(i), 0) = orGrown(matches[i].queryIdx, keypoints1);
        pairs.mutable_at(py::ssize_t(i), 1) = orGrown(matches[i].trainIdx, keypoints2);
    }
    return {pairs};
}

typedef std::tuple<MatchTupleObject, ArrayObject, ArrayObject, ArrayObject> MatchesAndDeviations;
typedef std::tuple<ArrayObject, ArrayObject, ArrayObject, ArrayObject> ArraysAndDeviations;

MatchesAndDeviations
refineMatchesWithDeviations(const OptionalArrayObject& image1, const KeyPointsObject& keypoints1,
                            const OptionalArrayObject& image2, const KeyPointsObject& keypoints2,
                            const MatchesObject& matches, double minCorrelation, double scaleFactor)
{
    const py::object type = classOfCv2("DMatch", "refineMatchArrays, which needs no cv2");
    const Features features(image1, keypoints1, image2, keypoints2);
    Refined refined;
    refined.matches = toMatches(matches.object);
    refined.refine(features, minCorrelation, scaleFactor);
    return std::make_tuple(MatchTupleObject{toTuple(type, refined.matches)}, toArray(refined.points1),
                           toArray(refined.points2), toArray(refined.deviations));
}

std::tuple<MatchTupleObject, ArrayObject, ArrayObject>
refineMatches(const OptionalArrayObject& image1, const KeyPointsObject& keypoints1,
              const OptionalArrayObject& image2, const KeyPointsObject& keypoints2,
              const MatchesObject& matches, double minCorrelation, double scaleFactor)
{
    const MatchesAndDeviations all = refineMatchesWithDeviations(image1, keypoints1, image2, keypoints2,
                                                                 matches, minCorrelation, scaleFactor);
    return std::make_tuple(std::get<0>(all), std::get<1>(all), std::get<2>(all));
}

ArraysAndDeviations
refineMatchArraysWithDeviations(const OptionalArrayObject& image1, const KeyPointsObject& keypoints1,
                                const OptionalArrayObject& image2, const KeyPointsObject& keypoints2,
                                const ArrayObject& pairs, double minCorrelation, double scaleFactor)
{
    const Features features(image1, keypoints1, image2, keypoints2);
    const size_t count1 = features.keypoints1.points.size(), count2 = features.keypoints2.points.size();
    Refined refined;
    refined.matches = fromPairs(pairs.object, count1, count2);
    refined.refine(features, minCorrelation, scaleFactor);
    return std::make_tuple(toPairs(refined.matches, count1, count2), toArray(refined.points1),
                           toArray(refined.points2), toArray(refined.deviations));
}

std::tuple<ArrayObject, ArrayObject, ArrayObject>
refineMatchArrays(const OptionalArrayObject& image1, const KeyPointsObject& keypoints1,
                  const OptionalArrayObject& image2, const KeyPointsObject& keypoints2,
                  const ArrayObject& pairs, double minCorrelation, double scaleFactor)
{
    const ArraysAndDeviations all = refineMatchArraysWithDeviations(image1, keypoints1, image2, keypoints2,
                                                                    pairs, minCorrelation, scaleFactor);
    return std::make_tuple(std::get<0>(all), std::get<1>(all), std::get<2>(all));
}

std::tuple<MatchTupleObject, py::object, py::object, ArrayObject, ArrayObject, ArrayObject>
growMatches(const OptionalArrayObject& image1, const KeyPointsObject& keypoints1,
            const OptionalArrayObject& image2, const KeyPointsObject& keypoints2,
            const MatchesObject& matches, double minCorrelation, double scaleFactor, bool bothWays)
{
    const py::object type = classOfCv2("DMatch", "growMatchArrays, which needs no cv2");
    Features features(image1, keypoints1, image2, keypoints2);
    Refined refined;
    refined.matches = toMatches(matches.object);
    refined.grow(features, minCorrelation, scaleFactor, bothWays);
    return std::make_tuple(MatchTupleObject{toTuple(type, refined.matches)},
                           toPython(std::move(features.keypoints1)), toPython(std::move(features.keypoints2)),
                           toArray(refined.points1), toArray(refined.points2), toArray(refined.deviations));
}

ArraysAndDeviations growMatchArrays(const OptionalArrayObject& image1, const KeyPointsObject& keypoints1,
                                    const OptionalArrayObject& image2, const KeyPointsObject& keypoints2,
                                    const ArrayObject& pairs, double minCorrelation, double scaleFactor,
                                    bool bothWays)
{
    Features features(image1, keypoints1, image2, keypoints2);
    const size_t count1 = features.keypoints1.points.size(), count2 = features.keypoints2.points.size();
    Refined refined;
    refined.matches = fromPairs(pairs.object, count1, count2);
    refined.grow(features, minCorrelation, scaleFactor, bothWays);
    return std::make_tuple(toPairs(refined.matches, count1, count2), toArray(refined.points1),
                           toArray(refined.points2), toArray(refined.deviations));
}

std::tuple<ArrayObject, ArrayObject, ArrayObject>
matchImages(const OptionalArrayObject& image1, const OptionalArrayObject& image2, const IntObject& nfeatures)
{
    const Pixels first = toImage(image1.object, "image1"), second = toImage(image2.object, "image2");
    const int count = valueOf(nfeatures, "nfeatures");
    Refined found;
    withoutGil(
        [&] {
            cv::aqorb::matchImages(first.mat, second.mat, found.points1, found.points2, found.deviations,
                                   count);
        });
    return std::make_tuple(toArray(found.points1), toArray(found.points2), toArray(found.deviations));
}

KeyPointsObject transformKeypoints(const KeyPointsObject& keypoints, const ArrayObject& homography)
{
    const char* const ACCEPTED = "an array of 3 x 3 numbers";
    if (!py::isinstance<py::array>(homography.object))
        throwTypeError("homography", brief(homography.object), ACCEPTED);
    const py::array given = py::reinterpret_borrow<py::array>(homography.object);
    if (given.ndim() != 2 || !std::strchr("fiu", given.dtype().kind()))
        rejectArray("homography", given, ACCEPTED);
    const py::array_t<double, py::array::c_style | py::array::forcecast> numbers(given);
    const cv::Mat matrix(int(numbers.shape(0)), int(numbers.shape(1)), CV_64F,
                         const_cast<double*>(numbers.data()));
    KeyPoints found = toKeyPoints(keypoints.object);
    cv::aqorb::transformKeypoints(found.points, matrix, found.points);
    return {toPython(std::move(found))};
}

}  // namespace

void addRefinement(py::module_& module)
{
    module.def("refineMatches", &refineMatches, arg("image1"), arg("keypoints1"), arg("image2"),
               arg("keypoints2"), arg("matches"), arg("minCorrelation") = .8, arg("scaleFactor") = 1.,
               doc("refineMatches"));
    module.def("refineMatchArrays", &refineMatchArrays, arg("image1"), arg("keypoints1"), arg("image2"),
               arg("keypoints2"), arg("pairs"), arg("minCorrelation") = .8, arg("scaleFactor") = 1.,
               doc("refineMatchArrays"));
    module.def("refineMatchesWithDeviations", &refineMatchesWithDeviations, arg("image1"), arg("keypoints1"),
               arg("image2"), arg("keypoints2"), arg("matches"), arg("minCorrelation"),
               arg("scaleFactor") = 1., doc("refineMatchesWithDeviations"));
    module.def("refineMatchArraysWithDeviations", &refineMatchArraysWithDeviations, arg("image1"),
               arg("keypoints1"), arg("image2"), arg("keypoints2"), arg("pairs"), arg("minCorrelation"),
               arg("scaleFactor") = 1., doc("refineMatchArraysWithDeviations"));
    module.def("growMatches", &growMatches, arg("image1"), arg("keypoints1"), arg("image2"),
               arg("keypoints2"), arg("matches"), arg("minCorrelation") = .8, arg("scaleFactor") = 1.,
               arg("bothWays") = true, doc("growMatches"));
    module.def("growMatchArrays", &growMatchArrays, arg("image1"), arg("keypoints1"), arg("image2"),
               arg("keypoints2"), arg("pairs"), arg("minCorrelation") = .8, arg("scaleFactor") = 1.,
               arg("bothWays") = true, doc("growMatchArrays"));
    module.def("matchImages", &matchImages, arg("image1"), arg("image2"), arg("nfeatures") = 1000,
               doc("matchImages"));
    module.def("transformKeypoints", &transformKeypoints, arg("keypoints"), arg("homography"),
               doc("transformKeypoints"));
}

}  // namespace aqorb_python
