// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "arguments.hpp"
#include "arrays.hpp"
#include "errors.hpp"
#include "module.hpp"
#include "threads.hpp"

#include <opencv2/aqorb/refinement.hpp>

#include <tuple>
#include <utility>
#include <vector>

namespace aqorb_python
{

using py::arg;

namespace
{

typedef std::vector<cv::DMatch> Matches;
typedef std::pair<std::vector<cv::Point2f>, std::vector<cv::Point2f>> Points;

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

//! Removes matches, and returns the positions of the others.
Points refine(const Pixels& image1, const KeyPoints& keypoints1, const Pixels& image2,
              const KeyPoints& keypoints2, Matches& matches, double minCorrelation, double scaleFactor)
{
    Points points;
    withoutGil(
        [&]
        {
            cv::aqorb::refineMatches(image1.mat, keypoints1.points, image2.mat, keypoints2.points, matches,
                                     points.first, points.second, float(minCorrelation), float(scaleFactor));
        });
    return points;
}

ArrayObject toArray(const std::vector<cv::Point2f>& points)
{
    return {aqorb_python::toArray(cv::Mat(points).reshape(1).clone(), py::dtype::of<float>())
                .attr("reshape")(-1, 2)};
}

std::tuple<MatchTupleObject, ArrayObject, ArrayObject>
refineMatches(const OptionalArrayObject& image1, const KeyPointsObject& keypoints1,
              const OptionalArrayObject& image2, const KeyPointsObject& keypoints2,
              const MatchesObject& given, double minCorrelation, double scaleFactor)
{
    const py::object type = classOfCv2("DMatch", "refineMatchArrays, which needs no cv2");
    const Pixels pixels1 = toImage(image1.object, "image1"), pixels2 = toImage(image2.object, "image2");
    const KeyPoints first = toKeyPoints(keypoints1.object, "keypoints1"),
                    second = toKeyPoints(keypoints2.object, "keypoints2");
    Matches matches = toMatches(given.object);
    const Points points = refine(pixels1, first, pixels2, second, matches, minCorrelation, scaleFactor);
    py::tuple left(matches.size());
    for (size_t i = 0; i < matches.size(); i++)
        left[i] = type(matches[i].queryIdx, matches[i].trainIdx, matches[i].imgIdx, matches[i].distance);
    return std::make_tuple(MatchTupleObject{left}, toArray(points.first), toArray(points.second));
}

std::tuple<ArrayObject, ArrayObject, ArrayObject>
refineMatchArrays(const OptionalArrayObject& image1, const KeyPointsObject& keypoints1,
                  const OptionalArrayObject& image2, const KeyPointsObject& keypoints2,
                  const ArrayObject& pairs, double minCorrelation, double scaleFactor)
{
    const Pixels pixels1 = toImage(image1.object, "image1"), pixels2 = toImage(image2.object, "image2");
    const KeyPoints first = toKeyPoints(keypoints1.object, "keypoints1"),
                    second = toKeyPoints(keypoints2.object, "keypoints2");
    Matches matches = fromPairs(pairs.object, first.points.size(), second.points.size());
    const Points points = refine(pixels1, first, pixels2, second, matches, minCorrelation, scaleFactor);
    py::array_t<int> left({py::ssize_t(matches.size()), py::ssize_t(2)});
    for (size_t i = 0; i < matches.size(); i++)
    {
        left.mutable_at(py::ssize_t(i), 0) = matches[i].queryIdx;
        left.mutable_at(py::ssize_t(i), 1) = matches[i].trainIdx;
    }
    return std::make_tuple(ArrayObject{left}, toArray(points.first), toArray(points.second));
}

}  // namespace

void addRefinement(py::module_& module)
{
    module.def(
        "refineMatches", &refineMatches, arg("image1"), arg("keypoints1"), arg("image2"), arg("keypoints2"),
        arg("matches"), arg("minCorrelation") = .8, arg("scaleFactor") = 1.,
        "Moves the positions of matches to where both images show the same spot, and leaves out wrong\n"
        "matches. Returns the matches that are left, as a tuple, and their positions in image 1 and in\n"
        "image 2, as arrays of float32 of shape (n, 2). Those in image 1 are the keypoints' own. Matches\n"
        "whose aligned patches correlate less than minCorrelation are left out. With -1 none is, and those\n"
        "that cannot be aligned keep the position of the keypoint. scaleFactor is 1 for keypoints of ORB, 5\n"
        "for AKAZE, BRISK and FAST, 6.25 for KAZE and SURF, and 6.75 for SIFT.");
    module.def(
        "refineMatchArrays", &refineMatchArrays, arg("image1"), arg("keypoints1"), arg("image2"),
        arg("keypoints2"), arg("pairs"), arg("minCorrelation") = .8, arg("scaleFactor") = 1.,
        "Does what refineMatches does, for the pairs of indices that matchArrays returns: integers of shape\n"
        "(m, 2). Returns the pairs that are left, int32 of shape (n, 2), and their positions.");
}

}  // namespace aqorb_python
