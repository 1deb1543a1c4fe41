// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "detector.hpp"

#include "errors.hpp"
#include "images.hpp"
#include "keypoints.hpp"
#include "threads.hpp"

namespace aqorb_python
{

namespace
{

cv::Size toSize(const SizeObject& source, const char* name)
{
    int sides[2] = {0, 0};
    const bool isTuple = isSequence(source.object) || py::isinstance<py::array>(source.object);
    bool isPair = isTuple && py::len(source.object) == 2;
    for (int i = 0; isPair && i < 2; i++)
    {
        const py::object side = source.object[py::int_(i)];
        isPair = isInt(side, sides[i]);
    }
    if (!isPair)
        throwTypeError(name, brief(source.object), "a tuple of two ints");
    return cv::Size(sides[0], sides[1]);
}

}  // namespace

KeyPointsObject retainUniform(const KeyPointsObject& keypoints, const SizeObject& imageSize,
                              const IntObject& npoints)
{
    KeyPoints kept = toKeyPoints(keypoints.object);
    cv::aqorb::retainUniform(kept.points, toSize(imageSize, "imageSize"), toNumber(npoints, "npoints"));
    return {toPython(std::move(kept))};
}

double distributionUniformity(const KeyPointsObject& keypoints, const SizeObject& imageSize)
{
    return cv::aqorb::distributionUniformity(toKeyPoints(keypoints.object).points,
                                             toSize(imageSize, "imageSize"));
}

double distributionOccupancy(const KeyPointsObject& keypoints, const SizeObject& imageSize,
                             const SizeObject& grid)
{
    return cv::aqorb::distributionOccupancy(toKeyPoints(keypoints.object).points,
                                            toSize(imageSize, "imageSize"), toSize(grid, "grid"));
}

double adaptiveFastThreshold(const OptionalArrayObject& image, const OptionalArrayObject& mask)
{
    const Pixels pixels = toImage(image.object), maskPixels = toMask(mask.object);
    double threshold = 0;
    withoutGil([&] { threshold = cv::aqorb::adaptiveFastThreshold(pixels.mat, maskPixels.mat); });
    return threshold;
}

ArrayObject keypointsToArray(const KeyPointsObject& keypoints)
{
    return {toArray(std::move(toKeyPoints(keypoints.object).points))};
}

KeyPointTupleObject keypointsFromArray(const KeyPointsObject& keypoints)
{
    return {toTuple(toKeyPoints(keypoints.object).points)};
}

}  // namespace aqorb_python
