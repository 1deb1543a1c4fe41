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

py::array numbersOf(const ArrayObject& source, const char* name, const char* accepted)
{
    if (!py::isinstance<py::array>(source.object))
        throwTypeError(name, brief(source.object), accepted);
    return py::reinterpret_borrow<py::array>(source.object);
}

// Matches of a call: objects of cv2, or an array of pairs of indices of so many keypoints.
Matches toMatches(const MatchesObject& source, size_t, size_t)
{
    matchClass();
    const py::tuple items = itemsOf(source.object, "matches", "a sequence of cv2.DMatch");
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

Matches toMatches(const ArrayObject& source, size_t keypoints1, size_t keypoints2)
{
    const char* const ACCEPTED = "an array of integers of shape (m, 2)";
    const py::array array = numbersOf(source, "pairs", ACCEPTED);
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

ArrayObject toArray(const std::vector<cv::Point2f>& points)
{
    return {aqorb_python::toArray(cv::Mat(points).reshape(1).clone(), py::dtype::of<float>())
                .attr("reshape")(-1, 2)};
}

//! Results for matches: the positions in both images, and the deviations.
struct Positions
{
    std::tuple<ArrayObject, ArrayObject, ArrayObject> arrays() const
    {
        const py::array_t<float> values(py::ssize_t(deviations.size()), deviations.data());
        return std::make_tuple(toArray(points1), toArray(points2), ArrayObject{values});
    }

    std::vector<cv::Point2f> points1, points2;
    std::vector<float> deviations;
};

//! Arguments and results of a call with matches.
struct Call : Positions
{
    template <typename Given>
    Call(const OptionalArrayObject& image1_, const KeyPointsObject& keypoints1_,
         const OptionalArrayObject& image2_, const KeyPointsObject& keypoints2_, const Given& matches_)
        : image1(toImage(image1_.object, "image1")),
          image2(toImage(image2_.object, "image2")),
          keypoints1(toKeyPoints(keypoints1_.object, "keypoints1")),
          keypoints2(toKeyPoints(keypoints2_.object, "keypoints2")),
          count1(keypoints1.points.size()),
          count2(keypoints2.points.size()),
          matches(toMatches(matches_, count1, count2))
    {
    }
    //! Appends the grown keypoints to the given ones.
    void grow(double minCorrelation, double scaleFactor, bool bothWays)
    {
        withoutGil(
            [&]
            {
                cv::aqorb::growMatches(image1.mat, keypoints1.points, image2.mat, keypoints2.points, matches,
                                       keypoints1.points, keypoints2.points, points1, points2, deviations,
                                       float(minCorrelation), float(scaleFactor), bothWays);
            });
    }

    Pixels image1, image2;
    KeyPoints keypoints1, keypoints2;
    const size_t count1, count2;  // of given keypoints
    Matches matches;
};

//! The remaining matches in the form of the argument.
std::tuple<MatchTupleObject> remaining(const Call& call, const MatchesObject&)
{
    return std::make_tuple(MatchTupleObject{toTuple(matchClass(), call.matches)});
}

//! Pairs of indices, with -1 for grown keypoints.
std::tuple<ArrayObject> remaining(const Call& call, const ArrayObject&)
{
    py::array_t<int> pairs({py::ssize_t(call.matches.size()), py::ssize_t(2)});
    const auto orGrown = [](int index, size_t count) { return size_t(index) < count ? index : -1; };
    for (size_t i = 0; i < call.matches.size(); i++)
    {
        pairs.mutable_at(py::ssize_t(i), 0) = orGrown(call.matches[i].queryIdx, call.count1);
        pairs.mutable_at(py::ssize_t(i), 1) = orGrown(call.matches[i].trainIdx, call.count2);
    }
    return std::make_tuple(ArrayObject{pairs});
}

template <typename Given, typename... Arrays>
using Results = decltype(std::tuple_cat(remaining(std::declval<Call>(), std::declval<Given>()),
                                        std::declval<std::tuple<Arrays...>>()));

template <typename Given>
Results<Given, ArrayObject, ArrayObject, ArrayObject>
refineWithDeviations(const OptionalArrayObject& image1, const KeyPointsObject& keypoints1,
                     const OptionalArrayObject& image2, const KeyPointsObject& keypoints2,
                     const Given& matches, double minCorrelation, double scaleFactor)
{
    Call call(image1, keypoints1, image2, keypoints2, matches);
    withoutGil(
        [&]
        {
            cv::aqorb::refineMatches(call.image1.mat, call.keypoints1.points, call.image2.mat,
                                     call.keypoints2.points, call.matches, call.points1, call.points2,
                                     call.deviations, float(minCorrelation), float(scaleFactor));
        });
    return std::tuple_cat(remaining(call, matches), call.arrays());
}

template <typename Given>
Results<Given, ArrayObject, ArrayObject>
refine(const OptionalArrayObject& image1, const KeyPointsObject& keypoints1,
       const OptionalArrayObject& image2, const KeyPointsObject& keypoints2, const Given& matches,
       double minCorrelation, double scaleFactor)
{
    const auto all =
        refineWithDeviations(image1, keypoints1, image2, keypoints2, matches, minCorrelation, scaleFactor);
    return std::make_tuple(std::get<0>(all), std::get<1>(all), std::get<2>(all));
}

std::tuple<MatchTupleObject, py::object, py::object, ArrayObject, ArrayObject, ArrayObject>
growMatches(const OptionalArrayObject& image1, const KeyPointsObject& keypoints1,
            const OptionalArrayObject& image2, const KeyPointsObject& keypoints2,
            const MatchesObject& matches, double minCorrelation, double scaleFactor, bool bothWays)
{
    Call call(image1, keypoints1, image2, keypoints2, matches);
    call.grow(minCorrelation, scaleFactor, bothWays);
    return std::tuple_cat(
        remaining(call, matches),
        std::make_tuple(toPython(std::move(call.keypoints1)), toPython(std::move(call.keypoints2))),
        call.arrays());
}

Results<ArrayObject, ArrayObject, ArrayObject, ArrayObject>
growMatchArrays(const OptionalArrayObject& image1, const KeyPointsObject& keypoints1,
                const OptionalArrayObject& image2, const KeyPointsObject& keypoints2,
                const ArrayObject& pairs, double minCorrelation, double scaleFactor, bool bothWays)
{
    Call call(image1, keypoints1, image2, keypoints2, pairs);
    call.grow(minCorrelation, scaleFactor, bothWays);
    return std::tuple_cat(remaining(call, pairs), call.arrays());
}

std::tuple<ArrayObject, ArrayObject, ArrayObject>
matchImages(const OptionalArrayObject& image1, const OptionalArrayObject& image2, const IntObject& nfeatures)
{
    const Pixels first = toImage(image1.object, "image1"), second = toImage(image2.object, "image2");
    const int count = valueOf(nfeatures, "nfeatures");
    Positions found;
    withoutGil(
        [&] {
            cv::aqorb::matchImages(first.mat, second.mat, found.points1, found.points2, found.deviations,
                                   count);
        });
    return found.arrays();
}

KeyPointsObject transformKeypoints(const KeyPointsObject& keypoints, const ArrayObject& homography)
{
    const char* const ACCEPTED = "an array of 3 x 3 numbers";
    const py::array given = numbersOf(homography, "homography", ACCEPTED);
    if (given.ndim() != 2 || !std::strchr("fiu", given.dtype().kind()))
        rejectArray("homography", given, ACCEPTED);
    const py::array_t<double, py::array::c_style | py::array::forcecast> numbers(given);
    const cv::Mat matrix(int(numbers.shape(0)), int(numbers.shape(1)), CV_64F,
                         const_cast<double*>(numbers.data()));
    KeyPoints found = toKeyPoints(keypoints.object);
    cv::aqorb::transformKeypoints(found.points, matrix, found.points);
    return {toPython(std::move(found))};
}

//! Adds a function of two images, their keypoints and their matches.
template <typename Function, typename... Further>
void add(py::module_& module, const char* name, Function function, const char* matches,
         const Further&... further)
{
    module.def(name, function, arg("image1"), arg("keypoints1"), arg("image2"), arg("keypoints2"),
               arg(matches), further..., doc(name));
}

}  // namespace

void addRefinement(py::module_& module)
{
    const py::arg needed("minCorrelation");
    const py::arg_v minCorrelation(needed, .8), scaleFactor("scaleFactor", 1.), bothWays("bothWays", true);
    add(module, "refineMatches", &refine<MatchesObject>, "matches", minCorrelation, scaleFactor);
    add(module, "refineMatchArrays", &refine<ArrayObject>, "pairs", minCorrelation, scaleFactor);
    add(module, "refineMatchesWithDeviations", &refineWithDeviations<MatchesObject>, "matches", needed,
        scaleFactor);
    add(module, "refineMatchArraysWithDeviations", &refineWithDeviations<ArrayObject>, "pairs", needed,
        scaleFactor);
    add(module, "growMatches", &growMatches, "matches", minCorrelation, scaleFactor, bothWays);
    add(module, "growMatchArrays", &growMatchArrays, "pairs", minCorrelation, scaleFactor, bothWays);
    module.def("matchImages", &matchImages, arg("image1"), arg("image2"), arg("nfeatures") = 1000,
               doc("matchImages"));
    module.def("transformKeypoints", &transformKeypoints, arg("keypoints"), arg("homography"),
               doc("transformKeypoints"));
}

}  // namespace aqorb_python
