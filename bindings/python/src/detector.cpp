// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "detector.hpp"

#include "gil.hpp"
#include "images.hpp"
#include "keypoints.hpp"

namespace aqorb_python
{

namespace
{

typedef Detector::Library Library;

cv::Ptr<Library> copyOf(const Library& other)
{
    const cv::Ptr<Library> copy = Library::create();
    copy->setMaxFeatures(other.getMaxFeatures());
    copy->setScaleFactor(other.getScaleFactor());
    copy->setNLevels(other.getNLevels());
    copy->setEdgeThreshold(other.getEdgeThreshold());
    copy->setFirstLevel(other.getFirstLevel());
    copy->setWTA_K(other.getWTA_K());
    copy->setScoreType(other.getScoreType());
    copy->setPatchSize(other.getPatchSize());
    copy->setFastThreshold(other.getFastThreshold());
    copy->setAdaptiveThreshold(other.getAdaptiveThreshold());
    copy->setMinThresholdRatio(other.getMinThresholdRatio());
    copy->setCellSize(other.getCellSize());
    copy->setMaxDepth(other.getMaxDepth());
    copy->setSelectionType(other.getSelectionType());
    copy->setStrengthWeight(other.getStrengthWeight());
    copy->setRankRadius(other.getRankRadius());
    copy->setOctaveSuppression(other.getOctaveSuppression());
    copy->setSubPixel(other.getSubPixel());
    return copy;
}

KeyPointTupleObject toObject(const std::vector<cv::KeyPoint>& keypoints)
{
    return {toTuple(keypoints)};
}

KeyPointsObject toObject(KeyPoints&& keypoints)
{
    return {toPython(std::move(keypoints))};
}

// None where there are no rows, as in cv2.
OptionalArrayObject toObject(const cv::Mat& descriptors)
{
    if (descriptors.empty())
        return {py::none()};
    return {toArray(descriptors)};
}

}  // namespace

Library& Detector::change()
{
    // The GIL guards the count: no call begins or ends meanwhile.
    if (library.use_count() > 1)
        library = copyOf(*library);
    return *library;
}

KeyPointTupleObject detect(const Detector& self, const ImageObject& image, const OptionalArrayObject& mask)
{
    importKeyPoint();
    const cv::Ptr<Library> library = self.share();
    const Pixels pixels = toImage(image.object), maskPixels = toMask(mask.object);
    std::vector<cv::KeyPoint> keypoints;
    withoutGil([&] { library->detect(pixels.mat, keypoints, maskPixels.mat); });
    return toObject(keypoints);
}

std::vector<KeyPointTupleObject> detectImages(const Detector& self, const ImagesObject& images,
                                              const MasksObject& masks)
{
    importKeyPoint();
    const cv::Ptr<Library> library = self.share();
    const std::vector<Pixels> pixels = toImages(images.object),
                              maskPixels = toMasks(masks.object, pixels.size());
    std::vector<std::vector<cv::KeyPoint>> keypoints(pixels.size());
    withoutGil(
        [&]
        {
            for (size_t i = 0; i < pixels.size(); i++)
                library->detect(pixels[i].mat, keypoints[i],
                                maskPixels.empty() ? cv::Mat() : maskPixels[i].mat);
        });
    std::vector<KeyPointTupleObject> result;
    for (size_t i = 0; i < keypoints.size(); i++)
        result.push_back(toObject(keypoints[i]));
    return result;
}

std::pair<KeyPointsObject, OptionalArrayObject> compute(const Detector& self, const ImageObject& image,
                                                        const KeyPointsObject& keypoints)
{
    const cv::Ptr<Library> library = self.share();
    const Pixels pixels = toImage(image.object);
    KeyPoints computed = toKeyPoints(keypoints.object);
    cv::Mat descriptors;
    withoutGil([&] { library->compute(pixels.mat, computed.points, descriptors); });
    return std::make_pair(toObject(std::move(computed)), toObject(descriptors));
}

std::pair<std::vector<KeyPointsObject>, std::vector<OptionalArrayObject>>
computeImages(const Detector& self, const ImagesObject& images, const KeyPointListsObject& keypoints)
{
    const cv::Ptr<Library> library = self.share();
    const std::vector<Pixels> pixels = toImages(images.object);
    std::vector<KeyPoints> computed = toKeyPointLists(keypoints.object, pixels.size());
    std::vector<cv::Mat> descriptors(pixels.size());
    withoutGil(
        [&]
        {
            for (size_t i = 0; i < pixels.size(); i++)
                library->compute(pixels[i].mat, computed[i].points, descriptors[i]);
        });
    std::pair<std::vector<KeyPointsObject>, std::vector<OptionalArrayObject>> result;
    for (size_t i = 0; i < pixels.size(); i++)
    {
        result.first.push_back(toObject(std::move(computed[i])));
        result.second.push_back(toObject(descriptors[i]));
    }
    return result;
}

std::pair<KeyPointTupleObject, OptionalArrayObject>
detectAndCompute(const Detector& self, const OptionalArrayObject& image, const OptionalArrayObject& mask)
{
    importKeyPoint();
    const cv::Ptr<Library> library = self.share();
    const Pixels pixels = toImage(image.object), maskPixels = toMask(mask.object);
    std::vector<cv::KeyPoint> keypoints;
    cv::Mat descriptors;
    withoutGil([&] { library->detectAndCompute(pixels.mat, maskPixels.mat, keypoints, descriptors); });
    return std::make_pair(toObject(keypoints), toObject(descriptors));
}

std::pair<ArrayObject, ArrayObject> detectAndComputeArrays(const Detector& self,
                                                           const OptionalArrayObject& image,
                                                           const OptionalArrayObject& mask)
{
    const cv::Ptr<Library> library = self.share();
    const Pixels pixels = toImage(image.object), maskPixels = toMask(mask.object);
    std::vector<cv::KeyPoint> keypoints;
    cv::Mat descriptors;
    withoutGil([&] { library->detectAndCompute(pixels.mat, maskPixels.mat, keypoints, descriptors); });
    if (descriptors.empty())
        descriptors.create(0, library->descriptorSize(), CV_8UC1);
    const ArrayObject points = {toArray(std::move(keypoints))}, rows = {toArray(descriptors)};
    return std::make_pair(points, rows);
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

}  // namespace aqorb_python
