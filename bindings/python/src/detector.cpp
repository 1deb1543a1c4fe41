// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "detector.hpp"

#include "errors.hpp"
#include "images.hpp"
#include "keypoints.hpp"
#include "parameter_table.hpp"
#include "threads.hpp"

namespace aqorb_python
{

namespace
{

typedef Detector::Library Library;

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

}  // namespace

cv::Ptr<Library> Detector::copyOf(const Library& other)
{
    const cv::Ptr<Library> copy = Library::create();
#define AQORB_COPY(property, ...) copy->set##property(other.get##property());
    AQORB_PARAMETERS(AQORB_COPY)
#undef AQORB_COPY
    return copy;
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
    std::vector<std::vector<cv::KeyPoint>> keypoints;
    withoutGil([&] { library->detect(matricesOf(pixels), keypoints, matricesOf(maskPixels)); });
    std::vector<KeyPointTupleObject> result;
    for (size_t i = 0; i < keypoints.size(); i++)
        result.push_back(toObject(keypoints[i]));
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
    return std::make_pair(toObject(std::move(computed)), toObject(descriptors));
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
    for (KeyPoints& ofImage : computed)
        points.push_back(std::move(ofImage.points));
    std::vector<cv::Mat> descriptors;
    withoutGil([&] { library->compute(matricesOf(pixels), points, descriptors); });
    std::pair<std::vector<KeyPointsObject>, std::vector<OptionalArrayObject>> result;
    for (size_t i = 0; i < pixels.size(); i++)
    {
        computed[i].points = std::move(points[i]);
        result.first.push_back(toObject(std::move(computed[i])));
        result.second.push_back(toObject(descriptors[i]));
    }
    return result;
}

std::pair<KeyPointTupleObject, OptionalArrayObject>
detectAndCompute(const Detector& self, const OptionalArrayObject& image, const OptionalArrayObject& mask,
                 const OptionalArrayObject& output, const BoolObject& useProvidedKeypoints)
{
    checkOutput(output);
    if (toNumber(useProvidedKeypoints, "useProvidedKeypoints"))
        CV_Error(cv::Error::StsBadArg,
                 "useProvidedKeypoints must be False, got True: the method compute takes keypoints");
    importKeyPoint();
    const Features found(self.share(), image, mask);
    return std::make_pair(toObject(found.keypoints), toObject(found.descriptors));
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

}  // namespace aqorb_python
